// Where the DMA coprocessor and the processor meet: memory ports, buses, ports, windows.
//
// The processor is ahead: after each of its instructions the DMA follows, up to the last cycle in which everything that the
// processor does is known. What a conflict costs the processor is added after the instruction, as it holds everything.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "c40/engine.hpp"
#include "c40/engine_dma.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {
namespace {

/// The read stage of the next instruction stands one cycle before its execute stage.
constexpr Cycles read_lead = 1;
constexpr Word priority_rotating = 1, priority_dma = 3;
constexpr Word first_dma_flag = 1u << 25;
constexpr Word code_level = 1;

constexpr bool is_bus(Unit unit) { return unit == Unit::local || unit == Unit::global; }

}  // namespace

Unit unit_of(const Access& access) {
  switch (access.resource) {
    case Resource::ram0: return Unit::ram0;
    case Resource::ram1: return Unit::ram1;
    case Resource::local: return Unit::local;
    case Resource::rom: return Unit::rom;
    case Resource::global: return Unit::global;
    case Resource::peripheral: return Unit::peripheral;
    case Resource::ideal: break;
  }
  return Unit::none;
}

DmaPlace Engine::DmaSide::place(Address address, bool write) {
  const Memory::Area* area = engine.memory_.find(address);
  if (area == nullptr) return {};
  if (write && area->kind == Region::Kind::rom) return {};
  Memory::OpenPages pages = engine.state_.open_pages;
  const Access access = engine.memory_.meet(*area, address, write, pages).access;
  if (area->kind == Region::Kind::external_window) return {DmaPlace::Kind::window, access};
  if (area->kind == Region::Kind::registers) {
    if (is_port_register(address)) return {DmaPlace::Kind::port, access};
    return {register_at(address) != nullptr ? DmaPlace::Kind::peripheral : DmaPlace::Kind::nothing, access};
  }
  return {area->data != nullptr ? DmaPlace::Kind::memory : DmaPlace::Kind::nothing, access};
}

Word Engine::DmaSide::read(Address address, Cycles at) {
  const Memory::Area* area = engine.memory_.find(address);
  if (area->data != nullptr) return area->data[address - area->base];
  Word value = 0;
  if (is_port_register(address)) return touch_port(port_access(address, false, 0, at), at);
  engine.read_register(address, at, value);
  return value;
}

void Engine::DmaSide::write(Address address, Word value, Cycles at) {
  const Memory::Area* area = engine.memory_.find(address);
  if (area->data != nullptr) engine.poke(address, value);
  else if (is_port_register(address)) touch_port(port_access(address, true, value, at), at);
  else engine.write_register(address, value, at);
}

bool Engine::DmaSide::port_ready(Address address, bool write) const {
  const PortAccess access = port_access(address, write, 0, 0);
  return access.ready(engine.state_.ports[static_cast<std::size_t>(access.port)]);
}

// Code 1 is the FIFO of the port with the channel's own number; the others are latched (3.8).
std::optional<bool> Engine::DmaSide::level(int channel, bool write, Word code) const {
  if (code != code_level) return std::nullopt;
  const CommPort& port = engine.state_.ports[static_cast<std::size_t>(channel)];
  return write ? port.ocrdy() : port.icrdy();
}

Word Engine::DmaSide::dma_interrupt_enable() const { return engine.state_.core.r[reg::DIE]; }

void Engine::DmaSide::block_ended(int channel, bool auxiliary, bool interrupt, Cycles at) {
  engine.tell(PeripheralEvent::Kind::dma_end, at, channel, auxiliary);
  if (!interrupt) return;
  engine.raise_flag(first_dma_flag << channel);
  engine.dma_.stop_requested = true;
}

std::optional<DmaSurroundings::Span> Engine::DmaSide::acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) {
  const Unit unit = unit_of(place.access);
  if (unit == Unit::none) return Span{from, from + 1 + place.access.waits};
  const bool bus = is_bus(unit);
  const Cycles cycles = bus && place.access.write ? timing::external_write_cycles + place.access.waits : 1 + place.access.waits;
  const int ports = bus || unit == Unit::peripheral ? 1 : timing::block_ports;
  for (Cycles at = from; at < limit;) {
    const Cycles end = at + cycles + (bus && !place.access.write && written_until(unit) == at ? timing::read_after_write_cycles : 0);
    if (const Cycles busy = under_way(unit, at); busy > at && bus) {
      at = busy;
      continue;
    }
    const int used = used_by_processor(unit, at, end);
    if (used < ports) return take(unit, place, {at, end});
    if (!wins(priority, at)) {
      ++at;
      continue;
    }
    stall_processor(at, end - at);
    return take(unit, place, {at, end});
  }
  return std::nullopt;
}

DmaSurroundings::Span Engine::DmaSide::take(Unit unit, const DmaPlace& place, Span span) {
  const auto n = static_cast<std::size_t>(unit);
  taken_until[n] = span.end;
  if (place.access.write) written[n] = span.end;
  return span;
}

// Of an access of the processor that began before `at`: when the unit is free.
Cycles Engine::DmaSide::under_way(Unit unit, Cycles at) const {
  Cycles end = at;
  for (const ProcessorAccess& access : accesses)
    if (access.unit == unit && access.begin < at) end = std::max(end, access.end);
  return end;
}

Cycles Engine::DmaSide::written_until(Unit unit) const {
  Cycles end = written[static_cast<std::size_t>(unit)];
  for (const ProcessorAccess& access : accesses)
    if (access.unit == unit && access.write) end = std::max(end, access.end);
  return end;
}

