#pragma once
// What a debugger is asked to debug: a program, a network or the dock.
#include <memory>

#include "cli/options.hpp"
#include "cmrc/run/simulation.hpp"
#include "machine/debug/debuggee.hpp"
#include "machine/network.hpp"

namespace cli {

/// With all that it stands on.
struct DebugTarget {
  std::unique_ptr<machine::Network> network;
  std::unique_ptr<cmrc::Simulation> simulation;
  std::unique_ptr<machine::debug::Debuggee> debuggee;
};

/// \throws InputError, and what reading programs and configurations throws
DebugTarget debug_target(const DebugOptions& options);

}  // namespace cli
