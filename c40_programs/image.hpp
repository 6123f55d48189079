#pragma once
// The DSP image that the build assembled from c40_programs/dsp.asm, as the bytes of its COFF file
// (toolchain/objects/coff.hpp reads it).
#include <cstddef>
#include <span>

namespace c40_programs {

/// \param own_blocks with the claim of blocks that only one DSP may claim (claim_own.asm)
std::span<const std::byte> built_in_image(bool own_blocks);
/// The source lines of it, as text (toolchain/objects/source_map.hpp reads it).
std::span<const std::byte> built_in_source_map(bool own_blocks);
/// The boot loader of the on-chip ROM (boot_rom.asm), as a COFF file; its address is 0.
std::span<const std::byte> built_in_boot_rom();
std::span<const std::byte> built_in_boot_rom_source_map();

}  // namespace c40_programs
