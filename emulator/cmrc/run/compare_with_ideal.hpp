#pragma once
// A run and the same run with instant execution.
#include "cmrc/configuration/config.hpp"
#include "report/comparison.hpp"

namespace cmrc {

/// Runs both at the same time, the ideal one in a process of its own. \throws std::runtime_error if one fails
report::Comparison compare_with_ideal(const Config& config);

}  // namespace cmrc
