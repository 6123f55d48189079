#pragma once
/// The memory interface control registers, GMICR and LMICR (c40-hardware.md 1.4): the addresses of a bus's two strobes,
/// and how each strobe's ready signal is formed.
#include <algorithm>
#include <array>
#include <cstdint>

#include "c40/values/types.hpp"

namespace c40 {

struct InterfaceControl {
  /// SWW: the signal that ends an access. `either` and `both` (unverified; as on the C3x).
  enum class Ready : std::uint8_t { external, internal, either, both };
  struct Strobe {
    Ready ready = Ready::external;
    int wait_count = 0;      ///< WTCNT
    unsigned page_bits = 1;  ///< a page is 2^page_bits words
  };
  std::array<Strobe, 2> strobe;
  std::uint64_t strobe0_words =
      0;                       ///< STRB0 covers this number of words from the start of the bus's range, STRB1 the rest
  bool strobe_switch = false;  ///< one more cycle between successive reads on different strobes

  static constexpr Word writable = 0x3FFFFFF0u;  ///< CE0, CE1, DE, AE are pins; bits 31, 30 are reserved

  static constexpr InterfaceControl decode(Word value) {
    const auto field = [value](unsigned first, unsigned width) { return value >> first & ((1u << width) - 1); };
    InterfaceControl out;
    for (unsigned s = 0; s < 2; ++s)
      out.strobe[s] = {static_cast<Ready>(field(4 + 2 * s, 2)), static_cast<int>(field(8 + 3 * s, 3)),
                       std::min(field(14 + 5 * s, 5) + 1, 31u)};
    out.strobe0_words = std::uint64_t{2} << std::min(field(24, 5), 30u);
    out.strobe_switch = field(29, 1) != 0;
    return out;
  }

  /// Wait states of an access for which the board's RDY pin requests `external`.
  constexpr int waits(unsigned which, int external) const {
    const Strobe& s = strobe[which];
    switch (s.ready) {
      case Ready::external: return external;
      case Ready::internal: return s.wait_count;
      case Ready::either: return std::min(external, s.wait_count);
      case Ready::both: break;
    }
    return std::max(external, s.wait_count);
  }
};

}  // namespace c40
