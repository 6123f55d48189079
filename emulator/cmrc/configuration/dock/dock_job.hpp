#pragma once
// Whether the controller can do its job in a dock (docs/layout.md). That the bodies are in reach and
// apart is checked by the plant.
#include "cmrc/tasks/words.hpp"
#include "plant/parameters/config.hpp"

namespace cmrc {

/// Refuses a slewing crane that does not stand at 0 m of its rails, a container on the ship that the bay scanner cannot
/// see, places between which the straight way turns psi or kappa through 180 degrees (there the set-point of inverse
/// kinematics jumps by a whole turn), more boxes or longer legs than the job areas hold, and a queue of AGVs that does
/// not fit into the straight end of the lane to the loading spot.
/// \throws std::invalid_argument with the key, the place and what would be right
void check_job(const plant::DockConfig& dock, const Words& words);

}  // namespace cmrc
