#pragma once

namespace plant {

// Starts ODE once per process and thread, in double precision, with its errors as exceptions; and resets ODE's random
// numbers (one sequence for the whole process) to their beginning. To be called before every use. Throws
// std::runtime_error.
void start_ode();

}  // namespace plant
