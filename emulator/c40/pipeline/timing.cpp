#include "c40/pipeline/timing.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace c40 {
namespace {

constexpr unsigned first_address_register = 8;  // AR0; then AR1..AR7, DP, IR0, IR1, BK, SP

constexpr bool in_block(Resource r) { return r == Resource::ram0 || r == Resource::ram1 || r == Resource::rom; }
constexpr bool on_bus(Resource r) { return r >= Resource::local; }
constexpr std::size_t block_of(Resource r) {
  return static_cast<std::size_t>(r) - static_cast<std::size_t>(Resource::ram0);
}
constexpr std::size_t bus_of(Resource r) {
  return static_cast<std::size_t>(r) - static_cast<std::size_t>(Resource::local);
}
constexpr std::size_t peripheral_bus = bus_of(Resource::peripheral);
constexpr int write_cycles(std::size_t bus) {
  return bus == peripheral_bus ? timing::peripheral_write_cycles : timing::external_write_cycles;
}
constexpr int read_after_write(std::size_t bus) { return bus == peripheral_bus ? 0 : timing::read_after_write_cycles; }

template <class Visit>
void each_register(std::uint32_t mask, Visit visit) {
  for (mask = mask >> first_address_register & 0x1FFFu; mask != 0; mask &= mask - 1)
    visit(static_cast<std::size_t>(std::countr_zero(mask)));
}

/// The start of the first of the instruction's reads: with it begins R.
std::optional<int> first_read(const Demand& demand, const StepTiming& timing) {
  std::optional<int> first;
  for (std::size_t i = 0; i < demand.count; ++i)
    if (!demand.data[i].write) first = std::min(first.value_or(timing.start[i]), timing.start[i]);
  return first;
}

std::int8_t clamp8(int value, int low) { return static_cast<std::int8_t>(std::clamp(value, low, 127)); }

}  // namespace

int Pipeline::port_use(std::size_t block, int cycle) const {
  return cycle < 0 ? ports_[block].in(cycle) : 0;  // no resource on the chip is reserved at T or later
}

// Fetches have the lowest priority and are in program order: they fit around the data accesses, and nothing has to fit
// around them.
int Pipeline::place_fetch(const Access& fetch, int from) const {
  int cycle = from;
  if (in_block(fetch.resource)) {
    while (port_use(block_of(fetch.resource), cycle) >= timing::block_ports) ++cycle;
  } else if (on_bus(fetch.resource)) {
    const CycleSet& busy = buses_[bus_of(fetch.resource)].busy;
    for (int last = cycle + fetch.waits; last >= cycle; --last)
      if (busy.has(last)) {
        cycle = last + 1;
        last = cycle + fetch.waits + 1;
      }
  }
  return cycle;
}

int Pipeline::decode_at(const Footprint& footprint, int from) const {
  int at = from;
  each_register(footprint.address_uses & waited_for_, [&](std::size_t i) { at = std::max(at, int{ready_[i]}); });
  return at;
}

/// The stages and accesses of one instruction, phase by phase, relative to the old T.
struct Pipeline::Placed {
  struct Taken {
    std::size_t bus;
    int from, to;
  };
  int first_fetch = 0, fetch = 0, fetch_cycles = 1;  ///< first_...: without conflicts
  int undelayed = 0, decode = 0;                     ///< without and with stalls of address registers
  int first_read = 0, read = 0, read_cycles = 1;     ///< without and with conflicts
  int waits = 0;                                     ///< wait states in read_cycles
  int first_execute = 0, execute = 0;                ///< without and with conflicts
  int next = 0;                                      ///< the new T
  std::array<int, block_count> block_reads{}, block_writes{};
  std::array<bool, bus_count> bus_reads{}, last_strobe1{};
  std::array<int, bus_count> read_end{}, bus_free{}, write_end{};
  std::array<Taken, bus_count + 2> taken{};  ///< cycles of the buses
  std::size_t taken_count = 0;
};

StepTiming Pipeline::advance(const Demand& demand) {
  StepTiming out;
  Placed at;
  at.first_fetch = at.fetch = fetch_ready_;
  if (demand.fetched) {
    at.fetch = place_fetch(demand.fetch, at.first_fetch);
    at.fetch_cycles = 1 + demand.fetch.waits;
  }
  at.undelayed = std::max(at.fetch + at.fetch_cycles, int{read_entered_});
  at.decode = decode_at(demand.footprint, at.undelayed);
  at.first_read = std::max(at.decode + 1, -1);
  place_reads(demand, at, out);
  place_writes(demand, at, out);
  at.next = std::max(at.execute + 1, demand.flush_cost != 0 ? at.execute + demand.flush_cost : 0);
  out.total = at.next;
  charge(demand, at, out);
  const auto stage = [](int cycle) { return static_cast<std::int16_t>(cycle); };
  out.stages = {stage(at.fetch), stage(demand.fetched ? at.fetch_cycles : 0), stage(at.decode),
                stage(first_read(demand, out).value_or(at.read)), stage(at.execute)};
  move_on(demand, at);
  return out;
}

