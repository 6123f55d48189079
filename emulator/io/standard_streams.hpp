#pragma once
// Standard input, output and error of a program.
#include <string>

namespace io {

/// Opens descriptors 0 to 2 if the program's caller has closed them, so that no file of ours gets their numbers and
/// with them the printed text. Writing to a closed standard output still fails.
void take_closed_streams();

/// Makes sure that everything printed has reached standard output. \returns what went wrong; empty if nothing
std::string flush_output();

}  // namespace io
