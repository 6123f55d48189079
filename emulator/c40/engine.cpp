#include "c40/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/interrupts.hpp"

namespace c40 {

Engine::Engine(Board board)
    : board_(std::move(board)), memory_(board_), dma_(state_.dma, dma_side_),
      dma_side_({state_, memory_, ports_, peripherals_, cache_, pipelines_, pipeline_, dma_, tell, [this](Address address, Word value) { poke(address, value); }}) {
  reset();
}

void Engine::reset() {
  pipeline_.forget();
  flush_blocks();
  ports_.about_to_reset(state_.cycle);
  const State old = state_;
  state_ = State{};
  state_.cycle = old.cycle;
  state_.instructions = old.instructions;
  state_.causes = old.causes;
  state_.held = old.held;
  state_.iiof_levels = old.iiof_levels;
  state_.iiof_driven = old.iiof_driven;
  state_.nmi_low = old.nmi_low;
  state_.drives = old.drives;
  for (std::size_t n = 0; n < timer_count; ++n) state_.timers[n].start_anew(old.timers[n]);
  state_.ports = old.ports;
  ports_.reset(state_.cycle);
  state_.dma.now = state_.cycle;
  dma_side_.reset();
  peripherals_.state_changed();
  state_.core.e.fill(float40::zero_exponent);
  state_.global_interface_control = board_.global_interface_control;
  state_.local_interface_control = board_.local_interface_control;
  pins_.show_inputs();
  peripherals_.pins_changed();
  cache_.was_reset();
  forget_memory();
  fault_.reset();
  access_.forget();
  reported_breakpoint_.reset();
  touch();
}

State& Engine::touch() {
  dma_side_.forget_undisturbed();
  onward_.clear();
  pipeline_.release();
  return state_;
}

// What is known of memory was found with other interface control registers.
void Engine::forget_memory() {
  memory_.configure(state_.global_interface_control, state_.local_interface_control);
  code_ = {};
  sites_.forget();
}

Word Engine::peek(Address address) const {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr && board_.is_flat) return 0;
  if (area == nullptr) throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data != nullptr) return area->data[address - area->base];
  Word value = 0;
  if (area->kind == Region::Kind::registers && peripherals_.read(address, state_.cycle, value)) return value;
  throw std::out_of_range(fmt::format("address {:08X}h ({}) cannot be read without a bus access", address, area->name));
}

void Engine::poke(Address address, Word value) {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr) throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data == nullptr) {
    if (area->kind == Region::Kind::registers && peripherals_.write(address, value, state_.cycle)) return;
    throw std::out_of_range(fmt::format("address {:08X}h ({}) cannot be written without a bus access", address, area->name));
  }
  const Word offset = address - area->base;
  if ((area->code_map()[offset >> 5] >> (offset & 31) & 1u) != 0) {
    cache_.memory_written(address);
    flush_blocks();
  }
  area->data[offset] = value;
}

// ---- running ----

// Ids are given out anew.
void Engine::forget_pipelines() {
  flush_blocks();
  touch();
  pipelines_.clear();
  sites_.forget_transitions();
}

void Engine::pass(Cause cause, Cycles until) {
  if (until <= state_.cycle) return;
  if (cause == Cause::idle) idle_.idled(state_.cycle, until);
  add(state_.causes, cause, until - state_.cycle);
  state_.cycle = until;
  pipeline_.set(PipelineTable::drained);
}

StopInfo Engine::stop(Stepped why) {
  if (cache_.control_pending()) [[unlikely]] settle_cache_control();  // the DMA may have gone on while the processor idled
  StopInfo info;
  switch (why) {
    case Stepped::done: break;
    case Stepped::external:
      info.reason = StopInfo::Reason::external_access;
      info.access = access_.window();
      break;
    case Stepped::breakpoint: info.reason = StopInfo::Reason::breakpoint; break;
    case Stepped::port:
      info.reason = ports_.listener(access_.port().port) != nullptr ? StopInfo::Reason::port_access : StopInfo::Reason::port_wait;
      info.port = access_.port();
      break;
    case Stepped::horizon: info.reason = StopInfo::Reason::horizon; break;
    case Stepped::software_interrupt: info.reason = StopInfo::Reason::software_interrupt; break;
    case Stepped::fault:
      info.reason = StopInfo::Reason::fault;
      info.fault = fault_;
      state_.faulted = true;
      break;
  }
  return info;
}

bool Engine::may_interrupt() const {
  return state_.core.delay_slots == 0 && state_.core.repeat_single == 0 && !state_.answers[0].given && !state_.answers[1].given &&
         !access_.at_port();
}

Engine::Stepped Engine::advance(Cycles limit, bool single) {
  state_.core.attention = false;
  reach_present();
  const bool waited = peripherals_.dma_waits();
  const Stepped why = act(std::min(limit, peripherals_.next_event()), single);
  make_dma_current(waited);
  return why;
}

