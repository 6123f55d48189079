#pragma once
// The programs in the executive's jump table: the builds that the configuration selects.
#include <cstdint>
#include <string_view>

#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Puts the program at `label` into the row `kind` of the image's table exec_kernels.
/// \throws ConfigError, naming `key`, if the image has no such label or the table no such row
void place_kernel(toolchain::Image& image, toolchain::Word kind, std::string_view label, std::string_view key);

/// dock.wind_limit_m_s in the anemometer's unit.
std::int32_t wind_limit_mm_s(const Config& config);

/// Puts every program that the configuration selects into its row.
void place_kernels(toolchain::Image& image, const Config& config);

}  // namespace cmrc
