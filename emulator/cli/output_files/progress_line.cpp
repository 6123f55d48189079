#include "cli/output_files/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string>

namespace cli {

ProgressLine::ProgressLine(report::Time duration, bool wanted)
    : duration_(duration), active_(wanted && ::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (width_ > 0) fmt::print(stderr, "\r{:<{}}\r", "", width_);
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
  width_ = std::max(width_, text.size());
  fmt::print(stderr, "\r{:<{}}", text, width_);
  std::fflush(stderr);
}

}  // namespace cli
