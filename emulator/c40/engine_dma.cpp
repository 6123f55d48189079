// Where the DMA coprocessor and the processor meet: memory ports, buses, ports, windows.
//
// The processor is ahead by the read stage of its next instruction: after each of its instructions the DMA follows up to there. In these
// cycles all data accesses are known, and the next two fetches can be told from the pipeline. Whatever the DMA takes is marked
// in the pipeline model, so that later fetches and accesses fit around it: a fetch that has slack costs nothing. A data access
// that the DMA displaces moves with everything after it.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/engine.hpp"
#include "c40/engine_dma.hpp"
#include "c40/interrupts.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {
namespace {

/// The read stage of the next instruction stands one cycle before its execute stage.
constexpr Cycles read_lead = 1;
constexpr Word priority_rotating = 1, priority_dma = 3;
constexpr Word code_level = 1;
/// A DMA of the first priority can keep the processor from its bus for 2^32 words: after so long, who runs the chip is asked.
constexpr Cycles starved_cycles = 10'000;

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
  engine.peripherals_.read(address, at, value);
  return value;
}

void Engine::DmaSide::write(Address address, Word value, Cycles at) {
  const Memory::Area* area = engine.memory_.find(address);
  if (area->data != nullptr) engine.poke(address, value);
  else if (is_port_register(address)) touch_port(port_access(address, true, value, at), at);
  else engine.peripherals_.write(address, value, at);
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
  engine.tell({PeripheralEvent::Kind::dma_end, at, channel, auxiliary});
  if (!interrupt) return;
  engine.peripherals_.raise(interrupts::first_dma_flag << channel);
  engine.dma_.stop_requested = true;
}

std::optional<DmaSurroundings::Span> Engine::DmaSide::acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) {
  const Unit unit = unit_of(place.access);
  if (unit == Unit::none) return Span{from, from + 1 + place.access.waits};
  const bool bus = is_bus(unit);
  const Cycles cycles = bus && place.access.write ? timing::external_write_cycles + place.access.waits : 1 + place.access.waits;
  for (Cycles at = from; at < limit;) {
    const Cycles end = at + cycles + (bus && !place.access.write && follows_write(unit, at) ? timing::read_after_write_cycles : 0);
    const Use use = use_by_processor(unit, at);
    if (use.busy_until > at) {
      lost_to_one_under_way(at, use.busy_until);
      at = use.busy_until;
      continue;
    }
    if (!beside && begins_within(unit, {at, end})) {  // a processor that stands still has posted a write
      ++at;
      continue;
    }
    if ((use.data || use.fetch) && !wins(priority, at)) {
      ++at;
      continue;
    }
    return take(unit, place, {at, end});
  }
  return std::nullopt;
}

DmaSurroundings::Span Engine::DmaSide::take(Unit unit, const DmaPlace& place, Span span) {
  const auto n = static_cast<std::size_t>(unit);
  taken_until[n] = span.end;
  last_taken = std::max(last_taken, span.end);
  if (place.access.write) written[n] = span.end;
  if (!beside) return span;
  displace_data(unit, span);
  const Cycles now = engine.state_.cycle;
  pipeline.take(place.access.resource, static_cast<int>(span.begin - now), static_cast<int>(span.end - now));
  disturbed = true;
  expect_fetches();
  return span;
}

// Data accesses that the span leaves no room for wait until its end, and with them all that come later.
void Engine::DmaSide::displace_data(Unit unit, Span span) {
  const bool bus = is_bus(unit);
  const auto meets = [&](const ProcessorAccess& access) { return unit_of(access.access) == unit && access.begin >= span.begin && access.begin < span.end; };
  Cycles first = span.end;
  int used = 1;
  for (const ProcessorAccess& access : accesses)
    if (meets(access)) first = std::min(first, access.begin), ++used;
  if (first == span.end || (!bus && unit != Unit::peripheral && used <= timing::block_ports)) return;
  const Cycles wait = span.end - first;
  const auto relative = [this](Cycles at) { return static_cast<int>(at - engine.state_.cycle); };
  for (const ProcessorAccess& access : accesses)
    if (access.begin >= first) pipeline.give_back(access.access.resource, relative(access.begin), relative(access.end));
  engine.charge_dma(wait);
  pipeline.hold(static_cast<int>(wait));
  for (ProcessorAccess& access : accesses) {
    if (access.begin < first) continue;
    access.begin += wait, access.end += wait;
    pipeline.make_again(access.access, relative(access.begin), relative(access.end));
  }
  disturbed = true;
}

