#include "machine/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "bus_model/bus.hpp"
#include "machine/devices.hpp"
#include "machine/dsp.hpp"
#include "machine/host.hpp"
#include "machine/shared_memory.hpp"
#include "machine/symbols.hpp"
#include "plant/dock.hpp"
#include "toolchain/image.hpp"

namespace machine {

namespace {

struct Numbered {
  std::string_view what;
  unsigned count;
};

Numbered numbered(Action action, unsigned slots) {
  switch (action) {
    case Action::fail:
    case Action::hang:
    case Action::unplug:
    case Action::plug:
    case Action::reset:
    case Action::pace: return {"slot", slots};
    case Action::pause_host: return {"host", 1};
    case Action::stall_bus: return {"bus", 2};
    case Action::drive:
    case Action::encoder: return {"joint", 5};
    case Action::sway: return {"axis", 2};
  }
  return {"event", 0};
}

void require_sense(const ScriptedEvent& event, Time now, unsigned slots) {
  const auto [what, count] = numbered(event.action, slots);
  if (event.number >= count || event.time < now)
    throw std::invalid_argument{fmt::format("machine: a scripted event at {} ps for {} {}; the time is {} ps, and the last {} is {}",
                                            event.time.count(), what, event.number, now.count(), what, count - 1)};
  if (event.amount < 0 || (event.action == Action::pace && event.amount == 0))
    throw std::invalid_argument{fmt::format("machine: a scripted event with amount {}; it is not negative, and a clock runs", event.amount)};
}

Config checked(Config config) {
  if (config.slots == 0) config.slots = config.dsps;
  if (config.slots > most_slots || config.dsps > config.slots)
    throw std::invalid_argument{
        fmt::format("machine: {} DSPs in {} slots; there are at most {} slots and no more DSPs than slots", config.dsps,
                    config.slots, most_slots)};
  if (config.interrupt_clocks < 1 || config.interrupt_clocks > 3)
    throw std::invalid_argument{"machine: interrupt_clocks is 1 to 3"};
  if (config.prefetch_hit_cycles < 0) throw std::invalid_argument{"machine: prefetch_hit_cycles is at least 0"};
  for (const ScriptedEvent& event : config.script) require_sense(event, Time{0}, config.slots);
  std::stable_sort(config.script.begin(), config.script.end(),
                   [](const ScriptedEvent& a, const ScriptedEvent& b) { return a.time < b.time; });
  return config;
}

// Bus A's master 0 when there is no host.
struct Nobody final : pci::Initiator {
  void completed(const pci::Transaction&, std::span<const Word>) override {}
};

// xorshift64*: only for the order in which chips are run ahead.
class Shuffle {
 public:
  explicit Shuffle(std::uint64_t seed) : state_{seed} {}
  bool active() const { return state_ != 0; }
  std::uint64_t below(std::uint64_t bound) {
    state_ ^= state_ >> 12, state_ ^= state_ << 25, state_ ^= state_ >> 27;
    return (state_ * 0x2545F4914F6CDD1Du >> 11) % bound;
  }

 private:
  std::uint64_t state_;
};

}  // namespace

class Machine::Parts final : public DoorbellClient {
 public:
  Parts(Config given, const toolchain::Image& image, plant::Dock* the_dock, HostProgram* program);

  void run_until(Time limit);
  void act(const ScriptedEvent& event, Time now);
  void observe(Observer* observer);

  void ring(unsigned slot, pci::Clocks clock) override {
    dsps.at(slot).schedule_edge(bus_clock.at(clock + config.interrupt_clocks));
  }
  void reset_slot(unsigned slot, pci::Clocks clock) override {
    dsps.at(slot).schedule_reset(bus_clock.at(clock + config.interrupt_clocks));
  }
  void semaphore_event(unsigned number, SemaphoreEvent event, unsigned owner, pci::Clocks clock) override {
    if (around->observer != nullptr) around->observer->semaphore(number, event, owner, bus_clock.at(clock));
  }

  struct Watch final : pci::Monitor {
    Watch(Parts& owner, BusId which) : parts{owner}, bus{which} {}
    void ended(const pci::Transaction& transaction) override {
      parts.around->observer->transaction(bus, transaction, parts.bus_clock.at(transaction.ended));
    }
    Parts& parts;
    BusId bus;
  };

  Nobody nobody;
  Config config;
  toolchain::Image program;
  Symbols symbols;
  plant::Dock* dock;
  Clock bus_clock;
  pci::Bus bus_a;
  pci::Bus bus_b;
  Fence fence;
  SharedSram sram;
  SharedRegisters registers;
  std::optional<Devices> devices;
  std::optional<Host> host;
  std::optional<Surroundings> around;
  std::deque<Dsp> dsps;
  std::size_t next_scripted = 0;
  Time time{0};
  Watch watch_a{*this, BusId::a};
  Watch watch_b{*this, BusId::b};

