#pragma once
/// Messages of the Debug Adapter Protocol over file descriptors: a header with the length, then JSON.
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

namespace debugger::dap {

using Json = nlohmann::json;

/// The text of that key, or an empty text.
std::string text_of(const Json& from, std::string_view key);

/// The input is not a message. The stream cannot be read any further.
class BrokenStream : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Collects bytes and returns messages.
class Framing {
 public:
  static constexpr std::size_t longest_header = 4096, longest_message = std::size_t{16} << 20;

  void add(std::string_view bytes) { pending_ += bytes; }
  /// The next whole message; none: more bytes are needed. \throws BrokenStream for a wrong header, or a message that is
  /// too long
  std::optional<std::string> next();
  /// A message has begun and is not complete.
  bool begun() const { return !pending_.empty(); }

 private:
  std::string pending_;
  std::optional<std::size_t> length_;  ///< of the incomplete message
};

std::string framed(const Json& message);

/// A client. A thread of its own reads, so that messages arrive while the machine runs.
class Connection {
 public:
  /// \param in, out open file descriptors; they belong to the caller
  Connection(int in, int out);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits for the next message; none: the client has disconnected.
  std::optional<std::string> receive();
  bool waiting() const;
  /// A waiting message contains one of these texts.
  bool waits_with(const std::vector<std::string_view>& texts) const;
  bool gone() const;
  /// Does nothing if the client has disconnected.
  void send(const Json& message);
  /// Why the stream broke; empty if it did not.
  std::string broken() const;

 private:
  void read_all();

  static constexpr std::size_t most_waiting = std::size_t{64}
                                              << 20;  ///< bytes; beyond, reading stops until messages are taken

  int in_, out_;
  int wake_[2] = {-1, -1};  ///< ends the reading thread
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> messages_;
  std::size_t bytes_ = 0;
  bool gone_ = false, closing_ = false;
  std::string broken_;
  std::thread reader_;
};

}  // namespace debugger::dap
