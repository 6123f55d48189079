#pragma once
// Standard input, output and error of a program.
#include <string>

namespace io {

/// Descriptors 0 to 2 that the caller of the program has closed are taken, so that no file of ours gets their numbers
/// and with them what is printed. What is written to a closed standard output still fails.
void take_closed_streams();

/// Everything printed has gone to standard output. \returns why not; empty when it has
std::string flush_output();

}  // namespace io
