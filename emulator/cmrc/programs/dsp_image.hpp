#pragma once
// The DSPs' program.
#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// The DSP image of a configuration: the one built in, or assembled from `machine.programs`/dsp.asm.
/// \throws toolchain::AssemblyError; ConfigError when the directory holds no dsp.asm
toolchain::Image dsp_image(const Config& config);
/// The boot ROM, as the boards have it.
toolchain::Image boot_rom_image();

}  // namespace cmrc
