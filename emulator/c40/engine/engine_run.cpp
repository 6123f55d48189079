// The loop: the chip's next action, and why it stops.
#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "c40/chip/interrupts.hpp"
#include "c40/engine/engine.hpp"
#include "c40/instructions/choices.hpp"

namespace c40 {

void Engine::pass(Cause cause, Cycles until) {
  if (until <= state_.cycle) return;
  const Cycles cycles = until - state_.cycle;
  if (cause == Cause::idle) idle_.idled(state_.cycle, until);
  add(state_.causes, cause, cycles);
  if (state_.held) stand_still(cycles);
  state_.cycle = until;
  pipeline_.flush(cycles);  // a posted write may still be under way
  dma_side_.flushed(cycles);
}

// A held chip is frozen, its DMA and its timers with it. What it has done stays where it was in time.
void Engine::stand_still(Cycles cycles) {
  for (Timer& timer : state_.timers) timer.stand_still(cycles);
  dma_side_.stand_still(state_.cycle, cycles);
  peripherals_.state_changed();
}

const StopInfo& Engine::stop(Stepped why) {
  if (cache_.control_pending()) [[unlikely]]
    settle_cache_control();  // the DMA may have run while the processor idled
  StopInfo& info = stopped(StopInfo::Reason::limit);
  switch (why) {
    case Stepped::done: break;
    case Stepped::external:
      info.reason = StopInfo::Reason::external_access;
      info.access = access_.window();
      break;
    case Stepped::breakpoint:
      info.reason = StopInfo::Reason::breakpoint;
      reported_breakpoint_ = state_.cycle;
      break;
    case Stepped::port:
      info.reason =
          ports_.listener(access_.port().port) != nullptr ? StopInfo::Reason::port_access : StopInfo::Reason::port_wait;
      info.port = access_.port();
      break;
    case Stepped::horizon: info.reason = StopInfo::Reason::horizon; break;
    case Stepped::software_interrupt:
      info.reason = StopInfo::Reason::software_interrupt;
      probe_.called(state_.core.pc, state_.cycle);
      break;
    case Stepped::fault:
      info.reason = StopInfo::Reason::fault;
      info.fault = fault_;
      state_.faulted = true;
      break;
  }
  return info;
}

// One action: a stop, an interrupt entry, idling, a run of blocks, or one exact instruction.
[[gnu::always_inline]] inline Engine::Stepped Engine::act(Cycles limit, bool single, bool dma_busy) {
  Core& core = state_.core;
  if (core.code_writes != 0) process_code_writes();
  if (peripherals_.interface_changed()) {
    peripherals_.interface_settled();
    flush_blocks();
    forget_memory();
  }
  const bool interruptible = may_interrupt();
  if (interruptible) {
    if (const Word vector = interrupts::pending(state_); vector != 0) {
      if (!take_interrupt(vector)) return Stepped::fault;
      return Stepped::done;
    }
    if (core.idle) {
      pass(Cause::idle, limit);
      return Stepped::done;
    }
  }
  if (probe_.on_code()) probe_.reaches(core.pc, state_.cycle);  // first: the program may end at the breakpoint
  if (!single && !breakpoints.empty() && breakpoints.contains(core.pc) && reported_breakpoint_ != state_.cycle)
    return Stepped::breakpoint;
  if (pipelines_.full()) forget_pipelines();
  const bool waiting_interrupt = !interruptible && interrupts::pending(state_) != 0;
  dma_effect_ = dma_side_.effect(dma_busy);
  if (dma_effect_ == DmaEffect::under_way)
    dma_side_.know_accesses();
  else if (!access_.any())
    dma_side_.know_no_accesses();  // a repeated access belongs to an instruction that began before
  const bool one =
      single || trace != nullptr || waiting_interrupt || dma_effect_ != DmaEffect::none || cache_.control_pending();
  if (!one && !exact_only && !onward_.is_missed()) {
    if (CodeBlock* block = onward_.take_inside(); block != nullptr) {
      return run_blocks(block, onward_.at(), limit);
    }
    if (core.delay_slots == 0 && !exact_addresses_.contains(core.pc) && by_blocks()) {
      Stepped why = Stepped::done;
      if (CodeBlock* block = find_or_record(limit, why); block != nullptr) return run_blocks(block, 0, limit);
      return why;
    }
  }
  if (CodeBlock* const left = onward_.often_missed(); left != nullptr && !one && !exact_only) [[unlikely]] {
    Stepped why = Stepped::done;
    if (CodeBlock* block = find_or_record_other(*left, limit, why); block != nullptr)
      return run_blocks(block, 0, limit);
    if (!onward_.is_missed()) return why;
  }
  // No block begins at an end, and none contains one.
  if (!single && at_end() && reported_breakpoint_ != state_.cycle) return Stepped::breakpoint;
  CodeBlock* const missed = onward_.take_missed();
  onward_.clear();
  Step step;
  const Address pc = core.pc;
  if (const Stepped why = exact_step(step, trace != nullptr); why != Stepped::done) return why;
  if (step.repeatable) exact_addresses_.stayed_inside(pc);
  if (missed != nullptr && core.code_writes == 0) rejoin(*missed);
  // Before each instruction a chip that stops at ends looks for one; run_exactly does not look.
  const bool alone = one || stops_at_ends || !breakpoints.empty() || probe_.on_code() || onward_.is_inside();
  return alone ? Stepped::done : run_exactly(limit);
}

[[gnu::always_inline]] inline Engine::Stepped Engine::advance(Cycles limit, bool single) {
  state_.core.attention = false;
  reach_present();
  const bool busy = peripherals_.dma_busy(), waited = peripherals_.dma_active() && !busy;
  const Stepped why = act(std::min(limit, peripherals_.next_event()), single, busy);
  make_dma_current(waited);
  return why;
}

const StopInfo& Engine::run_until(Cycles limit, Cycles known) {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, known);
    return stopped(StopInfo::Reason::limit);
  }
  run_limit_ = known;
  watched_ = watched_ports();
  for (;;) {
    if (peripherals_.dma_active() || dma_side_.stop)
      if (auto info = run_dma(known, false)) {
        if (info->reason != StopInfo::Reason::limit || state_.cycle >= limit) return stop_ = *std::move(info);
        continue;
      }
    const Cycles end = waits_in_idle() ? std::min(known, limit) : limit;
    if (state_.cycle >= end) {
      if ((access_.is_reported() || known > limit) && peripherals_.dma_active())
        if (auto info = run_dma(known, true)) return stop_ = *std::move(info);
      break;
    }
    const Stepped why = advance(end, false);
    if (why != Stepped::done) {
      if (peripherals_.dma_active() && (why == Stepped::port || why == Stepped::external)) {
        if (auto earlier = run_dma(access_.is_reported() ? known : known_before_access(known), true))
          return stop_ = *std::move(earlier);
      }
      access_.set_reported(reports_access(why));
      return stop(why);
    }
    access_.set_reported(false);
    if (watches_another_port()) {
      if (dma_side_.stop && dma_side_.stop->reason == StopInfo::Reason::horizon) dma_side_.stop.reset();  // the same
      return stop(Stepped::horizon);
    }
  }
  // Events of timers keep their order with the DMA: if the DMA is behind, they wait for it.
  const bool dma_is_here = state_.dma.now >= state_.cycle - 1 && peripherals_.next_dma_input() >= state_.cycle;
  if (!peripherals_.dma_active() || !uses_linked_port() || dma_is_here) reach_present();
  return stopped(StopInfo::Reason::limit);
}

