#include "c40/peripherals/dma_side.hpp"

#include <algorithm>
#include <utility>

#include "c40/chip/interrupts.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {
namespace {

constexpr Word priority_rotating = 1, priority_dma = 3;
constexpr Word code_level = 1;

constexpr bool is_bus(Unit unit) { return unit == Unit::local || unit == Unit::global; }

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

}  // namespace

DmaPlace DmaSide::place(Address address, bool write) {
  const Memory::Area* area = chip_.memory.find(address);
  if (area == nullptr) return {};
  if (write && area->kind == Region::Kind::rom) return {};
  Memory::OpenPages pages = chip_.state.open_pages;
  const Access access = chip_.memory.meet(*area, address, write, pages).access;
  if (area->kind == Region::Kind::external_window) return {DmaPlace::Kind::window, access};
  if (area->kind == Region::Kind::registers) {
    if (is_port_register(address)) return {DmaPlace::Kind::port, access};
    return {register_at(address) != nullptr ? DmaPlace::Kind::peripheral : DmaPlace::Kind::nothing, access};
  }
  return {area->data != nullptr ? DmaPlace::Kind::memory : DmaPlace::Kind::nothing, access};
}

Word DmaSide::read(Address address, Cycles at) {
  const Memory::Area* area = chip_.memory.find(address);
  if (area->data != nullptr && !area->set_apart) return area->data[address - area->base];
  Word value = 0;
  if (area->data != nullptr)
    value = area->data[address - area->base];
  else if (is_port_register(address))
    value = touch_port(port_access(address, false, 0, at), at);
  else
    chip_.peripherals.read(address, at, value);
  tell_probe(chip_.state.dma.current / 2, address, value, value, false, at);
  return value;
}

// The DMA follows the processor's read stage: a processor that has come to this cycle has left the DMA's cycle behind.
void DmaSide::tell_probe(int channel, Address address, Word before, Word value, bool write, Cycles at) {
  chip_.probe.tell({.address = address,
                    .before = before,
                    .value = value,
                    .write = write,
                    .channel = channel,
                    .pc = chip_.state.core.pc,
                    .cycle = at + 1 + read_lead});
}

void DmaSide::write(Address address, Word value, Cycles at) {
  const Memory::Area* area = chip_.memory.find(address);
  const Word before = area->data != nullptr ? area->data[address - area->base] : value;
  const int channel = chip_.state.dma.current / 2;  // the write may put it in reset
  if (area->data != nullptr)
    chip_.poke(address, value);
  else if (is_port_register(address))
    touch_port(port_access(address, true, value, at), at);
  else
    chip_.peripherals.write(address, value, at);
  if (area->data == nullptr || area->set_apart) tell_probe(channel, address, before, value, true, at);
}

bool DmaSide::port_ready(Address address, bool write) const {
  const PortAccess access = port_access(address, write, 0, 0);
  return access.ready(chip_.state.ports[static_cast<std::size_t>(access.port)]);
}

// Code 1 is the FIFO of the port with the channel's own number; the others are latched (c40-hardware.md 3.8).
std::optional<bool> DmaSide::level(int channel, bool write, Word code) const {
  if (code != code_level) return std::nullopt;
  const CommPort& port = chip_.state.ports[static_cast<std::size_t>(channel)];
  return write ? port.ocrdy() : port.icrdy();
}

Word DmaSide::dma_interrupt_enable() const { return chip_.peripherals.dma_interrupt_enable(); }

void DmaSide::block_ended(int channel, bool auxiliary, bool interrupt, Cycles at) {
  chip_.tell({PeripheralEvent::Kind::dma_end, at, channel, auxiliary});
  if (!interrupt) return;
  chip_.peripherals.raise(interrupts::first_dma_flag << channel, at);
  chip_.dma.stop_requested = true;
}

void DmaSide::started(int channel, Word control, Cycles at) {
  chip_.tell({PeripheralEvent::Kind::dma_start, at, channel, control});
}

