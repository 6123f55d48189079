#pragma once
#include <array>
#include <cstdint>

#include "plant/dock/state.hpp"

namespace plant {

// Two 64-bit hashes over every value of the state, in the order of state.hpp.
std::array<std::uint64_t, 2> hash(const DockState&);

}  // namespace plant
