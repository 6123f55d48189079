#pragma once
// Constants of the DSPs' programs, as the host reads them from the image.
#include <cstddef>
#include <string_view>
#include <vector>

#include "toolchain/objects/image.hpp"

namespace cmrc {

/// `count` TI single floats at `label`, a place on chip to which _start copies them from the image.
/// \throws ConfigError if the image has none there
std::vector<double> program_constants(const toolchain::Image& image, std::string_view label, std::size_t count = 1);

}  // namespace cmrc
