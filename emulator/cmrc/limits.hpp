#pragma once
// Scans for the first missed deadline: how much longer instructions could take, how few DSPs would do, how fast the
// servo could be.
#include <functional>
#include <vector>

#include "cmrc/config.hpp"
#include "report/limits.hpp"

namespace cmrc {

/// Values to be tried of each quantity; empty: it is not scanned.
struct LimitGrids {
  std::vector<double> cycles;  ///< factors on the time of an instruction cycle
  std::vector<double> dsps;
  std::vector<double> servo;  ///< f_p in Hz

  /// Factors 1 to 3 by quarters, 1 DSP to 8, and every servo frequency that the refreshes of `config` can have from
  /// half the configured one on: f_s / N for whole N of at least 2.
  static LimitGrids standard(const Config& config);
};

/// Runs every point for the configured duration, or to its first missed deadline, as many at a time as there are
/// processors.
///
/// \param errors every point runs its whole duration, and is measured against the ideal run, which points share that
/// differ in DSPs and their speed
/// \param progress how many points are done, of how many
/// \throws ConfigError a grid without a value, or with one twice; std::runtime_error when a run breaks down
report::Limits find_limits(const Config& config, const LimitGrids& grids, bool errors,
                           const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace cmrc
