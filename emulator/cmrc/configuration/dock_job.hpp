#pragma once
// Whether the controller can do its job in a dock (docs/plant.md, Your own layout). That the bodies are in reach and
// apart is checked by the plant.
#include "cmrc/configuration/config.hpp"
#include "cmrc/tasks/words.hpp"
#include "plant/parameters/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Refuses a slewing crane that does not stand at 0 m of its rails, a container on the ship that the bay scanner cannot
/// see, places between which the straight way turns psi or kappa through 180 degrees (there the set-point of inverse
/// kinematics jumps by a whole turn), more boxes or longer legs than the job areas hold, and a queue of AGVs that does
/// not fit into the straight end of the lane to the loading spot.
/// \throws std::invalid_argument with the key, the place and what would be right
void check_job(const plant::DockConfig& dock, const Words& words);

/// Refuses a slewing crane's straight ways that leave the jib's reach, or on which the trajectory turns a joint so fast
/// that its drive trips: blend9 plans at one speed for all distances from the column (docs/control.md, Speed limits).
/// \param image the DSPs' program, from whose constants the durations follow
/// \throws std::invalid_argument as check_job
void check_speeds(const plant::DockConfig& dock, const Config& config, const toolchain::Image& image);

}  // namespace cmrc
