#pragma once
// One DSP board: a chip and its two bridges, advanced together in time.
//
// The board is always in one state, and says when it has to be called next. Its actions between two accesses (and
// posted writes for which there is room, and reads that the bridge's line answers) it may do ahead of all others, up to
// the given horizon.
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bus_model/bridge.hpp"
#include "bus_model/bus_bridge.hpp"
#include "c40/chip/chip.hpp"
#include "machine/bus_agents/devices.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/chips/chip_runner.hpp"
#include "machine/dsps/link_adapter.hpp"
#include "machine/networks/net.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/machine.hpp"
#include "machine/system/machine_config.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/symbols.hpp"
#include "machine/time/scheduler.hpp"
#include "machine/time/time.hpp"

namespace machine {

/// What all boards share.
struct DspContext {
  const Config& config;
  const Symbols& symbols;
  const toolchain::Image& program;
  Clock chip_clock;                ///< nominal
  std::vector<Clock> chip_clocks;  ///< by slot
  std::vector<Clock> bus_clocks;   ///< by bus
  std::deque<pci::Bus>& buses;
  std::deque<pci::BusBridge>& bridges;
  std::vector<BusRoute> window_a;  // the route of every DSP board
  std::vector<BusRoute> window_b;
  const SharedRegisters& registers;
  LinkAdapter& adapter;
  const Devices* devices;
  const Fence& fence;
  Guard* guard = nullptr;
  Observer* observer = nullptr;
  std::vector<ChipFault> faults;
  unsigned in_reset = 0;  ///< number of boards
  /// No unscheduled event can act on a board before this.
  std::function<Time()> earliest_action;
  /// The program of a slot has started or stopped: links between slots are connected or cut.
  std::function<void(unsigned slot, Time now)> slot_changed;
  const Scheduler& scheduler;
};

/// Words of its program that are set for each DSP.
std::vector<std::pair<c40::Address, Word>> start_words(const Symbols& symbols, const Config& config, unsigned slot);

class Dsp final : public Scheduler::Processor,
                  public PinOwner,
                  private c40::PinListener,
                  private c40::WindowListener,
                  private ChipRunner {
 public:
  Dsp(unsigned slot, bool plugged, DspContext& context);

  Time next() const override { return next_; }
  void act(Time now) override;
  bool runs() const override { return state_ == State::running; }
  void run_ahead(Time until) override;
  Time horizon() const override { return context_.earliest_action(); }

  void schedule_edge(Time time);
  void schedule_reset(Time time);
  void fail(Time now);
  void freeze(Time now);
  void hang(Time now);
  /// Its registers were changed: it may not be idle any more.
  void look_again(Time now);
  void unplug(Time now);
  /// Attaches a link to one of its ports, and the actor of the link.
  void attach(int port, c40::Link& link, int side, Scheduler::Actor& wire);
  /// Connects a net to its pins.
  void join(Net& net);
  /// A link at one of its ports has advanced to `now`.
  void link_moved(Time now);
  void link_event(const c40::LinkEvent& event);
  /// From now on its clock has this fraction of its nominal frequency, until another board is plugged in.
  void pace(Time now, std::int64_t parts_per_million);
  void plug(Time now);
  void reset(Time now);
  /// A word that it posted has passed the last bridge between buses and reached its target.
  void delivered(unsigned bus, pci::Address address, pci::Clocks clock, pci::Result result);
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list);
  /// Adds idle and halted cycles up to `now`.
  void settle(Time now);
  /// The chip's counts, and what a wait that is not over adds to them up to `now`: the chip counts a wait when it ends,
  /// which may never be.
  Spent spent(Time now) const;

  bool plugged() const { return state_ != State::out; }
  bool booted() const { return plugged() && answered_; }
  bool standing() const { return state_ == State::dead; }
  bool in_reset() const { return state_ == State::booting; }
  bool in_access() const {
    return state_ == State::access || state_ == State::port || state_ == State::blocked || state_ == State::resuming;
  }
  c40::Chip& chip() { return chip_; }
  const c40::Chip& chip() const { return chip_; }
  const SlotStatistics& statistics() const { return statistics_; }
  const PacedClock& clock() const { return clock_; }
  Scheduler::Actor& adapter_wire() { return adapter_wire_; }

