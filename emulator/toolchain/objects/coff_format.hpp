#pragma once
// Numbers of the TI COFF file format, shared by reader and writer (c40-hardware.md 10.1).
#include <cstddef>
#include <cstdint>

namespace toolchain::coff {

inline constexpr std::uint16_t target_id = 0x0093;  // C3x/C4x; in version 0 this is the magic number
inline constexpr std::uint16_t magic_v1 = 0x00C1;
inline constexpr std::uint16_t magic_v2 = 0x00C2;
inline constexpr std::size_t most_sections = 32767;  // A symbol's section number has 16 bits, one of them the sign.
inline constexpr std::uint16_t optional_magic = 0x0108;

inline constexpr std::size_t file_header_v0 = 20, file_header_v12 = 22, optional_header = 28;
inline constexpr std::size_t section_header_v01 = 40, section_header_v2 = 48, symbol_entry = 18;
inline constexpr std::size_t relocation_v0 = 10, relocation_v12 = 12, line_entry = 6, file_name = 14;

// File flags.
inline constexpr std::uint16_t no_relocations = 0x0001, executable = 0x0002, no_line_numbers = 0x0004;
inline constexpr std::uint16_t c4x = 0x0010, little_endian = 0x0100;  // Without c4x the file is for the C3x.

// Section flags.
inline constexpr std::uint32_t dsect = 0x01, noload = 0x02, copy = 0x10, text = 0x20, data = 0x40, bss = 0x80;
inline constexpr std::uint32_t block = 0x1000;
inline constexpr unsigned alignment_shift = 8;  ///< Position of the exponent of the alignment, 4 bits.

// Storage class and section number of symbols.
inline constexpr std::uint8_t class_external = 2, class_static = 3, class_function = 101, class_file = 103;
inline constexpr std::int16_t debug_section = -2, absolute_section = -1, undefined_section = 0;

}  // namespace toolchain::coff
