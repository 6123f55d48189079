#include "machine/system/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "bus_model/audit.hpp"
#include "bus_model/bus.hpp"
#include "bus_model/bus_bridge.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/bus_agents/devices.hpp"
#include "machine/bus_agents/guard.hpp"
#include "machine/bus_agents/host_board.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/chips/boot.hpp"
#include "machine/dsps/dsp.hpp"
#include "machine/dsps/link_adapter.hpp"
#include "machine/dsps/slot_links.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/host_program.hpp"
#include "machine/system/machine_config.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/script.hpp"
#include "machine/system/scripted_events.hpp"
#include "machine/system/symbols.hpp"
#include "machine/time/scheduler.hpp"
#include "plant/dock/dock.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

namespace {

// Master 0 of the host's buses if there is no host.
struct SilentInitiator final : pci::Initiator {
  unsigned framed(const pci::Attempt& attempt, bool, pci::Clocks, std::span<Word>) override { return attempt.wanted; }
  void completed(const pci::Transaction&, std::span<const Word>) override {}
};

// An address range of a target on a bus.
struct Region {
  std::string name;
  unsigned bus;
  pci::Address base;
  Offset words;
};

}  // namespace

class Machine::Parts final : public DoorbellClient, public LinkAdapter::Client, public pci::BusBridge::Client {
  // Buses and plant are passive: these actors let them take part.
  struct BusTurn final : Scheduler::Actor, pci::PlanListener {
    BusTurn(pci::Bus& its_bus, const Clock& its_clock) : bus{its_bus}, clock{its_clock} { bus.set_plan_listener(this); }
    Time next() const override {
      const pci::Clocks event = bus.next_event();
      return event == pci::never ? never : clock.at(event);
    }
    void act(Time) override { bus.step(); }
    void replanned() override { changed(); }
    pci::Bus& bus;
    const Clock& clock;
  };
  struct PlantTurn final : Scheduler::Actor {
    explicit PlantTurn(plant::Dock* the_dock) : dock{the_dock} {}
    Time next() const override { return dock == nullptr ? never : dock->next_event(); }
    // A board that is reset or pulled out breaks off its access at the next bus clock. If that is an access to the
    // plant, the plant is there already, a few nanoseconds later than its turn.
    void act(Time now) override {
      if (dock->time() < now) dock->advance_to(now);
    }
    plant::Dock* dock;
  };

 public:
  Parts(Config given, const toolchain::Image& image, plant::Dock* the_dock, HostProgram* program);

  void run_until(Time limit);
  void act(const ScriptedEvent& event, Time now);
  void observe(Observer* observer);
  /// The bus's statistics are of the clocks before this one.
  pci::Clocks counted_until(BusId id) const {
    const auto bus = static_cast<std::size_t>(id);
    return std::max(buses[bus].now(), bus_clocks[bus].tick_at_or_before(time));
  }

  void ring(unsigned slot, pci::Clocks clock) override {
    dsps.at(slot).schedule_edge(memory_clock().at(clock + config.interrupt_clocks));
  }
  void reset_slot(unsigned slot, pci::Clocks clock) override {
    dsps.at(slot).schedule_reset(memory_clock().at(clock + config.interrupt_clocks));
  }
  void link_changed(unsigned slot) override { dsps.at(slot).adapter_wire().changed(); }
  void link_event(unsigned slot, const c40::LinkEvent& event) override { dsps.at(slot).link_event(event); }
  void boot_requested(Time now) override {
    if (host) host->boot_requested(now);
  }
  void semaphore_event(unsigned number, SemaphoreEvent event, unsigned owner, pci::Clocks clock) override {
    if (around->observer != nullptr) around->observer->semaphore(number, event, owner, memory_clock().at(clock));
  }

  struct Watch final : pci::Monitor {
    Watch(Parts& owner, BusId which)
        : bus{which},
          clock{owner.bus_clocks[static_cast<std::size_t>(which)]},
          observer{*owner.around->observer},
          bus_watch{owner.bus_watch} {}
    void attempted(const pci::Attempt& attempt) override { bus_watch(bus, attempt, clock); }
    void ended(const pci::Transaction& transaction) override {
      observer.transaction(bus, transaction, clock.at(transaction.ended));
    }
    BusId bus;
    const Clock& clock;
    Observer& observer;
    const BusWatch& bus_watch;
  };

