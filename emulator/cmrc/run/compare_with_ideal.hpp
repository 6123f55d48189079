#pragma once
// A run and the same run with instant execution.
#include <functional>

#include "cmrc/configuration/config.hpp"
#include "cmrc/run/simulation.hpp"
#include "report/values/comparison.hpp"

namespace cmrc {

/// Runs both at the same time, the ideal one in a process of its own. `on_progress` as of Simulation::run.
/// \throws std::runtime_error when one breaks down
report::Comparison compare_with_ideal(const Config& config,
                                      const std::function<bool(const Progress&)>& on_progress = {});

}  // namespace cmrc