// The first cycle in which all reads fit.
void Pipeline::place_reads(const Demand& demand, Placed& at, StepTiming& out) const {
  int a = at.first_read;
  for (std::size_t i = 0; i < demand.count; ++i) {
    const Access& access = demand.data[i];
    if (access.write) continue;
    if (in_block(access.resource)) ++at.block_reads[block_of(access.resource)];
    if (on_bus(access.resource)) {
      const std::size_t b = bus_of(access.resource);
      const Bus& bus = buses_[b];
      a = std::max(a, int{bus.free});
      at.bus_reads[b] = true;
    } else {
      at.read_cycles = std::max(at.read_cycles, 1 + access.waits);
      at.waits = std::max(at.waits, int{access.waits});
    }
  }
  for (std::size_t block = 0; block < block_count; ++block)
    while (at.block_reads[block] != 0 && port_use(block, a) + at.block_reads[block] > timing::block_ports) {
      ++a;
      block = 0;
    }
  at.read = a;
  at.read_end = {a, a, a};
  for (std::size_t i = 0; i < demand.count; ++i)
    if (!demand.data[i].write) out.start[i] = on_bus(demand.data[i].resource) ? place_on_bus(demand.data[i], at) : a;
}

// The start of a read. The cycle that a bus needs between two accesses makes the read longer; reads of other buses
// begin before it.
int Pipeline::place_on_bus(const Access& read, Placed& at) const {
  const std::size_t b = bus_of(read.resource);
  const Bus& bus = buses_[b];
  int& next = at.read_end[b];
  const bool second = next != at.read;
  const bool follows = second || next == bus.read_end;
  const bool strobe1_before = second ? at.last_strobe1[b] : bus.read_strobe1;
  if (next < bus.write_end + read_after_write(b))
    next = bus.write_end + read_after_write(b);
  else if (follows && read.strobe1 != strobe1_before)
    next += timing::strobe_switch_cycles;
  const int start = next;
  next += 1 + read.waits;
  at.last_strobe1[b] = read.strobe1;
  if (next - at.read >= at.read_cycles) {
    at.read_cycles = next - at.read;
    at.waits = std::max(at.waits, int{read.waits});
  }
  return start;
}

// Execute moves until all writes fit; only one write waits for a bus.
void Pipeline::place_writes(const Demand& demand, Placed& at, StepTiming& out) const {
  at.first_execute = at.read + at.read_cycles;
  int e = at.first_execute;
  for (std::size_t b = 0; b < bus_count; ++b) {
    at.bus_free[b] = at.bus_reads[b] ? at.read_end[b] : buses_[b].free;
    at.write_end[b] = buses_[b].write_end;
    if (at.bus_reads[b]) at.taken[at.taken_count++] = {b, at.read, at.read_end[b]};
  }
  for (std::size_t i = 0; i < demand.count; ++i) {
    const Access& access = demand.data[i];
    if (!access.write) continue;
    if (on_bus(access.resource)) {
      const std::size_t b = bus_of(access.resource);
      e = std::max(e, at.bus_free[b]);
      out.start[i] = e;
      at.bus_free[b] = at.write_end[b] = e + write_cycles(b) + access.waits;
      at.taken[at.taken_count++] = {b, e, at.write_end[b] + read_after_write(b)};
    } else {
      if (in_block(access.resource)) ++at.block_writes[block_of(access.resource)];
      out.start[i] = e;
    }
  }
  at.execute = e;
}