std::optional<DmaContext::Span> DmaSide::acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) {
  const Unit unit = unit_of(place.access);
  if (unit == Unit::none) return Span{from, from + 1 + place.access.waits};
  const bool bus = is_bus(unit);
  const Cycles cycles =
      bus && place.access.write ? timing::external_write_cycles + place.access.waits : 1 + place.access.waits;
  for (Cycles at = from; at < limit;) {
    const Cycles end =
        at + cycles + (bus && !place.access.write && follows_write(unit, at) ? timing::read_after_write_cycles : 0);
    const Use use = use_by_processor(unit, at);
    if (use.busy_until > at) {
      lost_to_one_under_way(at, use.busy_until);
      at = use.busy_until;
      continue;
    }
    if (!beside_ && begins_within(unit, {at, end})) {  // a processor that is stopped has posted a write
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

DmaContext::Span DmaSide::take(Unit unit, const DmaPlace& place, Span span) {
  const auto n = static_cast<std::size_t>(unit);
  taken_until_[n] = span.end;
  last_taken_ = std::max(last_taken_, span.end);
  if (place.access.write) written_[n] = span.end;
  if (!beside_) return span;
  displace_data(unit, span);
  const Cycles now = chip_.state.cycle;
  pipeline_.take(place.access.resource, static_cast<int>(span.begin - now), static_cast<int>(span.end - now));
  disturbed_ = true;
  expect_fetches();
  return span;
}

// Data accesses_ for which the span leaves no room wait until its end, and all later accesses with them.
void DmaSide::displace_data(Unit unit, Span span) {
  const bool bus = is_bus(unit);
  const auto meets = [&](const ProcessorAccess& access) {
    return unit_of(access.access) == unit && access.begin >= span.begin && access.begin < span.end;
  };
  Cycles first = span.end;
  int used = 1;
  for (const ProcessorAccess& access : accesses_)
    if (meets(access)) first = std::min(first, access.begin), ++used;
  if (first == span.end || (!bus && unit != Unit::peripheral && used <= timing::block_ports)) return;
  const Cycles wait = span.end - first;
  const auto relative = [this](Cycles at) { return static_cast<int>(at - chip_.state.cycle); };
  for (const ProcessorAccess& access : accesses_)
    if (access.begin >= first)
      pipeline_.give_back(access.access.resource, relative(access.begin), relative(access.end));
  charge(wait);
  pipeline_.hold(static_cast<int>(wait));
  for (ProcessorAccess& access : accesses_) {
    if (access.begin < first) continue;
    access.begin += wait, access.end += wait;
    pipeline_.make_again(access.access, relative(access.begin), relative(access.end));
  }
  disturbed_ = true;
}

DmaSide::Use DmaSide::use_by_processor(Unit unit, Cycles at) const {
  const bool bus = is_bus(unit);
  Use use{.busy_until = at};
  int data = 0, fetched = 0;
  const bool turns = bus && processor_wrote_until(unit, at);
  // A read directly after a write also has the bus in the cycle of the turnaround.
  const auto begins = [&](Cycles begin) {
    return begin == at || (turns && begin == at + timing::read_after_write_cycles);
  };
  const auto meet = [&](int& count, Cycles begin, Cycles end) {
    if (bus && begin < at && end > at) use.busy_until = std::max(use.busy_until, end);
    count += begins(begin);
  };
  for (const ProcessorAccess& access : accesses_)
    if (unit_of(access.access) == unit) meet(data, access.begin, access.end);
  if (beside_)
    for (const Fetch& fetch : fetches_)
      if (fetch.unit == unit) meet(fetched, fetch.begin, fetch.end);
  const int room = bus || unit == Unit::peripheral ? 0 : timing::block_ports - 1;
  use.data = data > room;
  use.fetch = fetched != 0 && data + fetched > room;
  return use;
}

bool DmaSide::begins_within(Unit unit, Span span) const {
  return std::any_of(accesses_.begin(), accesses_.end(), [&](const ProcessorAccess& access) {
    return unit_of(access.access) == unit && access.begin >= span.begin && access.begin < span.end;
  });
}

// Directly after a write of the processor or the DMA.
bool DmaSide::follows_write(Unit unit, Cycles at) const {
  return written_[static_cast<std::size_t>(unit)] == at || processor_wrote_until(unit, at);
}

bool DmaSide::processor_wrote_until(Unit unit, Cycles at) const {
  return std::any_of(accesses_.begin(), accesses_.end(), [&](const ProcessorAccess& access) {
    return unit_of(access.access) == unit && access.access.write && access.end == at;
  });
}

// Priority 01: the processor wins the first conflict; while conflicts follow each other, processor and DMA take turns
// (c40-hardware.md 3.4).
bool DmaSide::wins(Word priority, Cycles at) {
  if (priority == priority_dma) return true;
  if (priority != priority_rotating) return false;
  DmaState& dma = chip_.state.dma;
  const bool turn = dma.lost && dma.conflict == at - 1;
  dma.conflict = at;
  dma.lost = !turn;
  return turn;
}

// The conflict lasts as long as the processor's access.
void DmaSide::lost_to_one_under_way(Cycles at, Cycles until) {
  DmaState& dma = chip_.state.dma;
  if (dma.conflict < at - 1) dma.lost = true;
  if (dma.lost) dma.conflict = until - 1;
}

// This changes the link's next events: the link's driver has to look again.
Word DmaSide::touch_port(const PortAccess& access, Cycles at) {
  const Word value = access.perform(chip_.ports[access.port]);
  chip_.ports.accessed(access, value, at, chip_.state.dma.current / 2);
  if (chip_.ports.listener(access.port) != nullptr) touched_link_ = chip_.dma.stop_requested = true;
  return value;
}

// ---- beside the processor ----

void DmaSide::begin_following(bool beside_processor) {
  beside_ = beside_processor;
  disturbed_ = false;
  know_accesses();
  std::erase_if(accesses_, [&](const ProcessorAccess& access) { return access.end < chip_.state.dma.now; });
  if (!beside_) return;
  pipeline_ = chip_.pipeline.get();
  next_fetches_ = fetches_from_memory();
  expect_fetches();
}

// While the DMA rests, accesses are not noted: for those under way only the end is known.
void DmaSide::know_accesses() {
  if (knows_accesses_) return;
  accesses_.clear();
  const Pipeline& now = chip_.pipeline.get();
  for (const Resource bus : {Resource::local, Resource::global, Resource::peripheral})
    if (const auto end = now.busy_until(bus))
      accesses_.push_back({{bus, 0, false, false}, long_ago, chip_.state.cycle + *end});
  knows_accesses_ = true;
}

void DmaSide::end_following() {
  if (!beside_ || !disturbed_) return;
  if (!undisturbed_) undisturbed_ = chip_.pipeline.id();
  chip_.pipeline.set(chip_.pipelines.intern(pipeline_));
}

void DmaSide::expect_fetches() {
  const auto expected = pipeline_.expected_fetches(next_fetches_);
  for (std::size_t i = 0; i < 2; ++i) {
    fetches_[i] = {};
    if (next_fetches_[i])
      fetches_[i] = {unit_of(*next_fetches_[i]), chip_.state.cycle + expected[i].from,
                     chip_.state.cycle + expected[i].to};
  }
}

// After cycles in which the processor was stopped: the DMA continues what it has begun.
void DmaSide::mark_under_way() {
  const PipelineId before = chip_.pipeline.id();
  pipeline_ = chip_.pipelines[before];
  const Cycles now = chip_.state.cycle;
  for (const auto& [unit, resource] :
       {std::pair{Unit::local, Resource::local}, std::pair{Unit::global, Resource::global},
        std::pair{Unit::peripheral, Resource::peripheral}}) {
    const Cycles until = taken_until_[static_cast<std::size_t>(unit)];
    if (until > now - Pipeline::depth)
      pipeline_.take(resource, -Pipeline::depth, static_cast<int>(std::min<Cycles>(until - now, Pipeline::furthest)));
  }
  const PipelineId after = chip_.pipelines.intern(pipeline_);
  if (after == before) return;
  if (!undisturbed_) undisturbed_ = before;
  chip_.pipeline.set(after);
}

void DmaSide::stand_still(Cycles from, Cycles cycles) {
  DmaState& dma = chip_.state.dma;
  const Cycles later = std::max(dma.now, from) + cycles - dma.now;
  dma.now += later;
  chip_.peripherals.delay_dma_inputs(later);
  if (request) request->cycle += later;
  const auto delay = [=](Cycles& end) {
    if (end > from) end += cycles;
  };
  delay(dma.answered_until);
  for (DmaChannel& channel : dma.channels)
    for (DmaHalf& half : channel.halves) delay(half.since), delay(half.first);
  std::ranges::for_each(taken_until_, delay);
  std::ranges::for_each(written_, delay);
  delay(last_taken_);
}

void DmaSide::reset() {
  accesses_.clear();
  knows_accesses_ = false;
  taken_until_.fill(long_ago);
  written_.fill(long_ago);
  last_taken_ = long_ago;
  undisturbed_.reset();
  gained_ = 0;
  request.reset();
  stop.reset();
}

// The fetches of the next two instructions from memory; for the second, its address if no branch is taken.
std::array<std::optional<Access>, 2> DmaSide::fetches_from_memory() const {
  const Core& core = chip_.state.core;
  std::array<std::optional<Access>, 2> out{};
  Address pc = core.pc;
  std::uint8_t single = core.repeat_single;
  for (std::size_t i = 0; i < 2; ++i) {
    const Memory::Area* area = chip_.memory.find(pc);
    const bool cached =
        area != nullptr && external(area->resource) && chip_.cache.on() && chip_.cache.find(pc) != nullptr;
    if (area != nullptr && area->data != nullptr && !cached && single != 2) {
      Memory::OpenPages pages = chip_.state.open_pages;
      out[i] = chip_.memory.meet(*area, pc, false, pages).access;
    }
    const bool more =
        (core.modes & st::RM) != 0 && pc == core.r[reg::RE] && static_cast<std::int32_t>(core.r[reg::RC]) > 0;
    if (single == 1 && more) single = 2;
    pc = core.delay_slots == 1 ? core.delay_target : more ? core.r[reg::RS] : pc + 1;
  }
  return out;
}

void DmaSide::note_accesses(const Demand& demand, const StepTiming& timing, Cycles before) {
  const Cycles waited = chip_.state.cycle - before - timing.total;
  for (std::size_t i = 0; i < demand.count; ++i) {
    const Access& access = demand.data[i];
    const Unit unit = unit_of(access);
    if (unit == Unit::none) continue;
    const Cycles start = before + timing.start[i];
    const Cycles length =
        !is_bus(unit) ? 1 : (access.write ? timing::external_write_cycles : 1) + access.waits + waited;
    accesses_.push_back({access, start, start + length});
  }
}

std::optional<StepTiming> DmaSide::without_dma(const Demand& demand) {
  if (undisturbed_ && chip_.state.cycle > last_taken_ + Pipeline::furthest) undisturbed_.reset();
  if (!undisturbed_) return std::nullopt;
  Pipeline alone = chip_.pipelines[*undisturbed_];
  const StepTiming timing = alone.advance(demand);
  undisturbed_ = chip_.pipelines.intern(alone);
  return timing;
}

void DmaSide::flushed(Cycles cycles) {
  if (undisturbed_) undisturbed_ = chip_.pipelines.flushed(*undisturbed_, cycles);
}

void DmaSide::charge(Cycles held) {
  const Cycles paid = std::min(gained_, held);
  gained_ -= paid;
  add(chip_.state.causes, Cause::memory_conflict, paid);
  add(chip_.state.causes, Cause::dma_conflict, held - paid);
  chip_.state.cycle += held;
}

}  // namespace c40