  c40::Chip& owned_chip() override { return chip_; }
  Time time_of(c40::Cycles cycle) const override { return clock_.at(cycle); }
  c40::Cycles cycle_from(Time time) const override { return clock_.tick_at_or_after(time); }
  Time drives_from() const override;
  bool listens_to(c40::Pin) const override { return true; }
  void pin_changes(c40::Pin pin, bool level, Time now) override;

 private:
  enum class State : std::uint8_t {
    out,      // no board in the slot
    booting,  // held in reset until own_next_
    running,
    access,    // stopped before access_, which begins at own_next_
    port,      // stopped before port_access_, which begins at own_next_ or waits for the link
    blocked,   // the bridge has the access
    resuming,  // the answer reaches the chip at own_next_
    idle,
    faulting,  // fault_ happens at own_next_
    dead,      // halted
  };
  struct Side final : pci::Bridge::Client {
    Side(Dsp& owner, unsigned which, const pci::MasterConfig& master, const pci::BridgeConfig& config)
        : dsp{owner}, bus{which}, bridge{owner.context_.buses[which], master, config, *this} {}
    void answered(Word value, pci::Clocks ready, pci::Clocks arbitration, pci::Result result) override {
      dsp.answered(*this, value, ready, arbitration, result);
    }
    void taken(pci::Clocks ready, pci::Clocks arbitration) override { dsp.resume_at(*this, ready, arbitration); }
    void landed(const pci::Posted& posted, pci::Clocks clock, pci::Result) override {
      dsp.landed(*this, posted, clock);
    }
    void list_state(state::Visitor& list) { bridge.list_state(list); }
    Dsp& dsp;
    unsigned bus;
    pci::Bridge bridge;
  };

  /// Answers the chip instead of the board where accesses take no time.
  struct InstantAnswers final : c40::WindowListener {
    explicit InstantAnswers(Dsp& owner) : dsp{owner} {}
    bool answer_at_once(const c40::ExternalAccess& access, c40::WindowAnswer& answer) override {
      return dsp.answer_instantly(access, answer);
    }
    Dsp& dsp;
  };

  /// The link to the adapter, as an actor.
  struct AdapterWire final : Scheduler::Actor {
    explicit AdapterWire(Dsp& owner) : dsp{owner} {}
    Time next() const override { return dsp.wires_.front().link.next_event(); }
    void act(Time now) override {
      dsp.wires_.front().link.advance_to(now);
      dsp.link_moved(now);
    }
    Dsp& dsp;
  };

  struct Wire {
    int port;
    c40::Link& link;
    int side;
    Scheduler::Actor& actor;
  };

  /// A part of a window, the bridge that leads there, the clock of the bridge's bus, and with instant access the target
  /// that was reached last.
  struct Path {
    BusRoute route{};
    pci::Bridge* bridge = nullptr;
    const Clock* bus = nullptr;
    pci::DirectWindow target{};
  };

  /// Where a posted word goes (pci::Posted::mark).
  struct Mark {
    Window window;
    bool direct;
    std::uint16_t unused = 0;  ///< where padding would be: a bit_cast needs each bit to have a value
    Offset offset;
  };

  struct Underway {
    unsigned bus;
    Window window;
    Offset offset;
    pci::Posted posted;
  };