Engine::DmaSide::Use Engine::DmaSide::use_by_processor(Unit unit, Cycles at) const {
  const bool bus = is_bus(unit);
  Use use{.busy_until = at};
  int data = 0, fetched = 0;
  const bool turns = bus && processor_wrote_until(unit, at);
  // A read straight after a write has the bus for the cycle of the turn as well.
  const auto begins = [&](Cycles begin) { return begin == at || (turns && begin == at + timing::read_after_write_cycles); };
  const auto meet = [&](int& count, Cycles begin, Cycles end) {
    if (bus && begin < at && end > at) use.busy_until = std::max(use.busy_until, end);
    count += begins(begin);
  };
  for (const ProcessorAccess& access : accesses)
    if (unit_of(access.access) == unit) meet(data, access.begin, access.end);
  if (beside)
    for (const Fetch& fetch : fetches)
      if (fetch.unit == unit) meet(fetched, fetch.begin, fetch.end);
  const int room = bus || unit == Unit::peripheral ? 0 : timing::block_ports - 1;
  use.data = data > room;
  use.fetch = fetched != 0 && data + fetched > room;
  return use;
}

bool Engine::DmaSide::begins_within(Unit unit, Span span) const {
  return std::any_of(accesses.begin(), accesses.end(), [&](const ProcessorAccess& access) {
    return unit_of(access.access) == unit && access.begin >= span.begin && access.begin < span.end;
  });
}

// Straight after a write, whoever made it.
bool Engine::DmaSide::follows_write(Unit unit, Cycles at) const {
  return written[static_cast<std::size_t>(unit)] == at || processor_wrote_until(unit, at);
}

