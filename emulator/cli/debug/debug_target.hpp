#pragma once
// The object of a debugger: a program, a network or the dock.
#include <memory>

#include "cli/arguments/options.hpp"
#include "cmrc/run/simulation.hpp"
#include "machine/debug/debuggee.hpp"
#include "machine/networks/network.hpp"

namespace cli {

/// The object, with everything that it refers to.
struct DebugTarget {
  std::unique_ptr<machine::Network> network;
  std::unique_ptr<cmrc::Simulation> simulation;
  std::unique_ptr<machine::debug::Debuggee> debuggee;
};

/// \throws InputError, and the errors of reading programs and configurations
DebugTarget debug_target(const DebugOptions& options);

}  // namespace cli
