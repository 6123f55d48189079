#pragma once
// The parts of a network; only the network's own sources include this file.
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "machine/boards/board_reserved.hpp"
#include "machine/chips/boot.hpp"
#include "machine/chips/chip_runner.hpp"
#include "machine/chips/loop_watch.hpp"
#include "machine/networks/network.hpp"
#include "machine/program_text/address_names.hpp"
#include "machine/time/scheduler.hpp"

namespace machine {

struct Network::Memory {
  SharedMemory description;
  std::vector<c40::Word> words;
  Time free{0};  ///< end of the access under way
  /// The last access of each side of a dual-port memory.
  struct Side {
    c40::Address word = 0;
    Time until{0};
  };
  std::array<Side, 2> sides{};
  std::array<Net*, 2> mailbox_nets{};  ///< to the sides' pins
  std::optional<std::size_t> owner;    ///< owner of the lock

  /// Which of the memory's places belongs to the chip.
  std::size_t side_of(std::size_t chip, c40::Address address) const;
  /// When the access could begin, as far as other chips use the memory.
  Time free_for(std::size_t chip, c40::Address address) const;
  void list_state(state::Visitor& list);
};

/// A chip of the network, as an actor in time.
struct Network::Node final : c40::PeripheralSink, Scheduler::Processor, PinOwner, c40::PinListener, private ChipRunner {
  Node(Network& network_, std::size_t number_, NetworkChip given, Clock clock_)
      : network(network_),
        number(number_),
        description(std::move(given)),
        clock(clock_),
        chip(board_of(description)),
        ignored(description.board.ignored) {}

  /// A board without [pins] gets pins for booting from the ports.
  static const c40::Board& board_of(NetworkChip& chip) {
    if (chip.boot && !chip.board.has_pins) chip.board.board = with_boot_from_port(std::move(chip.board.board));
    return chip.board.board;
  }

  Network& network;
  std::size_t number;
  NetworkChip description;
  Clock clock;
  c40::Chip chip;
  IgnoredAccesses ignored;
  ChipStatus status = ChipStatus::running;
  c40::StopInfo stop;                      ///< of a waiting chip, or why it ended
  const c40::CommPort* awaited = nullptr;  ///< the port for which it waits or waited last
  int awaited_number = -1;                 ///< its number
  bool was_ready = false;                  ///< whether the port or memory was ready at the last check
  Time ready_since{0};
  c40::Cycles asleep_since = 0;  ///< for a chip that sleeps in a branch to itself
  std::vector<std::size_t> links;
  std::unique_ptr<BoardDevices> devices;  ///< null: none
  DeviceTurn* device_turn = nullptr;      ///< null: they do nothing by themselves that others see
  Time device_event = never;
  std::vector<Net*> nets_in, nets_out;  ///< nets that lead to its pins, and nets that it can drive
  const Net* reset_net = nullptr;       ///< that leads to its RESET pin
  std::vector<c40::Pin> pins_in;
  bool shares_memory = false;
  Time dma_answered{0};  ///< when an access of its DMA to a shared memory, or a device that acts on others, took place

  /// The check for endless polling: made when nothing has happened for a while, and then in growing intervals.
  struct Patience {
    static constexpr c40::Cycles first = 10'000;
    static constexpr int growth = 8;
    static constexpr c40::Cycles longest_look = 1'000'000;  ///< every instruction of a look is kept, in 50 bytes
    c40::Cycles since = 0;                                  ///< no event anywhere since this cycle
    c40::Cycles length = first;                             ///< until the next check
    std::uint64_t news = 0;                                 ///< Network::news_ at that cycle
    std::optional<LoopWatch> looking;
    std::optional<LoopWatch::Loop> loop;  ///< the loop found; valid until the next event
    Time found{0};                        ///< when
    bool is_private = false;              ///< it reads nothing that others could change
    c40::Cycles next_look() const { return since + length + (looking ? std::min(length / 10, longest_look) : 0); }
  } patience;
  c40::TraceSink* trace = nullptr;
  mutable std::optional<AddressNames> named;
  /// Names of its program's addresses, made at the first call.
  const AddressNames& names() const { return named ? *named : named.emplace(*description.program); }
  std::vector<c40::PeripheralEvent> peripheral_events;
  void happened(const c40::PeripheralEvent& event) override { peripheral_events.push_back(event); }

