// The runs of a chip of a network, and why each ends.
#include <algorithm>
#include <utility>

#include "isa/program_end.hpp"
#include "machine/chips/asleep.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Cycles;
using c40::StopInfo;

/// A waiting chip continues with its DMA. Links are known up to `until`. A processor that follows its ports has begun
/// its last instruction by then: what a link does at that instant is an interrupt for the next instruction. So the
/// order of events does not depend on how a run is divided, and the DMA, which follows the processor's read stage, has
/// done everything before.
/// \param last the last cycle in which it may begin an instruction, whatever `until` is
void Network::Node::run_to(Time until, Cycles last) {
  passing_ = false;
  last_ = last;
  ends_ = first_cycle(until);
  action_ = next_action();
  const Cycles event = own_event_cycle();
  run_chip(chip);
  if (own_event_cycle() != event) note_own_event(event);
  if (was_ready && waits_for_port() && !port_is_ready()) forget_port();  // its DMA was at the port before
}

/// Of a chip that does not only wait for a port.
bool Network::Node::follow_to(Time time) {
  const bool continues = follows() || (status == ChipStatus::waiting && dma_waits());
  if (status != ChipStatus::sleeping && !continues) return false;
  if (continues) run_to(time);
  if (status == ChipStatus::sleeping) bring_to(time, true);  // also one that came to its branch just now
  return true;
}

std::optional<ChipRunner::Span> Network::Node::span() {
  if (std::exchange(over_breakpoint_, false))
    return Span{.limit = chip.cycle() + 1, .known = std::min(span_.known, chip.cycle() + 1)};
  const bool with_dma = chip.dma_active();
  cycle_before_ = chip.cycle(), settled_before_ = with_dma ? chip.settled() : cycle_before_;
  ended_before_ = !with_dma || !chip.dma_ends_by(never_cycle);
  return passing_ ? span_ : span_of_runner();
}

std::optional<ChipRunner::Span> Network::Node::span_of_runner() {
  const bool waits = status == ChipStatus::waiting, idles = chip.idle(), with_dma = chip.dma_active();
  const Cycles cycle = chip.cycle(), settled = with_dma ? chip.settled() : cycle;
  const Cycles known = std::min(ends_, std::max(cycle, action_));
  // Only here it is known whether the chip still follows its ports.
  const bool begins_last = cycle >= ends_ && ends_ <= last_ && !waits && !idles && follows();
  Cycles limit = std::min(ends_ + (begins_last ? 1 : 0), action_);
  const bool dma_continues = with_dma && (chip.dma_ends_by(known) || chip.next_event() <= std::min(known, settled));
  if (settled >= known && !dma_continues && (waits || cycle >= limit)) {
    note_idle();
    return {};
  }
  if (!waits && cycle >= action_)
    return span_ = Span{.limit = 0, .known = known};  // the processor waits for the action
  // An idle processor may have ended when its DMA is done, or when a timer's event was not for it: in that cycle. The
  // DMA may be behind: then it first comes to the present cycle, in which the processor may have ended.
  const bool looks = status == ChipStatus::running && idles;
  if (looks && chip.dma_busy())
    limit = std::min(limit, cycle + (dma_is_behind() ? 0 : 1));
  else if (looks && awaits_timer(chip))
    limit = std::min(limit, std::max(cycle + 1, next_timer_interrupt(chip)));
  return span_ = Span{.limit = limit, .known = std::min(known, limit)};
}

bool Network::Node::at_limit() {
  if (passing_) return has_moved() && passes_on();
  note_idle();
  return status == ChipStatus::running && has_moved();
}

bool Network::Node::asks_again() {
  if (passing_) return passes_on();
  note_idle();
  return false;
}

/// Returns whether the chip continues.
bool Network::Node::at_breakpoint() {
  over_breakpoint_ = true;
  if (passing_) return true;
  if (const auto rests = rest()) {
    status = *rests;
    if (status != ChipStatus::until) asleep_since = chip.cycle();
  }
  return over_breakpoint_ = status == ChipStatus::running;
}

/// The status of a chip whose program ends at its PC, or waits there; none: it runs on.
std::optional<ChipStatus> Network::Node::rest() const {
  const auto& others = description.other_ends;
  if (description.until == chip.pc() || std::ranges::find(others, chip.pc()) != others.end()) return ChipStatus::until;
  if (wakes() || chip.program_end() != isa::ProgramEnd::halt) return std::nullopt;
  if (chip.dma_active() || (chip.watches_ports() && can_interrupt(chip)) || reacts_to_pins())
    return ChipStatus::sleeping;
  if (!can_interrupt(chip) || !awaits_timer(chip)) return ChipStatus::halt;
  return std::nullopt;
}

/// The same of a chip in IDLE.
std::optional<ChipStatus> Network::Node::rest_in_idle() const {
  if (chip.dma_busy()) return std::nullopt;
  if (chip.watches_ports() || chip.dma_active() || reacts_to_pins()) return ChipStatus::sleeping;
  if (!awaits_timer(chip)) return ChipStatus::idle;
  return std::nullopt;
}

