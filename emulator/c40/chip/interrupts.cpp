#include "c40/chip/interrupts.hpp"

#include "c40/instructions/choices.hpp"

namespace c40::interrupts {
namespace {

constexpr Word vector_nmi = 0x01, vector_timer0 = 0x02, first_vector_iiof = 0x03, first_vector_port = 0x0D,
               first_vector_dma = 0x25, vector_timer1 = 0x2B;
constexpr unsigned iiof_pins = 4, dma_channels = 6;

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
  for (unsigned pin = 0; pin < iiof_pins; ++pin) {
    const Word nibble = iiof_nibble(core, pin);
    const bool requested = (nibble & 4u) != 0 || ((nibble & 2u) != 0 && (state.iiof_levels >> pin & 1u) != 0);
    if ((nibble & 9u) == 9u && requested) return first_vector_iiof + pin;
  }
  if ((iie & port_sources) != 0)
    if (const Word vector = pending_of_ports(state, iie); vector != 0) return vector;
  for (unsigned channel = 0; channel < dma_channels; ++channel)
    if (((iif & iie) & first_dma_flag << channel) != 0) return first_vector_dma + channel;
  return (iif & iie & timer1_flag) != 0 ? vector_timer1 : 0u;
}

void enter(Core& core, Word vector) {
  const Word old = core.modes;
  core.modes = (old & ~(st::PGIE | st::PCF | st::GIE)) | (old & st::GIE ? st::PGIE : 0u) |
               (old & st::CF ? st::PCF : 0u) | (choices::entry_sets_cache_freeze ? st::CF : 0u);
  Word& iif = core.r[reg::IIF];
  if (vector == vector_nmi) iif &= ~nmi_flag;
  if (vector == vector_timer0) iif &= ~timer0_flag;
  if (vector >= first_vector_iiof && vector < first_vector_iiof + iiof_pins)
    iif &= ~iiof_flag(vector - first_vector_iiof);
  if (vector >= first_vector_dma && vector < first_vector_dma + dma_channels)
    iif &= ~(first_dma_flag << (vector - first_vector_dma));
  if (vector == vector_timer1) iif &= ~timer1_flag;
  core.idle = false;
}

}  // namespace c40::interrupts