  void list_state(state::Visitor& list);
  bool waits_for_port() const {
    return status == ChipStatus::waiting && stop.reason != c40::StopInfo::Reason::external_access;
  }
  bool waits_for_window() const {
    return status == ChipStatus::waiting && stop.reason == c40::StopInfo::Reason::external_access;
  }
  /// It is before an access to a device that acts on other chips, and waits for its place in the order of the network.
  bool waits_for_device() const {
    return waits_for_window() && devices != nullptr && devices->has(stop.access.address);
  }
  bool waits_for_memory() const { return waits_for_window() && !waits_for_device(); }
  /// Its DMA has an access to a window under way. Nothing on the chip continues before the answer.
  bool dma_awaits_answer() const { return waits_for_window() && stop.access.channel >= 0; }
  c40::Cycles first_cycle(Time time) const { return clock.tick_at_or_after(time); }
  /// Processor, DMA, and the timers at pins that drive nets, have done everything before this instant. What the
  /// processor did while its DMA waited for an answer is seen when the answer comes.
  Time now() const { return std::max(std::min(clock.at(chip.settled()), next_pin_event()), dma_answered); }
  /// Its behaviour depends on its ports or pins, or on a device that acts on other chips.
  bool watches() const { return !nets_in.empty() || chip.watches_ports() || !network.acting_.empty(); }
  /// Its DMA, which is behind the processor, may do something at pins that drive nets, or at a shared memory.
  bool dma_acts_on_others() const { return chip.dma_active() && (!nets_out.empty() || shares_memory); }
  /// It runs, and its behaviour depends on its ports or pins: it must not run past their next events. Or others depend
  /// on what its DMA does, and the DMA advances only with the processor. Or its DMA advances while the processor waits.
  bool follows() const {
    if (status == ChipStatus::running) return watches() || dma_acts_on_others();
    return status == ChipStatus::waiting && chip.dma_busy() && !dma_awaits_answer();
  }
  bool reacts_to(c40::Pin pin) const;
  bool reacts_to_pins() const;
  /// Its RESET pin, which a net drives, is low.
  bool reset_is_low() const { return reset_net != nullptr && reset_net->is_low_at({number, c40::Pin::reset}); }
  /// The cycle before which no action on the chip can be: of a script, or by its RESET pin.
  c40::Cycles next_action() const {
    const c40::Cycles scripted = network.next_action_on(*this);
    const Time edge = reset_net != nullptr ? reset_net->reaches(number) : never;
    return edge == never ? scripted : std::min(scripted, first_cycle(edge));
  }
  bool held() const { return status == ChipStatus::held || status == ChipStatus::pulled_out; }
  bool dma_waits() const {
    const bool lives = status == ChipStatus::running || status == ChipStatus::waiting || status == ChipStatus::sleeping;
    return lives && chip.dma_active() && !chip.dma_busy();
  }

  // Implements PinOwner.
  c40::Chip& owned_chip() override { return chip; }
  Time time_of(c40::Cycles cycle) const override { return clock.at(cycle); }
  c40::Cycles cycle_from(Time time) const override { return first_cycle(time); }
  Time drives_from() const override;
  bool listens_to(c40::Pin pin) const override;
  void pin_changes(c40::Pin pin, bool level, Time now) override;
  void driven(c40::Pin pin, c40::Drive drive, c40::Cycles at) override;

  // Implements Scheduler::Processor.
  Time next() const override;
  void act(Time now) override;
  /// A chip in a loop continues in its turn alone: before each turn it is known whether the network has ended.
  bool runs() const override { return status == ChipStatus::running && !patience.loop; }
  void run_ahead(Time until) override;
  Time horizon() const override;