// One thing: a stop, an interrupt entry, idling, a run of blocks, or one exact instruction.
Engine::Stepped Engine::act(Cycles limit, bool single) {
  Core& core = state_.core;
  if (core.code_writes != 0) process_code_writes();
  if (peripherals_.interface_changed()) {
    peripherals_.interface_settled();
    flush_blocks();
    forget_memory();
  }
  if (may_interrupt()) {
    if (const Word vector = interrupts::pending(state_); vector != 0) {
      if (!take_interrupt(vector)) return Stepped::fault;
      return Stepped::done;
    }
    if (core.idle) {
      pass(Cause::idle, limit);
      return Stepped::done;
    }
  }
  if (!single && !breakpoints.empty() && breakpoints.contains(core.pc) && reported_breakpoint_ != state_.cycle) {
    reported_breakpoint_ = state_.cycle;
    return Stepped::breakpoint;
  }
  if (pipelines_.full()) forget_pipelines();
  const bool answered = state_.answers[0].given || state_.answers[1].given;
  const bool waiting_interrupt = !may_interrupt() && interrupts::pending(state_) != 0;
  dma_effect_ = dma_side_.effect();
  if (dma_effect_ == DmaEffect::under_way) dma_side_.know_accesses();
  else dma_side_.know_no_accesses();
  const bool one = single || trace != nullptr || answered || waiting_interrupt || dma_effect_ != DmaEffect::none || cache_.control_pending();
  if (!one && !exact_only && !onward_.is_missed()) {
    if (Block* block = onward_.take_inside(); block != nullptr) {
      run_blocks(block, onward_.at(), limit);
      return Stepped::done;
    }
    if (core.delay_slots == 0 && !exact_sites_.contains(core.pc) && by_blocks()) {
      Stepped why = Stepped::done;
      if (Block* block = find_or_record(limit, why); block != nullptr) run_blocks(block, 0, limit);
      return why;
    }
  }
  Block* const missed = onward_.take_missed();
  onward_.clear();
  Step step;
  const Address pc = core.pc;
  if (const Stepped why = exact_step(step, trace != nullptr); why != Stepped::done) return why;
  if (step.plain) exact_sites_.stayed_inside(pc);
  if (missed != nullptr && core.code_writes == 0) rejoin(*missed);
  return one || !breakpoints.empty() || onward_.is_inside() ? Stepped::done : run_exactly(limit);
}

StopInfo Engine::run_until(Cycles limit, Cycles known) {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, known);
    return {};
  }
  run_limit_ = known;
  const Word watched = watched_ports();
  const bool waits = access_.is_told();
  for (;;) {
    if (peripherals_.dma_active() || dma_side_.stop)
      if (auto info = run_dma(known, false)) {
        if (info->reason != StopInfo::Reason::limit || state_.cycle >= limit) return *info;
        continue;
      }
    const Cycles end = waits_in_idle() ? std::min(known, limit) : limit;
    if (state_.cycle >= end) {
      if ((waits || known > limit) && peripherals_.dma_active())
        if (auto info = run_dma(known, true)) return *info;
      break;
    }
    const Stepped why = advance(end, false);
    if (why != Stepped::done) {
      if (peripherals_.dma_active() && (why == Stepped::port || why == Stepped::external)) {
        if (auto earlier = run_dma(waits ? known : std::min(known, access_.cycle()), true)) return *earlier;
      }
      access_.set_told(true);
      return stop(why);
    }
    access_.set_told(false);
    if (ports_.attached() != 0 && (watched_ports() & ~watched) != 0) return stop(Stepped::horizon);
  }
  // Events of timers come in their turn, as the DMA does: where it is behind, they wait for it.
  if (!peripherals_.dma_active() || !uses_linked_port() || state_.dma.now >= state_.cycle - 1) reach_present();
  return {};
}

StopInfo Engine::step() {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, state_.cycle + 1);
    return {};
  }
  run_limit_ = state_.cycle;
  if (peripherals_.dma_active() || dma_side_.stop)
    if (auto info = run_dma(run_limit_, false)) return *info;
  if (peripherals_.dma_active() && waits_in_idle()) {
    const Cycles before = state_.cycle;
    if (auto info = run_dma(before + 1, false)) return *info;
    if (state_.cycle != before) {
      reach_present();
      return {};
    }
  }
  const Stepped why = advance(state_.cycle + 1, true);
  if (peripherals_.dma_active() && (why == Stepped::port || why == Stepped::external)) {
    if (auto earlier = run_dma(access_.cycle(), true)) return *earlier;
  }
  access_.set_told(why != Stepped::done);
  if (why == Stepped::done && (peripherals_.dma_active() || dma_side_.stop))
    if (auto info = run_dma(waits_in_idle() ? state_.cycle : run_limit_, false)) return *info;
  if (why == Stepped::done) reach_present();
  return stop(why);
}

// What has happened by the present cycle: timers' events, and what the cache is told.
void Engine::reach_present() {
  if (state_.cycle >= peripherals_.next_event()) {
    const bool waited = peripherals_.dma_waits() && !dma_.ends();
    peripherals_.advance_to(state_.cycle);
    make_dma_current(waited);
  }
  if (cache_.control_pending()) [[unlikely]] settle_cache_control();
}

// A DMA that waited goes on no earlier than what it waited for.
void Engine::make_dma_current(bool waited) {
  if (waited && dma_.busy()) state_.dma.now = std::max(state_.dma.now, state_.cycle);
}

void Engine::complete(bool write, Word value, Cycles arbitration, Cycles transfer) {
  if (dma_side_.request) return complete_dma(write, value, arbitration + transfer);
  access_.answer_window(write, value, arbitration, transfer);
}

}  // namespace c40