  SilentInitiator nobody;
  Config config;
  toolchain::Image program;
  Symbols symbols;
  plant::Dock* dock;
  std::vector<Clock> bus_clocks;  // by bus
  std::deque<pci::Bus> buses;
  Fence fence;
  SharedSram sram;
  std::optional<Guard> guard;
  SharedRegisters registers;
  LinkAdapter adapter;
  std::optional<Devices> devices;
  std::deque<DeviceWindow> device_windows;
  std::vector<Region> regions;
  std::optional<HostBoard> host;
  std::optional<DspContext> around;
  std::deque<Dsp> dsps;
  std::deque<pci::BusBridge> bridges;
  std::deque<SlotWire> wires;  // between slots
  std::deque<Net> nets;        // between their pins
  std::deque<BusTurn> bus_turns;
  Script script{config.script, [this](const ScriptedEvent& event, Time now) { act(event, now); }};
  PlantTurn plant_turn;
  Scheduler scheduler;
  Time time{0};
  std::deque<Watch> watches;
  BusWatch bus_watch;

 private:
  void build_targets();
  std::vector<BusRoute> routes(const std::vector<unsigned>& standing, Window window, Offset at) const;
  void build_bridges();
  void delivered(const pci::Bus& far, unsigned agent, pci::Address address, Word value, pci::Clocks clock,
                 pci::Result result) override;

  Time earliest_action() const;
  void slot_changed(unsigned slot, Time now);
  const Clock& memory_clock() const { return bus_clocks[config.topology.shared_memory]; }
};

Machine::Parts::Parts(Config given, const toolchain::Image& image, plant::Dock* the_dock, HostProgram* the_program)
    : config{checked(std::move(given))},
      program{image},
      symbols{program},
      dock{the_dock},
      bus_clocks{clocks_of_buses(config)},
      sram{fence},
      registers{symbols, config.slots, memory_clock(), fence, *this},
      adapter{symbols, config.slots, memory_clock(), Clock{config.chip_hz, config.chip_hz_denominator}, *this},
      plant_turn{the_dock},
      scheduler{config.turn_order} {
  require_dsp_board(config.board, program, symbols);
  if (config.boot == Boot::link) config.board = with_boot_from_port(config.board);
  for (const std::string& name : config.topology.buses) {
    pci::BusConfig bus = config.bus;
    bus.name = name;
    bus.host_bridge = std::ranges::find(config.topology.host, buses.size()) != config.topology.host.end();
    buses.emplace_back(bus);
  }
  build_targets();
  if (the_program != nullptr) {
    std::vector<BusRoute> host_ways = routes(config.topology.host, Window::a, 0);
    for (const BusRoute& route : routes(config.topology.host, Window::b, host_devices)) host_ways.push_back(route);
    host.emplace(*the_program, config, buses, host_ways, bus_clocks, registers, adapter);
  } else {
    for (const unsigned bus : config.topology.host) buses[bus].add_master(config.host_master, nobody);
  }
  around.emplace(DspContext{.config = config,
                            .symbols = symbols,
                            .program = program,
                            .chip_clock = Clock{config.chip_hz, config.chip_hz_denominator},
                            .chip_clocks = clocks_of_chips(config),
                            .bus_clocks = bus_clocks,
                            .buses = buses,
                            .bridges = bridges,
                            .window_a = routes(config.topology.dsps, Window::a, 0),
                            .window_b = routes(config.topology.dsps, Window::b, 0),
                            .registers = registers,
                            .adapter = adapter,
                            .devices = devices ? &*devices : nullptr,
                            .fence = fence,
                            .guard = guard ? &*guard : nullptr,
                            .observer = nullptr,
                            .faults = {},
                            .earliest_action = [this] { return earliest_action(); },
                            .slot_changed = [this](unsigned slot, Time now) { slot_changed(slot, now); },
                            .scheduler = scheduler});
  for (unsigned slot = 0; slot < config.slots; ++slot) dsps.emplace_back(slot, slot < config.dsps, *around);
  build_bridges();
  for (const SlotLink& link : config.links) wires.emplace_back(link, dsps[link.a.slot], dsps[link.b.slot]);
  std::vector<PinOwner*> owners;
  for (Dsp& dsp : dsps) owners.push_back(&dsp);
  for (const NetDescription& net : config.nets) {
    Net& joined = nets.emplace_back(net, owners);
    for (Dsp& dsp : dsps) dsp.join(joined);
  }
  if (host) scheduler.add(*host);
  for (std::size_t bus = 0; bus < buses.size(); ++bus)
    scheduler.add(bus_turns.emplace_back(buses[bus], bus_clocks[bus]));
  scheduler.add(script);
  for (Dsp& dsp : dsps) scheduler.add(dsp.adapter_wire());
  for (SlotWire& wire : wires) scheduler.add(wire);
  for (Net& net : nets) scheduler.add(net);
  for (Dsp& dsp : dsps) scheduler.add(dsp);
  scheduler.add(plant_turn);
  for (Net& net : nets) net.start();
}