const StopInfo& Engine::step() {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, state_.cycle + 1);
    return stopped(StopInfo::Reason::limit);
  }
  run_limit_ = state_.cycle;
  watched_ = ~Word{0};  // links are known as far as one instruction needs them
  if (peripherals_.dma_active() || dma_side_.stop)
    if (auto info = run_dma(run_limit_, false)) return stop_ = *std::move(info);
  if (peripherals_.dma_active() && waits_in_idle()) {
    const Cycles before = state_.cycle;
    if (auto info = run_dma(before + 1, false)) return stop_ = *std::move(info);
    if (state_.cycle != before) {
      reach_present();
      return stopped(StopInfo::Reason::limit);
    }
  }
  const Stepped why = advance(state_.cycle + 1, true);
  if (peripherals_.dma_active() && (why == Stepped::port || why == Stepped::external)) {
    if (auto earlier = run_dma(access_.cycle(), true)) return stop_ = *std::move(earlier);
  }
  access_.set_reported(reports_access(why));
  if (why == Stepped::done && (peripherals_.dma_active() || dma_side_.stop))
    if (auto info = run_dma(waits_in_idle() ? state_.cycle : run_limit_, false)) return stop_ = *std::move(info);
  if (why == Stepped::done) reach_present();
  return stop(why);
}