// From the last stage back: a delay in a later stage hides one in an earlier stage.
void Pipeline::charge(const Demand& demand, const Placed& at, StepTiming& out) {
  const auto book = [&out](Cause cause, int cycles) {
    auto& booked = out.causes[static_cast<std::size_t>(cause)];
    booked = static_cast<std::int16_t>(booked + cycles);
  };
  int rest = at.execute;
  const auto delayed = [&](Cause cause, int cycles) {
    const int share = std::min(rest, std::max(cycles, 0));
    book(cause, share);
    rest -= share;
  };
  delayed(Cause::memory_conflict, at.execute - at.first_execute);
  delayed(Cause::wait_state, at.waits);
  delayed(Cause::memory_conflict, at.read_cycles - 1 - at.waits + (at.read - at.first_read));
  delayed(Cause::register_conflict, at.decode - at.undelayed);
  if (demand.fetch_missed)
    delayed(Cause::cache_miss, at.fetch_cycles - 1 + (at.fetch - at.first_fetch));
  else
    delayed(Cause::wait_state, at.fetch_cycles - 1);
  delayed(Cause::memory_conflict, rest);
  book(Cause::branch, at.next - (at.execute + 1));
  book(Cause::execute, 1);
}

/// From when on the instruction after this one can use the address registers, relative to the new T.
void Pipeline::move_readiness(const Footprint& footprint, const Placed& at) {
  const int decoded = std::max(fetch_ready_ + 1, int{read_entered_});  // not before, whatever it waits for
  const auto before = std::exchange(ready_, {});
  const std::uint32_t waited_before = std::exchange(waited_for_, 0);
  const auto set = [&](std::size_t i, int when) {
    if (when - at.next <= decoded) return;
    const std::uint32_t bit = 1u << (i + first_address_register);
    const auto ready = static_cast<std::int8_t>(when - at.next);
    ready_[i] = (waited_for_ & bit) != 0 ? std::max(ready_[i], ready) : ready;
    waited_for_ |= bit;
  };
  each_register(waited_before, [&](std::size_t i) { set(i, before[i]); });
  each_register(footprint.operand_reads, [&](std::size_t i) { set(i, at.decode + 2); });
  each_register(footprint.early_writes, [&](std::size_t i) { set(i, at.read + at.read_cycles); });
  each_register(footprint.late_writes, [&](std::size_t i) { set(i, at.execute + 1); });
}

// Makes all times relative to the new T.
void Pipeline::move_on(const Demand& demand, const Placed& at) {
  const int t = at.next;
  settle(t, std::max(at.fetch + 1, at.decode), at.first_read);
  if (demand.flush_cost != 0) fetch_ready_ = -3, read_entered_ = -2;
  move_readiness(demand.footprint, at);
  for (std::size_t b = 0; b < block_count; ++b) {
    if (at.block_reads[b] != 0) ports_[b].add(at.read - t, at.block_reads[b]);
    if (at.block_writes[b] != 0) ports_[b].add(at.execute - t, at.block_writes[b]);
  }
  for (std::size_t i = 0; i < at.taken_count; ++i)
    for (int cycle = at.taken[i].from; cycle < at.taken[i].to; ++cycle) buses_[at.taken[i].bus].busy.put(cycle - t);
  for (std::size_t b = 0; b < bus_count; ++b) {
    Bus& bus = buses_[b];
    bus.free = clamp8(at.bus_free[b] - t, -1);
    bus.write_end = clamp8(at.write_end[b] - t, -2);
    bus.read_end = clamp8((at.bus_reads[b] ? at.read_end[b] : bus.read_end) - t, -2);
    if (at.bus_reads[b]) bus.read_strobe1 = at.last_strobe1[b];
    if (bus.read_end == -2) bus.read_strobe1 = false;  // too long ago to matter
  }
  forget_before(fetch_ready_);
}

void Pipeline::Ports::add(int cycle, int accesses) {
  const auto sum = static_cast<unsigned>(std::clamp(in(cycle) + accesses, 0, 3));
  bits[0].put(cycle, (sum & 1) != 0);
  bits[1].put(cycle, (sum & 2) != 0);
}

// Cycles before the next fetch do not matter any more.
void Pipeline::forget_before(int cycle) {
  for (Ports& ports : ports_)
    for (CycleSet& bits : ports.bits) bits.forget_before(cycle);
  for (Bus& bus : buses_) bus.busy.forget_before(cycle);
}

void Pipeline::settle(int shift, int fetch_ready, int read_entered) {
  for (Ports& ports : ports_)
    for (CycleSet& bits : ports.bits) bits.advance(shift);
  for (Bus& bus : buses_) bus.busy.advance(shift);
  fetch_ready_ = static_cast<std::int8_t>(std::clamp(fetch_ready - shift, -depth, -3));
  read_entered_ = static_cast<std::int8_t>(std::clamp(read_entered - shift, -depth, -2));
}

