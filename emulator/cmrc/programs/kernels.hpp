#pragma once
// Which programs stand in the executive's jump table: the builds that the configuration chooses.
#include <string_view>

#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Puts the program at `label` into the row `kind` of the image's table exec_kernels.
/// \throws ConfigError, naming `key`, when the image has no such label or the table no such row
void place_kernel(toolchain::Image& image, toolchain::Word kind, std::string_view label, std::string_view key);

/// Places every program that the configuration chooses.
void place_kernels(toolchain::Image& image, const Config& config);

}  // namespace cmrc
