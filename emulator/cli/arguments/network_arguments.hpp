#pragma once
// A network as the command line describes it, for exec and the debugger.
#include <string>

#include "cli/arguments/options.hpp"
#include "machine/networks/network.hpp"

namespace cli {

/// Reads the programs, boards and files of the options; the network, when it is made, does --load and --poke. \throws
/// InputError, machine::NetworkError, toolchain::AssemblyError, toolchain::CoffError
machine::NetworkDescription described(const ExecOptions& options);

/// One chip that is in no network.
bool is_alone(const ExecOptions& options);

/// "12.5,cut,0.3:1.0". \throws InputError
machine::NetworkAction action_of(const std::string& text, const machine::Network& network);

}  // namespace cli
