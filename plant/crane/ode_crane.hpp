#pragma once
// The crane as rigid bodies and joints in ODE: slider, hinge, hinge and ball. It shares no equation with
// plant/crane/crane.hpp; each engine checks the other (plant-and-bus.md 1.7, test 6). Slow and of first to second
// order: not for use in the dock.
#include <array>

#include "plant/crane/crane.hpp"

namespace plant {

// Free motion under gravity and constant forces on gantry (N), slew and luff (N m), the rope's length fixed, no
// friction, rotors or damping. Starts from q and qd (their l and kappa parts at rest), returns q after `steps` steps of
// `step` seconds.
CraneVector swing_in_ode(const CraneParameters&, double payload_mass, const CraneVector& q, const CraneVector& qd,
                         const std::array<double, 3>& force, double step, int steps);

}  // namespace plant
