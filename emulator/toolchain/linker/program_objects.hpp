#pragma once
// The objects of a program.
#include <vector>

#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// Adds the objects of `library` that the program needs, and its common storage. \returns the program's processor.
/// \throws LinkError if the objects are for several
isa::Cpu complete(std::vector<Object>& objects, const std::vector<Object>& library, const MemoryMap& map);

}  // namespace toolchain