 private:
  // What can happen next, in the order of ties: host, bus A, bus B, script, DSPs, plant.
  static constexpr unsigned first_dsp = 4;
  struct Turn {
    Time time;
    unsigned who;
  };

  Turn earliest(Time limit) const;
  void take(Turn turn, Time limit);
  Time horizon(Time limit) const;
  void run_some_ahead(Time limit);
  Time bus_time(const pci::Bus& bus) const {
    return bus.next_event() == pci::never ? never : bus_clock.at(bus.next_event());
  }
  Time script_time() const { return next_scripted < config.script.size() ? config.script[next_scripted].time : never; }

  Shuffle shuffle_{config.turn_order};
};

Machine::Parts::Parts(Config given, const toolchain::Image& image, plant::Dock* the_dock, HostProgram* the_program)
    : config{checked(std::move(given))},
      program{image},
      symbols{program},
      dock{the_dock},
      bus_clock{config.pci_hz_numerator, config.pci_hz_denominator},
      bus_a{config.bus_a},
      bus_b{config.bus_b},
      sram{fence},
      registers{symbols, config.slots, bus_clock, fence, *this} {
  pci::TargetConfig board = config.shared_memory;
  board.name = "shared memory";
  bus_a.add_target(board, sram, 0, SharedSram::size);
  board.name = "shared registers";
  board.max_burst = 1;
  bus_a.add_target(board, registers, SharedRegisters::base, SharedRegisters::size);
  if (dock != nullptr) {
    devices.emplace(symbols, *dock, bus_clock, fence);
    pci::TargetConfig cards = config.devices;
    cards.name = "devices";
    bus_b.add_target(cards, *devices, 0, devices->size());
  }
  if (the_program != nullptr)
    host.emplace(*the_program, config, bus_a, bus_clock, registers);
  else
    bus_a.add_master(config.host_master, nobody);
  around.emplace(Surroundings{.config = config,
                              .symbols = symbols,
                              .program = program,
                              .chip_clock = Clock{config.chip_hz},
                              .bus_clock = bus_clock,
                              .bus_a = bus_a,
                              .bus_b = bus_b,
                              .registers = registers,
                              .devices = devices ? &*devices : nullptr,
                              .fence = fence,
                              .observer = nullptr,
                              .faults = {}});
  for (unsigned slot = 0; slot < config.slots; ++slot) dsps.emplace_back(slot, slot < config.dsps, *around);
}

void Machine::Parts::observe(Observer* observer) {
  around->observer = observer;
  bus_a.set_monitor(observer == nullptr ? nullptr : &watch_a);
  bus_b.set_monitor(observer == nullptr ? nullptr : &watch_b);
}

Machine::Parts::Turn Machine::Parts::earliest(Time limit) const {
  Turn best{limit, ~0u};
  const auto offer = [&](Time when, unsigned who) {
    if (when < best.time) best = {when, who};
  };
  if (host) offer(host->next(), 0);
  offer(bus_time(bus_a), 1);
  offer(bus_time(bus_b), 2);
  offer(script_time(), 3);
  unsigned who = first_dsp;
  for (const Dsp& dsp : dsps) offer(dsp.next(), who++);
  if (dock != nullptr) offer(dock->next_event(), who);
  return best;
}

// Until then nothing that is not yet scheduled at a DSP can act on it: rings and resets come from the host, failures
// from the script.
Time Machine::Parts::horizon(Time limit) const {
  const Time planned = std::min(limit, script_time());
  return host ? std::min(planned, host->earliest_action()) : planned;
}

void Machine::Parts::take(Turn turn, Time limit) {
  switch (turn.who) {
    case 0: return host->process(turn.time);
    case 1: return bus_a.step();
    case 2: return bus_b.step();
    case 3: {
      const ScriptedEvent event = config.script[next_scripted++];
      return act(event, turn.time);
    }
    default: break;
  }
  if (turn.who < first_dsp + dsps.size())
    dsps[turn.who - first_dsp].process(turn.time, horizon(limit));
  else
    dock->advance_to(turn.time);
}

// Lets some chips do in advance what is theirs alone, in any order and to any point. It must not matter (rulings.md 3),
// and tests see to it.
void Machine::Parts::run_some_ahead(Time limit) {
  const Time far = horizon(limit);
  for (std::size_t i = 0; i < dsps.size(); ++i) {
    Dsp& dsp = dsps[shuffle_.below(dsps.size())];
    if (!dsp.running() || dsp.next() >= far) continue;
    const auto span = static_cast<std::uint64_t>((far - dsp.next()).count());
    dsp.run_ahead(dsp.next() + Time{1 + static_cast<std::int64_t>(shuffle_.below(span))});
  }
}

void Machine::Parts::run_until(Time limit) {
  for (Turn turn = earliest(limit); turn.time < limit; turn = earliest(limit)) {
    if (shuffle_.active()) {
      run_some_ahead(limit);
      turn = earliest(limit);
    }
    time = turn.time;
    take(turn, limit);
  }
  time = std::max(time, limit);
  for (Dsp& dsp : dsps) dsp.settle(time);
}

void Machine::Parts::act(const ScriptedEvent& event, Time now) {
  const auto dsp = [&]() -> Dsp& { return dsps.at(event.number); };
  const auto clocks = [&](Time at) { return bus_clock.tick_at_or_after(at); };
  const bool failed = event.amount != 0;
  const auto index = static_cast<int>(event.number);
  if (around->observer != nullptr) around->observer->scripted(event, now);
  switch (event.action) {
    case Action::fail: return dsp().fail(now);
    case Action::hang: return dsp().hang(now);
    case Action::unplug: registers.clear_idle(event.number); return dsp().unplug(now);
    case Action::plug: fence.mask |= Word{1} << event.number; return dsp().plug(now);
    case Action::reset: registers.clear_idle(event.number); return dsp().reset(now);
    case Action::pace: return dsp().pace(now, event.amount);
    case Action::pause_host:
      if (host) host->pause(now + Time{event.amount});
      return;
    case Action::stall_bus: return (event.number == 0 ? bus_a : bus_b).stall(clocks(now), clocks(now + Time{event.amount}));
    case Action::drive:
      if (dock != nullptr) dock->fail_drive(index, failed, now);
      return;
    case Action::encoder:
      if (dock != nullptr) dock->fail_encoder(index, failed, now);
      return;
    case Action::sway:
      if (dock != nullptr) dock->fail_sway(index, failed, now);
      return;
  }
}

Machine::Machine(Config config, const toolchain::Image& program, plant::Dock* dock, HostProgram* host)
    : parts_{std::make_unique<Parts>(std::move(config), program, dock, host)} {}
Machine::~Machine() = default;

void Machine::run_until(Time limit) { parts_->run_until(limit); }
Time Machine::time() const { return parts_->time; }
const Config& Machine::config() const { return parts_->config; }
void Machine::set_observer(Observer* observer) { parts_->observe(observer); }
void Machine::act(const ScriptedEvent& event) {
  require_sense({.time = parts_->time, .action = event.action, .number = event.number, .amount = event.amount}, parts_->time, slots());
  parts_->act(event, parts_->time);
}

void Machine::script(const ScriptedEvent& event) {
  require_sense(event, parts_->time, slots());
  auto& script = parts_->config.script;
  const auto from = script.begin() + static_cast<std::ptrdiff_t>(parts_->next_scripted);
  script.insert(std::upper_bound(from, script.end(), event,
                                 [](const ScriptedEvent& a, const ScriptedEvent& b) { return a.time < b.time; }),
                event);
}

unsigned Machine::slots() const { return parts_->config.slots; }
bool Machine::plugged(unsigned slot) const { return parts_->dsps.at(slot).plugged(); }
bool Machine::standing(unsigned slot) const { return parts_->dsps.at(slot).standing(); }
c40::Chip& Machine::chip(unsigned slot) { return parts_->dsps.at(slot).chip(); }
const c40::Chip& Machine::chip(unsigned slot) const { return parts_->dsps.at(slot).chip(); }
const Clock& Machine::chip_clock() const { return parts_->around->chip_clock; }
const pci::Bus& Machine::bus(BusId id) const { return id == BusId::a ? parts_->bus_a : parts_->bus_b; }
pci::BusStatistics Machine::bus_statistics(BusId id) const {
  return bus(id).statistics(std::max(bus(id).now(), parts_->bus_clock.tick_at_or_before(parts_->time)));
}
const std::vector<ChipFault>& Machine::faults() const { return parts_->around->faults; }
const SlotStatistics& Machine::statistics(unsigned slot) const { return parts_->dsps.at(slot).statistics(); }
Word Machine::peek(Offset offset) const { return parts_->sram.words().at(offset); }
void Machine::poke(Offset offset, Word word) { parts_->sram.words().at(offset) = word; }
Word Machine::symbol(std::string_view name) const { return parts_->program.symbol(name); }

void Machine::append_state(std::vector<std::uint64_t>& words) const {
  words.push_back(static_cast<std::uint64_t>(parts_->time.count()));
  words.insert(words.end(), parts_->sram.words().begin(), parts_->sram.words().end());
  parts_->registers.append_state(words);
  if (parts_->devices) parts_->devices->append_state(words);
  for (const Dsp& dsp : parts_->dsps) dsp.append_state(words);
}

}  // namespace machine