// Accesses that begin in the span; one of them may be the fetch that is to be expected there.
int Engine::DmaSide::used_by_processor(Unit unit, Cycles begin, Cycles end) const {
  int used = 0;
  for (const ProcessorAccess& access : accesses) used += access.unit == unit && access.begin >= begin && access.begin < end;
  const bool fetches = fetch_unit == unit && !engine.state_.core.idle && end > engine.state_.cycle + engine.pipelines_[engine.current_pipeline()].earliest_fetch();
  return used + fetches;
}

// Priority 01: the processor wins the first conflict, then they take turns as long as conflicts follow each other (3.4).
bool Engine::DmaSide::wins(Word priority, Cycles at) {
  if (priority == priority_dma) return true;
  if (priority != priority_rotating) return false;
  DmaState& dma = engine.state_.dma;
  const bool turn = dma.lost && dma.conflict == at - 1;
  dma.conflict = at;
  dma.lost = !turn;
  return turn;
}

void Engine::DmaSide::stall_processor(Cycles at, Cycles cycles) {
  for (ProcessorAccess& access : accesses)
    if (access.begin >= at) access.begin += cycles, access.end += cycles;
  engine.state_.causes[static_cast<std::size_t>(Cause::memory_conflict)] += cycles;
  engine.state_.cycle += cycles;
}

// The link's next events are others after this: whoever drives it has to look.
Word Engine::DmaSide::touch_port(const PortAccess& access, Cycles at) {
  CommPort& side = engine.port(access.port);
  const Word value = access.perform(side);
  engine.tell_word(access, value, at, engine.state_.dma.current / 2);
  if (PortListener* link = engine.listener(access.port); link != nullptr) {
    link->changed(side, at);
    touched_link = engine.dma_.stop_requested = true;
  }
  return value;
}

// ---- the engine's side ----

// What the instruction that was begun in cycle `before` used; it waits for a bus that the DMA is using.
void Engine::note_accesses(const Step& step, bool annulled, Cycles before) {
  DmaSide& side = *dma_side_;
  const Cycles waited = state_.cycle - before - step.timing->total;
  std::erase_if(side.accesses, [&](const ProcessorAccess& access) { return access.end <= state_.dma.now; });
  side.fetch_unit = step.fetched ? unit_of(step.fetch) : Unit::none;
  Cycles stall = 0;
  const auto wait_for = [&](Unit unit, Cycles begin) {
    if (is_bus(unit)) stall = std::max(stall, side.taken_until[static_cast<std::size_t>(unit)] - begin);
  };
  wait_for(side.fetch_unit, before + step.timing->stages.fetch);
  const Demand& demand = step.site->demand;
  for (std::size_t i = 0; i < (annulled ? 0u : demand.count); ++i) {
    const Access& access = demand.data[i];
    const Unit unit = unit_of(access);
    const Cycles start = before + step.timing->start[i];
    wait_for(unit, start);
    const Cycles length = !is_bus(unit) ? 1 : (access.write ? timing::external_write_cycles : 1) + access.waits + waited;
    side.accesses.push_back({unit, access.write, start + stall, start + stall + length});
  }
  state_.causes[static_cast<std::size_t>(Cause::memory_conflict)] += stall;
  state_.cycle += stall;
}

void Engine::watch_dma() { dma_active_ = dma_.active() || state_.dma.waits_for_answer; }

bool Engine::waits_in_idle() const { return state_.core.idle && may_interrupt() && pending_vector() == 0; }

// Lets the DMA follow the processor, or go on without it while it waits or idles.
std::optional<StopInfo> Engine::run_dma(Cycles limit, bool processor_waits) {
  for (;;) {
    if (dma_request_) return dma_stop(*dma_request_);
    const bool idles = !processor_waits && waits_in_idle();
    const Cycles until = processor_waits || idles ? limit : std::min(limit, state_.cycle - read_lead);
    if (state_.dma.now >= until && !dma_.ends_at(until)) return std::nullopt;
    dma_side_->touched_link = false;
    const auto request = dma_.advance_to(until);
    watch_dma();
    if (idles) pass(Cause::idle, std::min(limit, state_.dma.now));
    if (request) return dma_stop(*request);
    if (dma_side_->touched_link) return stop(Stepped::horizon);
  }
}

StopInfo Engine::dma_stop(const DmaRequest& request) {
  if (request.nothing_there) {
    const Memory::Area* area = memory_.find(request.address);
    const bool reserved = area == nullptr;
    fail(reserved ? Fault::Kind::reserved_address : Fault::Kind::not_modelled,
         fmt::format("DMA channel {}: {} {:08X}h, which is {}", request.channel, request.write ? "write to" : "read of", request.address,
                     reserved ? fmt::format("reserved on board {}", board_.name) : describe_register(request.address)),
         request.address);
    return stop(Stepped::fault);
  }
  dma_request_ = request;
  StopInfo info;
  info.reason = StopInfo::Reason::external_access;
  info.access = {request.address, request.write, false, request.value, request.cycle, request.channel};
  return info;
}

void Engine::complete_dma(bool write, Word value, Cycles waited) {
  if (dma_request_->write != write) throw std::logic_error(fmt::format("the DMA does not wait for a {}", write ? "write" : "read"));
  dma_request_.reset();
  state_.dma.answered_until = state_.dma.now + waited;
  dma_.answer(value, state_.dma.answered_until);
  watch_dma();
}

}  // namespace c40