  /// The next events of its links, and of actions on it, may have changed.
  void tell_changes();

  // How it continues.
  Time next_pin_event() const;
  void drive_on(Time now);
  void run_to(Time until, c40::Cycles last = std::numeric_limits<c40::Cycles>::max());
  /// To be called before something outside changes, at `time`, what the chip follows. Returns whether the chip has to
  /// follow.
  bool come_to(Time time) {
    const bool only_waits = status == ChipStatus::waiting && !chip.dma_active();
    return !only_waits && follow_to(time);
  }
  bool follow_to(Time time);
  void bring_to(Time time, bool fully);
  void bring_timers_to(Time time);
  void note_own_event(c40::Cycles event);
  void stand_at_rest_until(Time time);
  void look_for_loop();
  void begin_patience();
  void note_idle();
  void look_again(bool moved);
  /// Updates whether the port for which it waits is ready. Returns whether this has changed.
  bool note_ready(Time time) {
    if (!waits_for_port()) return false;
    const bool now = port_is_ready(), changes = now != was_ready;
    if (now && changes) ready_since = time;
    was_ready = now;
    return changes;
  }
  void forget_port();
  void wake_up();

  // Its status.
  void await(int port) {
    if (port != awaited_number) awaited = &chip.port(port), awaited_number = port;
  }
  bool port_is_ready() const { return stop.reason == c40::StopInfo::Reason::port_access && stop.port.ready(*awaited); }
  bool ready() const;
  /// The same. Nothing but a link, or its own DMA, makes a port ready.
  bool is_ready() const { return waits_for_port() && !chip.dma_active() ? was_ready : ready(); }
  bool wakes() const;
  Time access_time() const;
  c40::Cycles own_event_cycle() const;
  Time own_event() const;
  Time at_rest_since() const;
  Time lookahead() const;
  /// When its devices next act by themselves with an effect on a pin. Stored, because it is used often.
  Time next_device_event() const { return device_event; }
  void note_device_event();
  bool devices_continue() const;
  /// The last cycle in which it may begin an instruction before devices of other chips could act on it.
  c40::Cycles last_before_devices() const;
  bool has_ended() const;
  bool awaits_dma_forever() const;
  /// Nothing will happen here, except a loop that repeats.
  bool is_still() const {
    return patience.loop ||
           (status != ChipStatus::running && (planned() == never || (!nets_out.empty() && only_drives_unheard())));
  }

 private:
  void continue_with_others(Time now);
  bool only_drives_unheard() const;
  void run_freely(Time until);
  void pass_to(c40::Cycles limit, c40::Cycles known);
  bool sleeps_for_interrupt() const;
  bool is_shared(c40::Address address) const;
  bool serve_device(const c40::ExternalAccess& access);
  Time horizon_on_its_own() const;
  Time horizon_of_follower() const;
  Time others_reach_it() const;
  Time next_look() const { return clock.at(std::max(patience.next_look(), chip.cycle() + 1)); }

  std::optional<Span> span() override;
  std::optional<Span> span_of_runner();
  bool at_limit() override;
  bool asks_again() override;
  bool at_breakpoint() override;
  std::optional<ChipStatus> rest() const;
  std::optional<ChipStatus> rest_in_idle() const;
  bool window_access(const c40::ExternalAccess& access) override;
  bool port_access(const c40::PortAccess& access) override { return waits(c40::StopInfo::Reason::port_access, access); }
  bool port_wait(const c40::PortAccess& access) override { return waits(c40::StopInfo::Reason::port_wait, access); }
  bool faulted(const c40::Fault& why) override;
  bool waits(c40::StopInfo::Reason why, const c40::PortAccess& access);
  bool has_moved() const {
    const bool ends = !ended_before_ && !chip.dma_ends_by(never_cycle);
    return ends || chip.cycle() != cycle_before_ || chip.settled() != settled_before_;
  }
  bool dma_is_behind() const { return chip.settled() < chip.cycle() || chip.dma_ends_by(chip.cycle()); }
  bool passes_on() const {
    return status == ChipStatus::sleeping && (chip.cycle() < span_.limit || chip.settled() < span_.known);
  }

