#pragma once
// Whether the crane can drive the straight ways of the job.
#include "cmrc/configuration/config.hpp"
#include "plant/parameters/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Refuses a slewing crane's straight ways that leave the jib's reach, or on which the trajectory turns a joint so fast
/// that its drive trips: blend9 plans at one speed for all distances from the column (docs/control.md, Speed limits).
/// \param image the DSPs' program, from whose constants the durations follow
/// \throws std::invalid_argument with the places and what would be right
void check_speeds(const plant::DockConfig& dock, const Config& config, const toolchain::Image& image);

}  // namespace cmrc