  void run(Time until);
  bool answer_at_once(const c40::ExternalAccess& access, c40::WindowAnswer& answer) override;
  bool answer_instantly(const c40::ExternalAccess& access, c40::WindowAnswer& answer);
  bool access_instantly(const c40::ExternalAccess& access, Time issued, Word& value);
  std::optional<Span> span() override;
  bool at_limit() override;
  bool asks_again() override { return true; }
  bool at_breakpoint() override { return at_limit(); }
  bool window_access(const c40::ExternalAccess& access) override;
  bool port_access(const c40::PortAccess& access) override;
  bool port_wait(const c40::PortAccess& access) override;
  bool faulted(const c40::Fault& why) override;
  void begin_access(Time horizon);
  void begin_read(const Path& path, Time issued);
  void begin_port_access(Time now, Time horizon);
  void driven(c40::Pin pin, c40::Drive drive, c40::Cycles at) override;
  Time next_pin_event() const;
  /// The first instant at which a net may change a pin of the board.
  Time nets_reach() const;
  Time next_of_links_and_pins() const;
  /// While the processor is before or in an access, a DMA that moves words over a link to another slot continues.
  bool dma_continues() const {
    return wires_.size() > 1 && in_access() && !dma_waits_ && chip_.dma_busy() && chip_.watches_ports();
  }
  void require_not_run_past(Time now) const;
  void run_dma(Time horizon);
  c40::Cycles limit(Time horizon) const {
    const c40::Cycles far = clock_.tick_at_or_after(horizon);
    return nets_in_.empty() && !chip_.watches_ports() ? far : limit_by_links(far);
  }
  c40::Cycles limit_by_links(c40::Cycles far) const;
  void post(const Path& path, const c40::ExternalAccess& access, Time issued);
  void issue_write(const c40::ExternalAccess& access, Time issued);
  void complete(Time horizon);
  void deliver_edge(Time now);
  bool caught_up(Time now);
  void go_astray();
  void leave_buses(Time now);
  void hold_in_reset(Time now);
  void leave_reset(Time now);
  void load();
  void has_booted(Time now);
  void stand_still(Time now);
  void answered(const Side& side, Word value, pci::Clocks ready, pci::Clocks arbitration, pci::Result result);
  void resume_at(const Side& side, pci::Clocks ready, pci::Clocks arbitration);
  void landed(const Side& side, const pci::Posted& posted, pci::Clocks clock);
  void arrived(Window window, Offset offset, Word value, Time issued, Time now);
  void fault(c40::Cycles cycle, std::uint32_t pc, std::uint32_t address, std::string what);
  void report_fault(Time now);
  void set_next();
  void plan();
  bool writable(Window window, Offset offset) const;

  bool on_a(std::uint32_t address) const { return address >= window_a_; }
  Offset offset_of(std::uint32_t address) const { return address - (on_a(address) ? window_a_ : window_b_); }
  Window window_of(std::uint32_t address) const { return on_a(address) ? Window::a : Window::b; }
  /// The part of the board's window with this address; behind the last part nothing answers.
  Path& path_of(std::uint32_t address) {
    Path& last = last_path_[on_a(address)];
    return last.route.holds(offset_of(address)) ? last : found_path(address);
  }
  Path& found_path(std::uint32_t address);

  unsigned slot_;
  DspContext& context_;
  // Read at each access:
  std::uint32_t window_a_ = context_.symbols.window_a, window_b_ = context_.symbols.window_b;
  bool instant_ = context_.config.instant_access;
  c40::Cycles hit_cycles_ = context_.config.prefetch_hit_cycles;
  PacedClock clock_;
  c40::Chip chip_;
  std::deque<Side> sides_;           // by the buses of the board
  std::array<Path, 2> last_path_{};  // by on_a: where to look first
  std::vector<Underway> underway_;   // in bridges between buses
  InstantAnswers instant_answers_{*this};
  AdapterWire adapter_wire_{*this};
  std::vector<Wire> wires_;               // the link adapter's is the first
  std::vector<Net*> nets_in_, nets_out_;  // nets that lead to its pins, and nets that it can drive
  unsigned inputs_ = 0, outputs_ = 0;     // the pins at these nets: bit n is pin n
  struct PinChange {
    c40::Pin pin;
    bool level;
  };
  std::vector<PinChange> pins_waiting_;  // changes during an access; seen when its instruction has ended
  State state_ = State::out;
  bool broken_ = false;        // no reset repairs it
  bool answered_ = true;       // since its reset the program has reported over the link
  bool edge_waiting_ = false;  // an edge during an access; taken when its instruction has ended
  bool hang_waiting_ = false;  // the same; during a reset: hangs at its first instruction
  bool dma_waits_ = false;     // its DMA waits for the processor: for a window, or for the processor's own access
  Time next_ = never;
  Time own_next_ = never;
  Time run_end_{0};  // end of the present run
  Time edge_ = never;
  Time reset_ = never;
  c40::Cycles refused_ =
      -1;  // the cycle of the access before which the chip stops, if it was just not answered at once
  c40::ExternalAccess access_{};
  c40::PortAccess port_access_{};
  Word answer_ = 0;
  c40::Cycles arbitration_ = 0;
  c40::Cycles transfer_ = 0;
  ChipFault fault_{};
  SlotStatistics statistics_{};
};

}  // namespace machine