bool Engine::DmaSide::processor_wrote_until(Unit unit, Cycles at) const {
  return std::any_of(accesses.begin(), accesses.end(), [&](const ProcessorAccess& access) {
    return unit_of(access.access) == unit && access.access.write && access.end == at;
  });
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

// The conflict lasts as long as the access that the processor makes.
void Engine::DmaSide::lost_to_one_under_way(Cycles at, Cycles until) {
  DmaState& dma = engine.state_.dma;
  if (dma.conflict < at - 1) dma.lost = true;
  if (dma.lost) dma.conflict = until - 1;
}

// The link's next events are others after this: whoever drives it has to look.
Word Engine::DmaSide::touch_port(const PortAccess& access, Cycles at) {
  const Word value = access.perform(engine.ports_[access.port]);
  engine.ports_.accessed(access, value, at, engine.state_.dma.current / 2);
  if (engine.ports_.listener(access.port) != nullptr) touched_link = engine.dma_.stop_requested = true;
  return value;
}

// ---- the engine's side ----

// What the DMA may take while it follows; `beside_processor`: the processor goes on as well.
void Engine::DmaSide::begin_following(bool beside_processor) {
  beside = beside_processor;
  disturbed = false;
  std::erase_if(accesses, [&](const ProcessorAccess& access) { return access.end < engine.state_.dma.now; });
  if (!beside) return;
  know_accesses();
  pipeline = engine.pipeline_.get();
  next_fetches = engine.next_fetches();
  expect_fetches();
}

// Until the DMA goes on, nobody takes note of accesses: of those under way, only their end is known.
void Engine::DmaSide::know_accesses() {
  if (knows_accesses) return;
  accesses.clear();
  const Pipeline& now = engine.pipeline_.get();
  for (const Resource bus : {Resource::local, Resource::global, Resource::peripheral})
    if (const auto end = now.busy_until(bus)) accesses.push_back({{bus, 0, false, false}, long_ago, engine.state_.cycle + *end});
  knows_accesses = true;
}

void Engine::DmaSide::end_following() {
  if (!beside || !disturbed) return;
  if (!undisturbed) undisturbed = engine.pipeline_.id();
  engine.pipeline_.set(engine.pipelines_.intern(pipeline));
}

void Engine::DmaSide::expect_fetches() {
  const auto expected = pipeline.expected_fetches(next_fetches);
  for (std::size_t i = 0; i < 2; ++i) {
    fetches[i] = {};
    if (next_fetches[i]) fetches[i] = {unit_of(*next_fetches[i]), engine.state_.cycle + expected[i].from, engine.state_.cycle + expected[i].to};
  }
}

// After cycles in which the processor stood still: what the DMA has begun goes on.
void Engine::DmaSide::mark_under_way() {
  const PipelineId before = engine.pipeline_.id();
  pipeline = engine.pipelines_[before];
  const Cycles now = engine.state_.cycle;
  for (const auto& [unit, resource] : {std::pair{Unit::local, Resource::local}, std::pair{Unit::global, Resource::global}, std::pair{Unit::peripheral, Resource::peripheral}}) {
    const Cycles until = taken_until[static_cast<std::size_t>(unit)];
    if (until > now - Pipeline::depth) pipeline.take(resource, -Pipeline::depth, static_cast<int>(std::min<Cycles>(until - now, Pipeline::furthest)));
  }
  const PipelineId after = engine.pipelines_.intern(pipeline);
  if (after == before) return;
  if (!undisturbed) undisturbed = before;
  engine.pipeline_.set(after);
}

void Engine::DmaSide::forget() {
  accesses.clear();
  knows_accesses = false;
  taken_until.fill(long_ago);
  written.fill(long_ago);
  last_taken = long_ago;
  undisturbed.reset();
  request.reset();
  stop.reset();
  gained = 0;
}

// The fetches of the next two instructions from memory: of the second, where it stands if nothing branches.
std::array<std::optional<Access>, 2> Engine::next_fetches() {
  const Core& core = state_.core;
  std::array<std::optional<Access>, 2> out{};
  Address pc = core.pc;
  std::uint8_t single = core.repeat_single;
  for (std::size_t i = 0; i < 2; ++i) {
    const Memory::Area* area = memory_.find(pc);
    const bool cached = area != nullptr && external(area->resource) && cache_.on() && cache_.find(pc) != nullptr;
    if (area != nullptr && area->data != nullptr && !cached && single != 2) {
      Memory::OpenPages pages = state_.open_pages;
      out[i] = memory_.meet(*area, pc, false, pages).access;
    }
    const bool more = (core.modes & st::RM) != 0 && pc == core.r[reg::RE] && static_cast<std::int32_t>(core.r[reg::RC]) > 0;
    if (single == 1 && more) single = 2;
    pc = core.delay_slots == 1 ? core.delay_target : more ? core.r[reg::RS] : pc + 1;
  }
  return out;
}

// What the instruction that was begun in cycle `before` used.
void Engine::note_accesses(const Step& step, bool annulled, Cycles before) {
  DmaSide& side = *dma_side_;
  const Cycles waited = state_.cycle - before - step.timing->total;
  const Demand& demand = step.site->demand;
  for (std::size_t i = 0; i < (annulled ? 0u : demand.count); ++i) {
    const Access& access = demand.data[i];
    const Unit unit = unit_of(access);
    if (unit == Unit::none) continue;
    const Cycles start = before + step.timing->start[i];
    const Cycles length = !is_bus(unit) ? 1 : (access.write ? timing::external_write_cycles : 1) + access.waits + waited;
    side.accesses.push_back({access, start, start + length});
  }
}

// What the instruction that is through would have taken if the DMA had been still, where that can differ.
std::optional<StepTiming> Engine::without_dma(const Step& step, bool annulled) {
  DmaSide& side = *dma_side_;
  if (side.undisturbed && state_.cycle > side.last_taken + Pipeline::furthest) side.undisturbed.reset();
  if (!side.undisturbed) return std::nullopt;
  Pipeline pipeline = pipelines_[*side.undisturbed];
  const StepTiming timing = pipeline.advance(demand_through(step, annulled));
  side.undisturbed = pipelines_.intern(pipeline);
  return timing;
}

Engine::DmaEffect Engine::dma_effect() const {
  if (peripherals_.dma_busy()) return DmaEffect::under_way;
  return dma_side_->undisturbed ? DmaEffect::still_felt : DmaEffect::none;
}

bool Engine::waits_in_idle() const { return state_.core.idle && may_interrupt() && interrupts::pending(state_) == 0; }

// How far the DMA may go while the processor runs or idles: everything that the processor does before is known. What the links do is known
// up to `limit` only.
Cycles Engine::known_until(Cycles limit, bool idles) const {
  const Cycles until = idles ? std::max(limit, state_.cycle) : state_.cycle - read_lead;
  return uses_linked_port() ? std::min(limit, until) : until;
}

bool Engine::uses_linked_port() const { return ports_.attached() != 0 && (dma_.ports_used() & ports_.attached()) != 0; }

// Lets the DMA follow the processor, or go on without it while it waits or idles; and the timers, each event in its turn. A stop for the
// reason `limit`: the processor has not got its bus for so long, and the DMA has still not come to where it follows.
std::optional<StopInfo> Engine::run_dma(Cycles limit, bool processor_waits) {
  DmaSide& side = *dma_side_;
  if (auto earlier = std::exchange(side.stop, std::nullopt)) return earlier;
  const Cycles began = state_.cycle;
  const auto moves = [&] { return dma_.busy() || dma_.ends(); };
  const bool moved = processor_waits && peripherals_.dma_active() && moves();
  while (peripherals_.dma_active()) {
    if (!waits_in_idle() && state_.cycle > began + starved_cycles) return StopInfo{};
    if (side.request) return dma_stop(*side.request);
    const bool idles = !processor_waits && waits_in_idle();
    const Cycles until = processor_waits ? limit : known_until(limit, idles);
    const Cycles event = peripherals_.next_event(), to = std::min(until, event);
    if (state_.dma.now >= until && !dma_.ends_at(until) && event > until) break;
    side.begin_following(!processor_waits && !idles);
    const auto request = dma_.advance_to(to);
    side.end_following();
    peripherals_.watch_dma();
    if (idles) pass(Cause::idle, std::min(to, state_.dma.now));
    if (request) return dma_stop(*request);
    if (std::exchange(side.touched_link, false)) return stop(Stepped::horizon);
    if (moved && !moves() && event > dma_.last_done()) break;  // at rest: how far the timers go beyond is for who knows whether anything else is to come
    if (event <= to && state_.dma.now >= event) peripherals_.advance_to(event);
  }
  return std::nullopt;
}

StopInfo Engine::dma_stop(const DmaRequest& request) {
  if (request.nothing_there) {
    const Memory::Area* area = memory_.find(request.address);
    const std::string access = fmt::format("DMA channel {}: {}", request.channel, request.write ? "write to" : "read of");
    if (area == nullptr) nothing_at(access, request.address);
    else fail(Fault::Kind::not_modelled, fmt::format("{} {:08X}h, which is {}", access, request.address, describe_register(request.address)), request.address);
    fault_->cycle = request.cycle;  // the processor may be ahead, or wait since long ago
    return stop(Stepped::fault);
  }
  dma_side_->request = request;
  StopInfo info;
  info.reason = StopInfo::Reason::external_access;
  info.access = {request.address, request.write, false, request.value, request.cycle, request.channel};
  return info;
}

void Engine::complete_dma(bool write, Word value, Cycles waited) {
  if (dma_side_->request->write != write) throw std::logic_error(fmt::format("the DMA does not wait for a {}", write ? "write" : "read"));
  dma_side_->request.reset();
  state_.dma.answered_until = state_.dma.now + waited;
  dma_.answer(value, state_.dma.answered_until);
  peripherals_.watch_dma();
}

}  // namespace c40