/// Its registers or memory were changed while nothing ran. `moved`: its PC, which took the access of the processor away
/// for which it waited, or at which it ended. A fault stays: the chip is halted. What it does from now on it does from
/// the present instant on; a chip that stays at rest stays where it was.
void Network::Node::look_again(bool moved) {
  patience.is_private = false;
  begin_patience();
  using enum ChipStatus;
  const bool begins_again =
      moved && !chip.halted() && (status == waiting || status == external_access || status == fault);
  if (begins_again && !dma_awaits_answer()) {
    forget_port();
    chip.stand_until(first_cycle(network.now_));
  } else if (status != halt && status != idle && status != until && status != sleeping) {
    return;
  }
  const std::optional<ChipStatus> rests = chip.idle() ? rest_in_idle() : rest();
  if (rests == status) return wake_up();
  stand_at_rest_until(network.now_);
  if (status != sleeping) asleep_since = chip.cycle();
  status = rests.value_or(running);
  wake_up();
}

bool Network::Node::window_access(const c40::ExternalAccess& access) {
  const bool in_order = devices != nullptr && devices->acts_on_others(access.address);
  if (!in_order && devices != nullptr && devices->has(access.address)) return serve_device(access);
  if (!in_order && ignored.serve(chip, access)) return true;
  const bool waits = in_order || network.memory_of(*this, access.address) != nullptr;
  const bool again = waits_for_window() && stop.access.channel < 0 && access.channel < 0;
  status = waits ? ChipStatus::waiting : ChipStatus::external_access;
  stop = {};
  stop.reason = StopInfo::Reason::external_access;
  stop.access = access;
  return again && waits && dma_continues();
}

bool Network::Node::waits(StopInfo::Reason why, const c40::PortAccess& access) {
  if (passing_) return passes_on();
  if (waits_for_port()) {
    stop.port = access;  // an access of the DMA may have delayed it
    return dma_continues();
  }
  status = ChipStatus::waiting;
  await(access.port);
  stop.reason = why;
  stop.port = access;
  stop.fault.reset();
  was_ready = false;
  note_ready(Time{0});
  return false;
}

bool Network::Node::faulted(const c40::Fault& why) {
  status = ChipStatus::fault;
  forget_port();
  stop = {};
  stop.reason = StopInfo::Reason::fault;
  stop.fault = why;
  return false;
}

/// The chip waits for no port any more.
void Network::Node::forget_port() { was_ready = false, ready_since = Time{0}; }

void Network::Node::note_idle() {
  if (chip.idle() && status == ChipStatus::running) status = rest_in_idle().value_or(ChipStatus::running);
}

/// Advances a chip that does not run to an instant. `fully`: a processor that branches to itself has begun its last
/// branch by then, as a running one has begun its last instruction (run_to), but for an action on the chip there.
void Network::Node::bring_to(Time time, bool fully) {
  const Cycles cycle = first_cycle(time);
  fully = fully && cycle < next_action();
  if (status != ChipStatus::sleeping && !fully && chip.cycle() >= cycle) return;
  if (status == ChipStatus::running)
    run_to(time);
  else if (status != ChipStatus::sleeping) {
    bring_timers_to(time);
    chip.stand_until(cycle);
  }
  while (status == ChipStatus::sleeping) {
    const Cycles limit = cycle + (fully && !chip.idle() ? 1 : 0), event = own_event_cycle();
    pass_to(std::min(limit, event), std::min(cycle, event));
    if (event <= cycle) note_own_event(event);
    if (status != ChipStatus::sleeping) return;
    wake_up();  // an event during the last pass of the loop may wake it
    // A processor that an event takes out of IDLE in this cycle has begun its interrupt, as a running one.
    const bool begins = fully && event == cycle && status == ChipStatus::running;
    if (event >= limit && !begins) return;
    if (status == ChipStatus::running)
      run_to(time);  // it may sleep again
    else if (own_event_cycle() == event)
      return pass_to(limit, cycle);
  }
}

/// An event of a timer has come to a chip that sleeps or waits. A channel of its DMA may have kept it and waits for a
/// FIFO now: until then the chip was not at rest.
void Network::Node::note_own_event(Cycles event) {
  if (event != never_cycle) network.changed_ = std::max(network.changed_, clock.at(event));
}

/// Of a chip whose processor has ended.
void Network::Node::stand_at_rest_until(Time time) {
  using enum ChipStatus;
  if (status == halt || status == idle || status == until) chip.stand_until(first_cycle(time));
}

/// Of a chip whose processor waits, while its DMA waits, too, or rests.
void Network::Node::bring_timers_to(Time time) {
  if (status != ChipStatus::waiting || chip.dma_busy()) return;
  if (chip.dma_active())
    run_to(time);
  else
    chip.let_peripherals_reach(first_cycle(time));
}

/// Advances a sleeping chip that stays asleep.
void Network::Node::pass_to(Cycles limit, Cycles known) {
  passing_ = true;
  span_ = {.limit = limit, .known = known};
  run_chip(chip);
}

void Network::Node::wake_up() {
  if (status == ChipStatus::sleeping && wakes()) status = ChipStatus::running;
}

}  // namespace machine
