#include "toolchain/objects/section_places.hpp"

namespace toolchain {
namespace {

constexpr std::uint64_t page = 1 << 16;

}  // namespace

int placement_rank(std::string_view name, bool loaded) {
  if (name == ".text") return 0;
  if (name == ".data") return 1;
  if (loaded) return 2;
  return name == ".bss" ? 3 : 4;
}

std::uint64_t aligned(std::uint64_t address, std::uint64_t alignment) {
  return (address + alignment - 1) / alignment * alignment;
}

std::uint64_t pages(std::uint64_t address, std::uint64_t words) {
  return words == 0 ? 0 : (address + words - 1) / page - address / page + 1;
}

bool is_split(std::uint64_t address, std::uint64_t words) { return words <= page && pages(address, words) > 1; }

std::uint64_t free_place(std::uint64_t from, std::uint64_t words, std::uint64_t alignment, bool blocked,
                         std::span<const Extent> taken) {
  std::uint64_t at = from;
  for (bool moved = true; moved;) {
    moved = false;
    at = aligned(at, alignment);
    if (blocked && is_split(at, words)) at = aligned(at, page);
    for (const Extent& other : taken) {
      if (other.words == 0 || at >= other.begin + other.words || other.begin >= at + words) continue;
      at = other.begin + other.words;
      moved = true;
    }
  }
  return at;
}

}  // namespace toolchain
