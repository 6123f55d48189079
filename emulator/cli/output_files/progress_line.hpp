#pragma once
// A line on the terminal that shows how far a run has come.
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "report/events/event.hpp"

namespace cli {

/// Rewrites one line on standard error a few times per second and erases it at the end. The line is never longer than
/// the terminal is wide. Silent if standard error is not a terminal. A line that cannot be written ends no work: from
/// then on there is none.
class ProgressLine {
 public:
  ProgressLine(report::Time duration, bool wanted);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(report::Time simulated, std::uint64_t misses);
  /// At once, for work that does not tell how far it is.
  void show(std::string_view what);

 private:
  void put(std::string_view text);
  void write(const std::string& text) noexcept;

  using Wall = std::chrono::steady_clock;

  report::Time duration_;
  bool active_;
  Wall::time_point start_ = Wall::now();
  Wall::time_point last_ = start_;
  std::size_t width_ = 0;
};

}  // namespace cli
