#pragma once
// The DSPs' program.
#include "toolchain/objects/image.hpp"

namespace cmrc {

struct Config;

/// The DSPs' program: the built-in one, or assembled from `machine.programs`/dsp.asm.
/// \throws toolchain::AssemblyError; ConfigError if the directory has no dsp.asm
toolchain::Image assembled_program(const Config& config);
/// The same with the configuration's choices and the plant's constants. \throws ConfigError
toolchain::Image dsp_image(const Config& config);
/// The boot ROM of the boards.
toolchain::Image boot_rom_image();

}  // namespace cmrc
