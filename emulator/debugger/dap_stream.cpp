#include "debugger/dap_stream.hpp"
#include "isa/ascii.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

namespace debugger::dap {
namespace {

constexpr std::string_view length_field = "content-length:";

/// The length in "Content-Length: 119\r\nOther: x".
std::size_t length_in(std::string_view header) {
  std::optional<std::size_t> length;
  while (!header.empty()) {
    const std::size_t end = std::min(header.find("\r\n"), header.size());
    std::string_view line = header.substr(0, end);
    header.remove_prefix(std::min(end + 2, header.size()));
    if (!ascii::same(line.substr(0, length_field.size()), length_field)) {
      if (line.find(':') == std::string_view::npos)
        throw BrokenStream(
            fmt::format("\"{}\" is not a header; Content-Length: NUMBER is expected", line.substr(0, 40)));
      continue;
    }
    line.remove_prefix(length_field.size());
    while (line.starts_with(' ')) line.remove_prefix(1);
    length = ascii::number<std::size_t>(line);
    if (!length) throw BrokenStream(fmt::format("Content-Length: \"{}\" is not a number", line.substr(0, 40)));
  }
  if (!length) throw BrokenStream("a header without Content-Length");
  if (*length > Framing::longest_message)
    throw BrokenStream(fmt::format("a message of {} bytes; up to {} are possible", *length, Framing::longest_message));
  return *length;
}

}  // namespace

std::string text_of(const Json& from, std::string_view key) {
  const auto found = from.find(key);
  return found != from.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::string> Framing::next() {
  if (!length_) {
    const std::size_t end = pending_.find("\r\n\r\n");
    if (end == std::string::npos) {
      if (pending_.size() > longest_header) throw BrokenStream("a header that does not end");
      return std::nullopt;
    }
    length_ = length_in(std::string_view(pending_).substr(0, end));
    pending_.erase(0, end + 4);
  }
  if (pending_.size() < *length_) return std::nullopt;
  std::string message = pending_.substr(0, *length_);
  pending_.erase(0, *length_);
  length_.reset();
  return message;
}

std::string framed(const Json& message) {
  const std::string text = message.dump(-1, ' ', false, Json::error_handler_t::replace);
  return fmt::format("Content-Length: {}\r\n\r\n{}", text.size(), text);
}

Connection::Connection(int in, int out) : in_(in), out_(out) {
  if (pipe(wake_) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  reader_ = std::thread([this] { read_all(); });
}

Connection::~Connection() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  (void)!write(wake_[1], "x", 1);
  reader_.join();
  close(wake_[0]);
  close(wake_[1]);
}

void Connection::read_all() {
  Framing framing;
  std::array<char, 65536> buffer;
  std::string why;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return bytes_ < most_waiting || closing_; });
      if (closing_) break;
    }
    std::array<pollfd, 2> watched{{{in_, POLLIN, 0}, {wake_[0], POLLIN, 0}}};
    if (poll(watched.data(), watched.size(), -1) < 0) {
      if (errno == EINTR) continue;
      break;
    }
    if (watched[1].revents != 0) break;
    const ssize_t count = read(in_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    framing.add(std::string_view(buffer.data(), static_cast<std::size_t>(count)));
    try {
      while (auto message = framing.next()) {
        const std::lock_guard lock(mutex_);
        bytes_ += message->size();
        messages_.push_back(std::move(*message));
        changed_.notify_all();
      }
    } catch (const BrokenStream& error) {
      why = error.what();
      break;
    }
  }
  const std::lock_guard lock(mutex_);
  broken_ = why;
  gone_ = true;
  changed_.notify_all();
}

std::optional<std::string> Connection::receive() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !messages_.empty() || gone_; });
  if (messages_.empty()) return std::nullopt;
  std::string message = std::move(messages_.front());
  messages_.pop_front();
  bytes_ -= message.size();
  changed_.notify_all();
  return message;
}

bool Connection::waiting() const {
  const std::lock_guard lock(mutex_);
  return !messages_.empty() || gone_;
}

bool Connection::waits_with(const std::vector<std::string_view>& texts) const {
  const std::lock_guard lock(mutex_);
  if (gone_) return true;
  return std::ranges::any_of(messages_, [&](const std::string& message) {
    return std::ranges::any_of(texts, [&](std::string_view text) { return message.find(text) != std::string::npos; });
  });
}

bool Connection::gone() const {
  const std::lock_guard lock(mutex_);
  return gone_ && messages_.empty();
}

std::string Connection::broken() const {
  const std::lock_guard lock(mutex_);
  return broken_;
}

void Connection::send(const Json& message) {
  const std::string bytes = framed(message);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = write(out_, bytes.data() + sent, bytes.size() - sent);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    sent += static_cast<std::size_t>(count);
  }
}

}  // namespace debugger::dap
