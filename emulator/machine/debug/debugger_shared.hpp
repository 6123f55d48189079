#pragma once
// What the sources of the debugger share: the manner of a search, and the trigger of a step.
#include <cstddef>
#include <optional>
#include <string>

#include "machine/debug/debugger.hpp"

namespace machine::debug {

inline constexpr unsigned temporary = 0;     ///< number of the trigger of a step
inline constexpr unsigned swi_number = ~0u;  ///< number of a hit without a trigger: a chip has come to SWI

/// The manner of a search.
struct Debugger::Manner {
  std::optional<std::size_t> steps;  ///< the search ends at this chip's next instruction
};

/// "0.125 s"
std::string seconds(Time time);
/// The condition of a step that ends where its routine's stack is as deep as before.
std::string at_stack(Address sp);

}  // namespace machine::debug
