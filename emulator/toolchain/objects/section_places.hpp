#pragma once
// The order and the places of sections that nobody has given an address, and the entry that nobody has named: for
// assembler and linker the same.
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace toolchain {

/// In words; a mistake in a source or a memory map must not fill the host's memory.
constexpr std::uint32_t largest_loaded_section = 1U << 24;

/// Where the first section begins.
inline constexpr std::uint32_t usual_address = 0x300000;

/// The program starts at the first of these that is an address in a loaded section.
inline constexpr std::array<std::string_view, 6> usual_entries{"_start", "_c_int00", "c_int00",
                                                               "start",  "START",    "Start"};

/// .text, .data, other loaded sections, .bss, other reserved ones: the lower rank comes first.
int placement_rank(std::string_view name, bool loaded);

/// \param alignment in words, a power of 2
std::uint64_t aligned(std::uint64_t address, std::uint64_t alignment);

/// Words that are taken.
struct Extent {
  std::uint64_t begin = 0, words = 0;
};

/// In how many pages of 64 K words the words lie.
std::uint64_t pages(std::uint64_t address, std::uint64_t words);

/// Whether words that would fit into one page lie in two: blocked sections may not.
bool is_split(std::uint64_t address, std::uint64_t words);

/// The first address from `from` on where a section does not meet another one. \param words the section's size, not 0
/// \param alignment in words, a power of 2 \param blocked not to be split over two pages of 64 K words if it fits in
/// one
std::uint64_t free_place(std::uint64_t from, std::uint64_t words, std::uint64_t alignment, bool blocked,
                         std::span<const Extent> taken);

}  // namespace toolchain
