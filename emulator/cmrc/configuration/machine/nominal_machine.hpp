#pragma once
// The machine of a configuration, with nominal clocks.
#include <cstdint>

#include "cmrc/configuration/config.hpp"
#include "machine/system/machine_config.hpp"

namespace cmrc {

/// In an ideal run (run/ideal_run.hpp) a DSP is so many times as fast.
inline constexpr std::int64_t ideal_speed = 1000;

/// \throws machine::BoardError
machine::Config nominal_machine_of(const Config& config);

}  // namespace cmrc