// Before this instant no unscheduled event can act on a DSP: doorbells and resets come from the host, which a DSP that
// leaves reset may wake, and failures come from the script.
Time Machine::Parts::earliest_action() const {
  const Time planned = std::min(scheduler.limit(), script.next());
  if (!host) return planned;
  Time woken = never;
  if (around->in_reset > 0)
    for (const Dsp& dsp : dsps)
      if (dsp.in_reset()) woken = std::min(woken, dsp.next());
  return std::min(planned, host->earliest_action(woken));
}

void Machine::Parts::slot_changed(unsigned slot, Time now) {
  for (SlotWire& wire : wires)
    if (wire.ends().a.slot == slot || wire.ends().b.slot == slot) wire.slots_changed(now);
}

void Machine::Parts::build_targets() {
  if (config.guard) {
    guard.emplace(program, sram.words());
    sram.set_guard(*guard, registers);
  }
  const Topology& topology = config.topology;
  const auto add = [&](pci::TargetConfig target, const char* name, unsigned bus, pci::Target& what, pci::Address base,
                       Offset words) {
    target.name = name;
    buses[bus].add_target(target, what, base, words);
    regions.push_back({name, bus, base, words});
  };
  add(config.shared_memory, "shared memory", topology.shared_memory, sram, 0, SharedSram::size);
  pci::TargetConfig board = config.shared_memory;
  add(board, "link adapter", topology.shared_memory, adapter, LinkAdapter::base, LinkAdapter::size);
  board.max_burst = 1;
  add(board, "shared registers", topology.shared_memory, registers, SharedRegisters::base, SharedRegisters::size);
  if (dock == nullptr) return;
  const auto clock = [&](DeviceGroup group) { return bus_clocks[topology.devices[static_cast<std::size_t>(group)]]; };
  devices.emplace(program, *dock,
                  std::array{clock(DeviceGroup::drives), clock(DeviceGroup::sensors), clock(DeviceGroup::comm_port)},
                  fence);
  static constexpr const char* names[device_groups] = {"drives", "sensors", "comm port"};
  for (const Devices::RegisterRange& part : devices->ranges()) {
    const auto group = static_cast<std::size_t>(part.group);
    add(config.devices, names[group], topology.devices[group], device_windows.emplace_back(*devices, part.first),
        topology.devices_at[group] + part.first, part.end - part.first);
  }
}

// The routes of a board to the parts of a window from offset `at` on; a part without a route is left out.
std::vector<BusRoute> Machine::Parts::routes(const std::vector<unsigned>& standing, Window window, Offset at) const {
  const Topology& topology = config.topology;
  if (window == Window::a)
    return {route_to(topology, standing, topology.shared_memory, at, at + shared_space, pci::Address{0} - at)};
  std::vector<BusRoute> all;
  const auto add = [&](DeviceGroup of, Offset first, Offset end) {
    const auto group = static_cast<std::size_t>(of);
    for (const unsigned bus : standing) {
      if (hops(topology, bus, topology.devices[group]) < 0) continue;
      all.push_back(
          route_to(topology, standing, topology.devices[group], at + first, at + end, topology.devices_at[group] - at));
      return;
    }
  };
  if (!devices) add(DeviceGroup::drives, 0, device_space);
  if (devices)
    for (const Devices::RegisterRange& part : devices->ranges()) add(part.group, part.first, part.end);
  return all;
}

void Machine::Parts::build_bridges() {
  const Topology& topology = config.topology;
  for (const auto& [a, b] : topology.bridges) {
    pci::BusBridgeConfig bridge = config.bus_bridge;
    bridge.name = fmt::format("bridge {}-{}", topology.buses[a], topology.buses[b]);
    bridges.emplace_back(buses[a], buses[b], bridge, this);
    for (const Region& region : regions) {
      for (const auto& [near, far] : {std::pair{a, b}, std::pair{b, a}})
        if (near != region.bus && next_bus(topology, near, region.bus) == static_cast<int>(far))
          bridges.back().claim(buses[near], bridge.name + ": " + region.name, region.base, region.words);
    }
  }
}

