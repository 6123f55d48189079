#pragma once
/// Interrupts: which one is requested and enabled, and how the entry changes ST and IIF (c40-hardware.md 5).
#include <array>

#include "c40/chip/state.hpp"

namespace c40::interrupts {

/// Bits of IIF.
inline constexpr Word nmi_flag = 1u << 16, timer0_flag = 1u << 24, timer1_flag = 1u << 31, first_dma_flag = 1u << 25;
inline constexpr std::array timer_flags{timer0_flag, timer1_flag};
constexpr Word iiof_flag(unsigned pin) { return 4u << 4 * pin; }
/// FUNC, TYPE, FLAG and IIOF enable of a pin IIOFn.
constexpr Word iiof_nibble(const Core& core, unsigned pin) { return core.r[reg::IIF] >> 4 * pin & 0xFu; }
/// The pin is an interrupt, requested as long as it is low.
constexpr bool is_level_triggered(const Core& core, unsigned pin) { return (iiof_nibble(core, pin) & 3u) == 3; }
/// Bits of IIE: the conditions of communication ports, four for each.
inline constexpr Word port_sources = 0x01FFFFFEu;
/// The bits of port `n`, in the order ICFULL, ICRDY, OCRDY, OCEMPTY.
constexpr Word port_enables(Word enabled, unsigned n) { return enabled >> (1 + 4 * n) & 0xFu; }

/// The same as pending() while GIE or NMI is set.
Word pending_if_enabled(const State& state);
/// The offset in the vector table of the interrupt to take; 0: none.
inline Word pending(const State& state) {
  const bool any = (state.core.modes & st::GIE) != 0 || (state.core.r[reg::IIF] & nmi_flag) != 0;
  return any ? pending_if_enabled(state) : 0u;
}
/// Clears the request, and does the entry's changes of ST.
void enter(Core& core, Word vector);

}  // namespace c40::interrupts
