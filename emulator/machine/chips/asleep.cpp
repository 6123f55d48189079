#include "machine/chips/asleep.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "c40/peripherals/timer.hpp"
#include "c40/values/float40.hpp"
#include "isa/types.hpp"

namespace machine {
namespace {

constexpr unsigned first_dma_bit = 25;  // of IIE
constexpr std::array<unsigned, c40::timer_count> timer_bits{0, 31};

bool enables(const c40::Chip& chip, unsigned bit) { return (chip.register_value(isa::Register::IIE) >> bit & 1u) != 0; }

}  // namespace

c40::Cycles next_timer_interrupt(const c40::Chip& chip) {
  c40::Cycles next = never_cycle;
  for (int n = 0; n < c40::timer_count; ++n)
    if (enables(chip, timer_bits[static_cast<std::size_t>(n)]) && !chip.timer_drives_dma(n))
      next = std::min(next, chip.next_timer_event(n));
  return next;
}

c40::Cycles next_dma_tick(const c40::Chip& chip) {
  c40::Cycles next = never_cycle;
  for (const c40::DmaWait& wait : chip.dma_waits())
    if (wait.timer) next = std::min(next, chip.next_timer_event(*wait.timer));
  return next;
}

bool timer_paces_dma(const c40::Chip& chip) {
  if (!chip.dma_active()) return false;
  return std::ranges::any_of(chip.dma_waits(), [&](const c40::DmaWait& wait) {
    return wait.stops && wait.timer && chip.next_timer_event(*wait.timer) != never_cycle;
  });
}

bool awaits_dma(const c40::Chip& chip) {
  const auto waits = chip.dma_waits();
  return std::any_of(waits.begin(), waits.end(), [&](const c40::DmaWait& wait) {
    return wait.interrupts && enables(chip, first_dma_bit + static_cast<unsigned>(wait.channel));
  });
}

bool awaits_timer(const c40::Chip& chip) { return next_timer_interrupt(chip) != never_cycle; }

bool can_interrupt(const c40::Chip& chip) {
  return chip.idle() || (chip.register_value(isa::Register::ST) & c40::st::GIE) != 0;
}

bool rests_forever(const c40::Chip& chip) {
  if (chip.dma_busy() || timer_paces_dma(chip)) return false;
  if (!can_interrupt(chip)) return true;
  if (chip.interrupt_pending() || awaits_timer(chip)) return false;
  return !awaits_dma(chip) || next_dma_tick(chip) == never_cycle;
}

bool sleeps_forever(const c40::Chip& chip) { return chip.idle() && rests_forever(chip); }

std::string armed_dma(const c40::Chip& chip) {
  std::string out;
  for (const c40::DmaWait& wait : chip.dma_waits())
    out += fmt::format("; {} since cycle {}", c40::describe(wait), wait.since);
  return out;
}

}  // namespace machine
