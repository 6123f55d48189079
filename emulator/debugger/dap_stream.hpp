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

/// The text of that key, or an empty one.
std::string text_of(const Json& from, std::string_view key);

/// What came is no message. The stream cannot be read on.
class BrokenStream : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Takes bytes as they come, gives messages.
class Framing {
 public:
  static constexpr std::size_t longest_header = 4096, longest_message = std::size_t{16} << 20;

  void add(std::string_view bytes) { pending_ += bytes; }
  /// The next whole message; none: more bytes are needed. \throws BrokenStream for a header that is none, or too long a
  /// message
  std::optional<std::string> next();
  /// Something has begun and is not whole.
  bool begun() const { return !pending_.empty(); }

 private:
  std::string pending_;
  std::optional<std::size_t> length_;  ///< of the message under way
};

std::string framed(const Json& message);

/// A client. A thread of its own reads, so that a message is there while the machine runs.
class Connection {
 public:
  /// \param in, out open file descriptors; they stay the caller's
  Connection(int in, int out);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits for the next message; none: the client is gone.
  std::optional<std::string> receive();
  bool waiting() const;
  /// Some message that waits contains one of these texts.
  bool waits_with(const std::vector<std::string_view>& texts) const;
  bool gone() const;
  /// Does nothing when the client is gone.
  void send(const Json& message);
  /// Why the stream broke; empty: it did not.
  std::string broken() const;

 private:
  void read_all();

  static constexpr std::size_t most_waiting = std::size_t{64}
                                              << 20;  ///< bytes; then reading stops until they are taken

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
