#include "cli/output_files/progress_line.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>

namespace cli {
namespace {

/// How long a line may be: one character less than the terminal is wide now, so that it stays one line.
std::size_t room() {
  struct ::winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
    return std::numeric_limits<std::size_t>::max();
  return size.ws_col - 1U;
}

}  // namespace

ProgressLine::ProgressLine(report::Time duration, bool wanted)
    : duration_(duration), active_(wanted && ::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (active_ && width_ > 0) write(fmt::format("\r{:<{}}\r", "", std::min(width_, room())));
}

void ProgressLine::show(report::Time simulated, std::uint64_t misses) {
  if (!active_) return;
  const auto now = Wall::now();
  if (now - last_ < std::chrono::milliseconds(200)) return;
  last_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double done = report::seconds(simulated);
  const double whole = report::seconds(duration_);
  const std::string left = done > 0 ? fmt::format("{:.0f} s left", (whole - done) * elapsed / done) : "";
  put(fmt::format("{:.1f} of {:.1f} s  {:.2f} x real time  {}  {} missed", done, whole, done / elapsed, left, misses));
}

void ProgressLine::show(std::string_view what) {
  if (active_) put(what);
}

void ProgressLine::put(std::string_view text) {
  const std::size_t most = room();
  text = text.substr(0, most);
  width_ = std::min(std::max(width_, text.size()), most);
  write(fmt::format("\r{:<{}}", text, width_));
}

void ProgressLine::write(const std::string& text) noexcept {
  active_ = std::fwrite(text.data(), 1, text.size(), stderr) == text.size() && std::fflush(stderr) == 0;
}

}  // namespace cli
