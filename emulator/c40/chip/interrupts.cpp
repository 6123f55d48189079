#include "c40/chip/interrupts.hpp"

#include <bit>

#include "c40/instructions/choices.hpp"

namespace c40::interrupts {
namespace {

constexpr Word vector_nmi = 0x01, vector_timer0 = 0x02, first_vector_iiof = 0x03, first_vector_port = 0x0D,
               first_vector_dma = 0x25, vector_timer1 = 0x2B;
constexpr unsigned iiof_pins = 4, dma_channels = 6;
constexpr Word each_pin = 0x1111, dma_flags = ((1u << dma_channels) - 1) * first_dma_flag;

// Levels, not latched (c40-hardware.md 2.3): 0Dh + 4n ICFULL, then ICRDY, OCRDY, OCEMPTY, in the order of their bits in
// IIE.
Word pending_of_ports(const State& state, Word enabled) {
  for (unsigned n = 0; n < port_count; ++n) {
    const CommPort& port = state.ports[n];
    const std::array<bool, 4> active{port.icfull(), port.icrdy(), port.ocrdy(), port.ocempty()};
    for (unsigned source = 0; source < 4; ++source)
      if (active[source] && (port_enables(enabled, n) >> source & 1u) != 0) return first_vector_port + 4 * n + source;
  }
  return 0;
}

}  // namespace

Word pending_if_enabled(const State& state) {
  const Core& core = state.core;
  const Word iif = core.r[reg::IIF], iie = core.r[reg::IIE];
  if ((iif & nmi_flag) != 0) return vector_nmi;
  if ((iif & timer0_flag) != 0 && (iie & 1u) != 0) return vector_timer0;
  // The pins that are interrupts (bit 0 of a pin's four) and enabled (bit 3).
  for (Word pins = iif & iif >> 3 & each_pin; pins != 0; pins &= pins - 1) {
    const auto pin = static_cast<unsigned>(std::countr_zero(pins)) / 4;
    if ((iiof_nibble(core, pin) & 4u) != 0) return first_vector_iiof + pin;
  }
  if ((iie & port_sources) != 0)
    if (const Word vector = pending_of_ports(state, iie); vector != 0) return vector;
  if (const Word channels = iif & iie & dma_flags; channels != 0)
    return first_vector_dma + static_cast<Word>(std::countr_zero(channels) - std::countr_zero(first_dma_flag));
  return (iif & iie & timer1_flag) != 0 ? vector_timer1 : 0u;
}

void enter(Core& core, Word vector) {
  const Word old = core.modes;
  core.modes = (old & ~(st::PGIE | st::PCF | st::GIE)) | (old & st::GIE ? st::PGIE : 0u) |
               (old & st::CF ? st::PCF : 0u) | (choices::entry_sets_cache_freeze ? st::CF : 0u);
  Word& iif = core.r[reg::IIF];
  if (vector == vector_nmi) iif &= ~nmi_flag;
  if (vector == vector_timer0) iif &= ~timer0_flag;
  if (vector >= first_vector_iiof && vector < first_vector_iiof + iiof_pins &&
      !is_level_triggered(core, vector - first_vector_iiof))
    iif &= ~iiof_flag(vector - first_vector_iiof);
  if (vector >= first_vector_dma && vector < first_vector_dma + dma_channels)
    iif &= ~(first_dma_flag << (vector - first_vector_dma));
  if (vector == vector_timer1) iif &= ~timer1_flag;
  core.idle = false;
}

}  // namespace c40::interrupts
