#pragma once
// The DSPs' program.
#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// The DSPs' program: the one built in, or assembled from `machine.programs`/dsp.asm.
/// \throws toolchain::AssemblyError; ConfigError when the directory holds no dsp.asm
toolchain::Image assembled_program(const Config& config);
/// The same with what the configuration chooses and says of the plant in place. \throws ConfigError
toolchain::Image dsp_image(const Config& config);
/// The boot ROM, as the boards have it.
toolchain::Image boot_rom_image();

}  // namespace cmrc