  /// While the processor waits: the DMA has not come to the end of the present span.
  bool dma_continues() const { return chip.dma_busy() && chip.settled() < span_.known; }

  // For the present call of run_to or pass_to.
  bool passing_ = false;          ///< it sleeps, and stays asleep
  bool over_breakpoint_ = false;  ///< the instruction at the breakpoint is executed next
  c40::Cycles ends_ = 0, action_ = 0, last_ = 0;
  Span span_;
  c40::Cycles cycle_before_ = -1, settled_before_ = -1;
  bool ended_before_ = true;
};

/// A link as an actor.
struct Network::LinkTurn final : Scheduler::Actor {
  LinkTurn(Network& network_, std::size_t number_) : network(network_), number(number_) {}
  Time next() const override { return network.links_[number]->next_event(); }
  void act(Time now) override { network.link_happens(number, now); }
  Network& network;
  std::size_t number;
};

/// The devices of a chip, with what they do by themselves, as an actor.
struct Network::DeviceTurn final : Scheduler::Actor {
  explicit DeviceTurn(Node& node_) : node(node_) {}
  Time next() const override { return node.next_device_event(); }
  void act(Time now) override {
    node.network.now_ = now;
    // The network was not at rest before. A chip that runs has not come to rest itself.
    const bool counts = node.status != ChipStatus::running || node.devices->will_act_on_others();
    if (counts && node.devices_continue()) node.network.changed_ = now;
    node.devices->advance_to(node.first_cycle(now));
    node.note_device_event();
    node.changed();
    if (node.devices->act_on_others()) node.network.devices_acted();
  }
  Node& node;
};

/// The scripted actions as an actor.
struct Network::ActionTurn final : Scheduler::Actor {
  explicit ActionTurn(Network& network_) : network(network_) {}
  Time next() const override { return network.next_action(); }
  void act(Time now) override { network.actions_happen(now); }
  Network& network;
};

/// Missed pulses of a net that are recorded though nobody asked for events; the net counts all.
constexpr std::uint64_t most_missed_events = 1000;

/// Records events of nets. If two nets change at one instant, either may report first.
struct Network::NetTap final : Net::Listener {
  explicit NetTap(Network& network_) : network(network_) {}
  void changed(Net& net, bool level, Time at) override {
    if (network.records_words_) keep(level ? NetworkEvent::Kind::rise : NetworkEvent::Kind::fall, net, at, 0);
  }
  void missed(Net& net, std::size_t chip, Time at) override {
    if (network.records_words_ || net.missed() <= most_missed_events)
      keep(NetworkEvent::Kind::missed, net, at, static_cast<int>(chip));
  }
  void keep(NetworkEvent::Kind kind, const Net& net, Time at, int side) {
    const auto which = std::ranges::find(network.nets_, &net, &std::unique_ptr<Net>::get);
    const auto number = static_cast<std::size_t>(which - network.nets_.begin());
    const auto earlier = [](const NetworkEvent& a, const NetworkEvent& b) {
      return std::pair{a.time, a.place} < std::pair{b.time, b.place};
    };
    const NetworkEvent event{kind, at, number, side, 0, 0};
    network.net_events_.insert(std::ranges::upper_bound(network.net_events_, event, earlier), event);
  }
  Network& network;
};

/// Records events of one link.
struct Network::LinkTap final : c40::LinkListener {
  LinkTap(Network& network_, std::size_t number_) : network(network_), number(number_) {}
  void happened(const c40::LinkEvent& e) override {
    const auto kind = static_cast<NetworkEvent::Kind>(e.kind);
    if (is_common(kind) && !network.records_words_) return;
    network.events_.push_back({kind, e.time, number, e.side, e.word, e.bytes});
  }
  Network& network;
  std::size_t number;
};

}  // namespace machine