void Machine::Parts::delivered(const pci::Bus& far, unsigned agent, pci::Address address, Word, pci::Clocks clock,
                               pci::Result result) {
  if (is_host(agent)) return;
  for (unsigned bus = 0; bus < buses.size(); ++bus)
    if (&buses[bus] == &far) dsps.at(agent - 1).delivered(bus, address, clock, result);
}

void Machine::Parts::observe(Observer* observer) {
  around->observer = observer;
  watches.clear();
  for (unsigned i = 0; i < buses.size(); ++i) {
    if (observer != nullptr) watches.emplace_back(*this, static_cast<BusId>(i));
    const bool attempts = static_cast<bool>(bus_watch);
    const bool watches_bus = observer != nullptr && (attempts || observer->wants_transactions());
    buses[i].set_monitor(watches_bus ? &watches.back() : nullptr, attempts);
  }
}

void Machine::Parts::run_until(Time limit) {
  scheduler.run_until(limit);
  time = std::max(time, limit);
  for (Dsp& dsp : dsps) dsp.settle(time);
  scheduler.all_changed();  // the DMA of an idle DSP may have changed its links' next events
}

void Machine::Parts::act(const ScriptedEvent& event, Time now) {
  if (around->observer != nullptr) around->observer->scripted(event, now);
  const Stage stage{.dsps = dsps,
                    .registers = registers,
                    .fence = fence,
                    .adapter = adapter,
                    .host = host ? &*host : nullptr,
                    .buses = buses,
                    .bus_clocks = bus_clocks,
                    .dock = dock};
  row_of(event.action).act(stage, event, now);
}

Machine::Machine(Config config, const toolchain::Image& program, plant::Dock* dock, HostProgram* host)
    : parts_{std::make_unique<Parts>(std::move(config), program, dock, host)} {}
Machine::~Machine() = default;

void Machine::run_until(Time limit) { parts_->run_until(limit); }
Time Machine::time() const { return parts_->time; }
const Config& Machine::config() const { return parts_->config; }
void Machine::set_observer(Observer* observer) { parts_->observe(observer); }
void Machine::act(const ScriptedEvent& event) {
  require_sense({.time = parts_->time, .action = event.action, .number = event.number, .amount = event.amount},
                parts_->time, parts_->config);
  parts_->act(event, parts_->time);
}

void Machine::script(const ScriptedEvent& event) {
  require_sense(event, parts_->time, parts_->config);
  parts_->script.add(event);
}

unsigned Machine::slots() const { return parts_->config.slots; }
bool Machine::plugged(unsigned slot) const { return parts_->dsps.at(slot).plugged(); }
bool Machine::booted(unsigned slot) const { return parts_->dsps.at(slot).booted(); }
bool Machine::standing(unsigned slot) const { return parts_->dsps.at(slot).standing(); }
bool Machine::in_reset(unsigned slot) const { return parts_->dsps.at(slot).in_reset(); }
bool Machine::in_access(unsigned slot) const { return parts_->dsps.at(slot).in_access(); }
void Machine::look_again() {
  for (Dsp& dsp : parts_->dsps) dsp.look_again(parts_->time);
}
c40::Chip& Machine::chip(unsigned slot) { return parts_->dsps.at(slot).chip(); }
const c40::Chip& Machine::chip(unsigned slot) const { return parts_->dsps.at(slot).chip(); }
Spent Machine::spent(unsigned slot) const { return parts_->dsps.at(slot).spent(parts_->time); }
const Clock& Machine::chip_clock() const { return parts_->around->chip_clock; }
unsigned Machine::buses() const { return static_cast<unsigned>(parts_->buses.size()); }
const pci::Bus& Machine::bus(BusId id) const { return parts_->buses.at(static_cast<std::size_t>(id)); }
pci::BusStatistics Machine::bus_statistics(BusId id) const { return bus(id).statistics(parts_->counted_until(id)); }
std::vector<std::string> Machine::audit() const {
  std::vector<std::string> faults = parts_->adapter.audit();
  for (const SlotWire& wire : parts_->wires)
    if (auto fault = wire.link().unbalanced()) faults.push_back(std::move(*fault));
  for (std::size_t i = 0; i < parts_->buses.size(); ++i) {
    const pci::Bus& bus = parts_->buses[i];
    const auto clock = std::max(bus.now(), parts_->bus_clocks[i].tick_at_or_before(parts_->time));
    for (std::string& fault : pci::audit(bus, clock)) faults.push_back(std::move(fault));
  }
  return faults;
}
std::size_t Machine::links() const { return parts_->wires.size(); }
const SlotWire& Machine::link(std::size_t n) const { return parts_->wires.at(n); }
std::size_t Machine::nets() const { return parts_->nets.size(); }
const Net& Machine::net(std::size_t n) const { return parts_->nets.at(n); }
const std::vector<ChipFault>& Machine::faults() const { return parts_->around->faults; }
const SlotStatistics& Machine::statistics(unsigned slot) const { return parts_->dsps.at(slot).statistics(); }
Word Machine::peek(Offset offset) const { return parts_->sram.words().at(offset); }
void Machine::poke(Offset offset, Word word) { parts_->sram.words().at(offset) = word; }
void Machine::watch_buses(BusWatch watch) {
  parts_->bus_watch = std::move(watch);
  parts_->observe(parts_->around->observer);
}

