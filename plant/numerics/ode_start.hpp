#pragma once

namespace plant {

// ODE's start-up, once per process and thread, in double precision, with its complaints as exceptions; and its random
// numbers (one sequence for the whole process) back at their beginning. To be called before every use. Throws
// std::runtime_error.
void start_ode();

}  // namespace plant
