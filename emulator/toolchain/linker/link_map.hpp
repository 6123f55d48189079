#pragma once
#include <string>
#include <vector>

#include "toolchain/linker/memory_map.hpp"
#include "toolchain/linker/placement.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/object.hpp"

namespace toolchain {

/// The addresses of everything in a linked program, as text.
std::string link_map(const Image& image, const MemoryMap& map, const Placement& placement,
                     const std::vector<Object>& objects);

}  // namespace toolchain