void Machine::each_attempt_under_way(const BusWatch& tell) const {
  for (unsigned i = 0; i < buses(); ++i) {
    const auto id = static_cast<BusId>(i);
    const pci::Clocks until = parts_->counted_until(id);
    const pci::Attempt* running = bus(id).under_way();
    if (running == nullptr || running->frame >= until) continue;
    pci::Attempt so_far = *running;
    so_far.last = std::min(so_far.last, until - 1);
    so_far.words = so_far.last < so_far.first
                       ? 0
                       : std::min(so_far.words, static_cast<unsigned>((so_far.last - so_far.first) / so_far.step) + 1);
    tell(id, so_far, parts_->bus_clocks[i]);
  }
}

void Machine::watch_shared(SharedWatch watch) {
  if (!watch) return parts_->sram.set_watch({});
  const Clock& clock = parts_->bus_clocks[parts_->config.topology.shared_memory];
  parts_->sram.set_watch([this, &clock, watch = std::move(watch)](Offset offset, Word before, Word value, bool write,
                                                                  const pci::Access& access) {
    watch(offset, before, value, write, access.agent,
          std::max(clock.at(access.clock), parts_->scheduler.now()) + Time{1});
  });
}
Time Machine::time_of(unsigned slot, std::int64_t cycle) const { return parts_->dsps.at(slot).time_of(cycle); }
Word Machine::symbol(std::string_view name) const { return parts_->program.symbol(name); }

std::vector<Word> Machine::boot_stream(unsigned slot) const {
  const Config& config = parts_->config;
  toolchain::Image program;  // without names and lines
  program.cpu = parts_->program.cpu;
  program.sections = parts_->program.sections;
  program.entry = parts_->program.entry;
  for (const auto& [address, value] : start_words(parts_->symbols, config, slot)) {
    Word* word = program.word_at(address);
    if (word == nullptr)
      throw std::invalid_argument{fmt::format(
          "the DSP program: dsp_slot, idle_policy and pause_count are words of loaded sections; {:08X}h is none",
          address)};
    *word = value;
  }
  return machine::boot_stream(program, {.global_interface_control = config.board.global_interface_control,
                                        .local_interface_control = config.board.local_interface_control});
}

void Machine::list_state(state::Visitor& list) {
  Parts& p = *parts_;
  list("time", p.time);
  list("script", p.config.script);
  list("scripted", p.script.done);
  list("fence", p.fence.mask);
  list("shared memory", p.sram.words());
  list("registers", p.registers);
  list("link adapter", p.adapter);
  if (p.guard) list("guard", *p.guard);
  if (p.devices) list("devices", *p.devices);
  if (p.host) list("host", *p.host);
  list("faults", p.around->faults);
  list("in reset", p.around->in_reset);
  list("buses", p.buses);
  list("bridges", p.bridges);
  list("wires", p.wires);
  list("nets", p.nets);
  list("dsps", p.dsps);
  if (list.loads()) p.scheduler.all_changed();
}

void Machine::append_state(std::vector<std::uint64_t>& words) const {
  words.push_back(static_cast<std::uint64_t>(parts_->time.count()));
  words.insert(words.end(), parts_->sram.words().begin(), parts_->sram.words().end());
  parts_->registers.append_state(words);
  parts_->adapter.append_state(words);
  if (parts_->devices) parts_->devices->append_state(words);
  for (const Dsp& dsp : parts_->dsps) dsp.append_state(words);
  for (const pci::BusBridge& bridge : parts_->bridges) bridge.append_state(words);
  for (const SlotWire& wire : parts_->wires) wire.append_state(words);
  for (const Net& net : parts_->nets) words.insert(words.end(), {net.level(), net.edges(), net.missed()});
}

}  // namespace machine