void Pipeline::flush(int cycles) {
  for (auto& bus : buses_) {
    bus.free = clamp8(bus.free - cycles, -1);
    bus.write_end = clamp8(bus.write_end - cycles, -2);
    bus.read_end = clamp8(bus.read_end - cycles, -2);
    bus.read_strobe1 &= bus.read_end != -2;
  }
  settle(cycles, -3 + cycles, -2 + cycles);
  waited_for_ = 0;
  ready_ = {};
  forget_before(fetch_ready_);
}

void Pipeline::mark(Resource resource, int from, int to, int change) {
  for (int cycle = std::max(from, int{fetch_ready_}); cycle < std::min(to, furthest); ++cycle) {
    if (in_block(resource)) ports_[block_of(resource)].add(cycle, change);
    if (on_bus(resource)) buses_[bus_of(resource)].busy.put(cycle, change > 0);
  }
}

void Pipeline::take(Resource resource, int from, int to) {
  mark(resource, from, to, 1);
  if (!on_bus(resource)) return;
  Bus& bus = buses_[bus_of(resource)];
  bus.free = clamp8(std::max(int{bus.free}, to), -1);
}

void Pipeline::give_back(Resource resource, int from, int to) { mark(resource, from, to, -1); }

void Pipeline::make_again(const Access& access, int from, int to) {
  mark(access.resource, from, to, 1);
  if (!on_bus(access.resource)) return;
  const std::size_t b = bus_of(access.resource);
  Bus& bus = buses_[b];
  bus.free = clamp8(std::max(int{bus.free}, to), -1);
  std::int8_t& end = access.write ? bus.write_end : bus.read_end;
  end = clamp8(std::max(int{end}, to), -2);
  if (access.write) mark(access.resource, to, to + read_after_write(b), 1);
}

void Pipeline::hold(int cycles) {
  settle(cycles, fetch_ready_, read_entered_);
  each_register(waited_for_, [&](std::size_t i) {
    if (ready_[i] < -1) ready_[i] = clamp8(ready_[i] - cycles, -depth);
  });
  for (auto& bus : buses_) {
    bus.free = clamp8(bus.free - cycles, -1);
    bus.write_end = clamp8(bus.write_end - cycles, -2);
    bus.read_end = clamp8(bus.read_end - cycles, -2);
    bus.read_strobe1 &= bus.read_end != -2;
  }
}

std::array<Pipeline::Interval, 2> Pipeline::expected_fetches(
    const std::array<std::optional<Access>, 2>& fetches) const {
  std::array<Interval, 2> expected{};
  int earliest = fetch_ready_, entered = read_entered_;
  for (std::size_t i = 0; i < 2; ++i) {
    int length = 1;
    if (fetches[i]) {
      earliest = place_fetch(*fetches[i], earliest);
      length = 1 + fetches[i]->waits;
      expected[i] = {earliest, earliest + length};
    }
    const int decoded = std::max(earliest + length, entered);
    earliest = std::max(earliest + 1, decoded);
    entered = std::max(decoded + 1, -1);
  }
  return expected;
}

std::optional<int> Pipeline::busy_until(Resource resource) const {
  if (!on_bus(resource) || buses_[bus_of(resource)].free <= -1) return std::nullopt;
  return buses_[bus_of(resource)].free;
}

std::uint64_t Pipeline::hash() const {
  std::uint64_t h = 0x9E3779B97F4A7C15u;
  const auto mix = [&h](std::uint64_t v) {
    h ^= v;
    h *= 0xFF51AFD7ED558CCDu;
    h ^= h >> 32;
  };
  const auto byte = [](std::int8_t value, int place) {
    return std::uint64_t{static_cast<std::uint8_t>(value)} << 8 * place;
  };
  mix(byte(fetch_ready_, 0) | byte(read_entered_, 1) | std::uint64_t{waited_for_} << 16);
  each_register(waited_for_, [&](std::size_t i) { mix(byte(ready_[i], 0)); });
  std::uint64_t set = 0;
  const auto mix_cycles = [&](const CycleSet& cycles) {
    ++set;
    if (cycles.empty()) return;
    mix(set);
    for (const std::uint64_t word : cycles.words) mix(word);
  };
  for (const Ports& ports : ports_)
    for (const CycleSet& bits : ports.bits) mix_cycles(bits);
  for (const Bus& bus : buses_) {
    mix_cycles(bus.busy);
    mix(byte(bus.free, 0) | byte(bus.write_end, 1) | byte(bus.read_end, 2) | std::uint64_t{bus.read_strobe1} << 24);
  }
  return h;
}

}  // namespace c40