void Engine::reach_events() {
  const bool waited = peripherals_.dma_waits() && !dma_.ends();
  peripherals_.advance_to(state_.cycle);
  make_dma_current(waited);
}

// A DMA that waited continues no earlier than the event for which it waited.
void Engine::make_dma_current(bool waited) {
  if (waited && dma_.busy()) state_.dma.now = std::max(state_.dma.now, state_.cycle);
}

Word Engine::watched_ports_now() const {
  const Word enabled = state_.core.r[reg::IIE] & interrupts::port_sources;
  Word watched = 0;
  for (unsigned n = 0; enabled >> 4 * n != 0; ++n)
    if (interrupts::port_enables(enabled, n) != 0) watched |= 1u << n;
  if (peripherals_.dma_active()) watched |= dma_.ports_used();
  return watched & ports_.attached();
}

bool Engine::take_interrupt(Word vector) {
  Core& core = state_.core;
  const Address top = core.r[reg::SP] + 1, entry = (core.ivtp & choices::vector_table_mask) + vector;
  const Memory::Area* stack = memory_.find(top);
  const Memory::Area* table = memory_.find(entry);
  for (const auto& [area, address, what] :
       {std::tuple{stack, top, "the stack"}, std::tuple{table, entry, "the vector table"}})
    if (area == nullptr || area->data == nullptr) {
      fail(Fault::Kind::not_modelled,
           fmt::format("interrupt {:02X}h: {} at {:08X}h is not in RAM", vector, what, address), address);
      return false;
    }
  const Cycles before = state_.cycle;
  const Word was = stack->data[top - stack->base];
  poke(top, core.pc);
  core.r[reg::SP] = top;
  core.pc = table->data[entry - table->base];
  interrupts::enter(core, vector);
  const int stack_waits = memory_.meet(*stack, top, true, state_.open_pages).access.waits;
  const int waits = stack_waits + memory_.meet(*table, entry, false, state_.open_pages).access.waits;
  Causes causes{};
  add(causes, Cause::interrupt, timing::interrupt_entry_cost);
  add(causes, Cause::wait_state, waits);
  for (std::size_t i = 0; i < cause_count; ++i) state_.causes[i] += causes[i];
  state_.cycle += timing::interrupt_entry_cost + waits;
  probe_.tell({.address = top,
               .before = was,
               .value = peek(top),
               .write = true,
               .interrupt = true,
               .pc = peek(top),
               .cycle = state_.cycle});
  onward_.clear();
  pipeline_.flush(timing::interrupt_entry_cost + waits);
  dma_side_.flushed(timing::interrupt_entry_cost + waits);
  if (peripherals_.dma_active()) dma_side_.mark_under_way();
  cache_.note_control(before);
  if (trace != nullptr) trace->interrupt({before, vector, causes});
  tell({PeripheralEvent::Kind::interrupt, before, static_cast<int>(vector), peek(top)});
  return true;
}

}  // namespace c40
