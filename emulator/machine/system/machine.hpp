#pragma once
// Several C40s, two PCI buses, shared memory, a host and the dock, in one virtual time (docs/architecture.md, decisions
// 2 to 7).
//
// Each DSP accesses shared memory through window A at C0000000h, and drives, sensors and AGV units through window B at
// 70000000h. The topology decides which of its bridges leads there: by default bus A (host, shared memory) for window
// A, bus B (devices) for window B. The host is a HostProgram: its work is C++, but each of its reads and writes is a
// transaction.
//
// Order: machine/time/scheduler.hpp. At one instant: host, buses in their order, scripted events, links, nets, DSP
// slots, the plant last.
//
// Inaccuracies: a doorbell or reset takes effect at the end of the write burst that contains it; burst reads get the
// memory's words at FRAME#; the host's processor has no caches and no work besides its HostProgram's.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bus_model/config.hpp"
#include "c40/chip/board.hpp"
#include "c40/values/types.hpp"
#include "machine/dsps/slot_links.hpp"
#include "machine/networks/net_description.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/scripted_events.hpp"
#include "machine/time/time.hpp"

namespace c40 {
class Chip;
}
namespace pci {
class Bus;
struct Attempt;
struct BusStatistics;
struct Transaction;
}  // namespace pci
namespace plant {
class Dock;
}
namespace state {
class Visitor;
}
namespace toolchain {
struct Image;
}

namespace machine {

class Net;

using Word = std::uint32_t;
// Offset: a C40's address minus the window's base. The host's program uses the offsets of window A.

enum class BusId : std::uint8_t { a, b, c, d };
/// The windows of a DSP; by default bus A and bus B are behind them.
enum class Window : std::uint8_t { a, b };

/// The host's access to shared memory. Writes are posted in order (rising addresses form bursts); a read goes to the
/// bus after all writes before it. May be used only inside HostProgram's calls.
class HostPort {
 public:
  virtual ~HostPort() = default;
  /// Requests n_words (at least 1) from offset on. HostProgram::read_done with the same tag brings the answer. The
  /// words are single transactions, one after the other: a Pentium's reads of PCI memory do not burst (plant-and-bus.md
  /// 3.1). Throws std::logic_error while a read is outstanding.
  virtual void read(Offset offset, unsigned n_words, std::uint32_t tag) = 0;
  /// Throws std::logic_error while a read is outstanding: the processor waits for it. read and write throw
  /// std::out_of_range for an offset at which no device answers on bus A.
  virtual void write(Offset offset, std::span<const Word> words) = 0;
  void write(Offset offset, Word word) { write(offset, std::span<const Word>{&word, 1}); }
  /// A read is outstanding.
  virtual bool reading() const = 0;
  /// Number of words written here that have not reached their target yet.
  virtual std::size_t pending_writes() const = 0;
};

/// The host's software.
class HostProgram {
 public:
  virtual ~HostProgram() = default;
  /// When it has to be woken next (never: only by read_done). Called after each of the calls below; a time in the past
  /// means now.
  virtual Time next_wake() const = 0;
  virtual void wake(Time now, HostPort& port) = 0;
  /// A DSP has left reset and waits for its boot stream (LINK_REQUEST says which): an interrupt. This function may only
  /// record it.
  virtual void boot_requested(Time /*now*/) {}
  /// The words are valid only during the call.
  virtual void read_done(std::uint32_t tag, std::span<const Word> words, Time now, HostPort& port) = 0;
};

/// Why a DSP stopped until its next reset: the message of the chip or its bus.
struct ChipFault {
  unsigned slot = 0;
  Time time{};
  std::int64_t cycle = 0;
  std::uint32_t pc = 0;
  std::uint32_t address = 0;  ///< the accessed address, or 0
  std::string message;        ///< names the DSP, the PC, the cycle and the cause
};

enum class SemaphoreEvent : std::uint8_t { acquired, refused, released };
/// booted: the program runs, and has reported over the link.
enum class SlotChange : std::uint8_t { plugged, unplugged, reset, booted };

/// Boot method: how a DSP gets its program after reset.
enum class Boot : std::uint8_t {
  preloaded,  ///< the program is in the DSP's memory and is started
  link,       ///< the boot ROM takes the program from the link adapter, to which the host's program has to write it
};

/// Sees all events in their order, and changes nothing. Every function does nothing unless overridden.
class Observer {
 public:
  virtual ~Observer() = default;
  /// A DSP issues a write at `issued`; its program may be ahead of others. Per slot in order, before dsp_write reports
  /// the same write. The chip's counters are those of this instant.
  virtual void dsp_issue(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/) {}
  /// Whether dsp_issue is to be called for writes to there.
  virtual bool wants_issues_at(Window, Offset) const { return false; }
  /// A DSP's write has reached its target at `now`; the program issued it at `issued`. Not called for fenced writes
  /// (see dsp_write_dropped).
  virtual void dsp_write(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/, Time /*now*/) {}
  virtual void dsp_write_dropped(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/, Time /*now*/) {}
  /// In addition to dsp_write_dropped: the guard has refused the write. kind: of the DSP's present task, FFFFFFFFh if
  /// none.
  virtual void dsp_write_refused(unsigned /*slot*/, Offset, Word, Word /*kind*/, Time /*now*/) {}
  /// A DSP's access through a window made it wait from `from` to `to`.
  virtual void dsp_waited(unsigned /*slot*/, Window, Time /*from*/, Time /*to*/) {}
  /// A transaction has ended. On every bus of the host, the host is master 0; then come the DSPs in the order of their
  /// slots, then the bridges between buses.
  virtual void transaction(BusId, const pci::Transaction&, Time /*now*/) {}
  /// Asked once, when the observer is set. If not, transaction() is not called.
  virtual bool wants_transactions() const { return true; }
  virtual void interrupt(unsigned /*slot*/, int /*iiof pin*/, Time /*now*/) {}
  /// owner: DSP slot + 1, or host_owner.
  virtual void semaphore(unsigned /*number*/, SemaphoreEvent, unsigned /*owner*/, Time /*now*/) {}
  virtual void fault(const ChipFault&) {}
  virtual void slot(unsigned /*slot*/, SlotChange, Time /*now*/) {}
  /// A word on the link between adapter and DSP is lost; `bytes` of its four bytes had crossed.
  virtual void link_lost(unsigned /*slot*/, bool /*to_dsp*/, Word, int /*bytes*/, Time /*now*/) {}
  virtual void scripted(const ScriptedEvent&, Time /*now*/) {}
};

inline constexpr unsigned host_owner = 0xFF;
/// The host's program finds offset 0 of window B here, if its board has a route to it.
inline constexpr Offset host_devices = 0x100000;
inline constexpr unsigned most_slots = 16;

struct Config {
  unsigned dsps = 4;                  ///< DSPs at the start: slots 0 to dsps - 1
  unsigned slots = 0;                 ///< slots in all, at most most_slots; 0: as many as dsps
  std::int64_t chip_hz = 25'000'000;  ///< instruction cycles per second: C40-40 20 M, C40-50 25 M, C40-60 30 M
  std::int64_t chip_hz_denominator = 1;
  c40::Board board =
      c40::Board::default_board();  ///< of every DSP; needs the windows to both buses (BoardError otherwise)
  std::int64_t pci_hz_numerator = 100'000'000;
  std::int64_t pci_hz_denominator = 3;
  std::vector<Skew> chip_skews;  ///< by slot; no skew for slots beyond the list
  std::vector<Skew> bus_skews;   ///< by bus; buses connected by bridges run on one clock, that of the first of them
  Boot boot = Boot::preloaded;
  Word idle_policy = 0;    ///< value of the program's symbol idle_policy: 0 doorbell, 1 pause, 2 spin
  Word pause_count = 125;  ///< value of pause_count
  Topology topology{};
  std::vector<SlotLink> links;       ///< between slots
  std::vector<NetDescription> nets;  ///< between pins of slots
  pci::BusConfig bus{};              ///< of every bus; the names are the topology's
  pci::MasterConfig dsp_master{};
  unsigned first_level_dsps = 0;  ///< with Arbitration::two_level, slots below this share the first level with the host
  pci::MasterConfig host_master{.name = "host"};
  pci::BridgeConfig bridge_a{.prefetch_limit = 0x10000};  ///< from a DSP to shared memory
  pci::BridgeConfig bridge_b{.prefetch_words = 0};        ///< from a DSP to a bus that leads to devices only
  pci::BusBridgeConfig bus_bridge{};
  pci::BridgeConfig host_bridge{.request_sync = 5, .return_sync = 3, .post_depth = 16, .prefetch_words = 0};
  pci::TargetConfig shared_memory = pci::TargetConfig::sram();
  pci::TargetConfig devices = pci::TargetConfig::drive_card();
  pci::Clocks interrupt_clocks =
      2;  ///< 1 to 3 clocks from the end of a doorbell or reset write to the edge on IIOF0 or the reset
  pci::Clocks host_write_clocks = 2;  ///< time of the host's processor to post a word
  bool instant_access = false;  ///< accesses of boards take no time where the target takes them: no bus carries them
  std::int64_t prefetch_hit_cycles = 1;             ///< cycles of a DSP's read that its bridge's line answers
  Time reset_time = std::chrono::microseconds{10};  ///< time for which RESET is low
  std::uint64_t turn_order = 0;  ///< not 0: a seed for the order in which chips run ahead; changes nothing observable
  bool guard = false;  ///< shared memory refuses what a DSP's task may not write (machine/bus_agents/guard.hpp)
  std::vector<ScriptedEvent> script;  ///< in any order
};

/// Statistics per DSP slot that are not those of a bus.
struct SlotStatistics {
  std::uint64_t posted_writes = 0;
  std::uint64_t bus_reads = 0;
  std::uint64_t prefetch_hits = 0;
  std::uint64_t dropped_writes = 0;  ///< fenced
  std::uint64_t boots = 0;
  std::uint64_t words_to_dsp = 0;  ///< over the link, in both directions
  std::uint64_t words_from_dsp = 0;
  std::uint64_t words_lost = 0;
  std::int64_t window_b_arbitration = 0;  ///< cycles of the chip's cause bus_arbitration; the others are window A's
  std::int64_t window_b_transfer = 0;     ///< the same of bus_transfer
};

/// What a DSP has spent its cycles on: the sum of `causes` is `cycles`. A wait that is not over is in it.
struct Spent {
  c40::Cycles cycles = 0;
  c40::Causes causes{};
  c40::Cycles window_b_arbitration = 0, window_b_transfer = 0;  ///< of bus_arbitration and bus_transfer
};

/// See the head of this file.
class Machine {
 public:
  /// `program` is the DSPs' program. It has to define dsp_slot, idle_policy, pause_count, _start and the constants of
  /// the c40_programs/include files (std::invalid_argument names the missing ones). dock and host may be null: then no
  /// device answers on bus B, and there is no host. dock and host must outlive the machine; the image is copied.
  Machine(Config config, const toolchain::Image& program, plant::Dock* dock, HostProgram* host);
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  /// Executes everything before `limit`; time() is then `limit`.
  void run_until(Time limit);
  Time time() const;

  const Config& config() const;
  void set_observer(Observer* observer);

  /// Not before time(); std::invalid_argument for an earlier event and for an unknown number.
  void script(const ScriptedEvent& event);
  /// Executes the event at once, whatever its time; only between calls of run_until.
  void act(const ScriptedEvent& event);

  unsigned slots() const;
  bool plugged(unsigned slot) const;
  bool booted(unsigned slot) const;    ///< a board is in the slot, and its program has run since its last reset
  bool standing(unsigned slot) const;  ///< halted by a fault, Action::fail or Action::hang
  bool in_reset(unsigned slot) const;  ///< RESET is low
  /// Its processor waits for a bus or a link, or will at once: the instruction under way cannot be taken back.
  bool in_access(unsigned slot) const;
  /// To be called after registers or words of chips were changed between two runs: one may not be idle any more.
  void look_again();
  c40::Chip& chip(unsigned slot);
  const c40::Chip& chip(unsigned slot) const;
  Spent spent(unsigned slot) const;  ///< up to time()
  const Clock& chip_clock() const;   ///< nominal
  unsigned buses() const;
  const pci::Bus& bus(BusId id) const;
  /// Violations of the invariants of buses (pci::audit) and links in this run; empty unless the model has a fault.
  std::vector<std::string> audit() const;
  pci::BusStatistics bus_statistics(BusId id) const;  ///< over all clocks up to time()
  /// Between slots, in the order of Config::links.
  std::size_t links() const;
  const SlotWire& link(std::size_t n) const;
  /// Between pins of slots, in the order of Config::nets.
  std::size_t nets() const;
  const Net& net(std::size_t n) const;
  const std::vector<ChipFault>& faults() const;
  const SlotStatistics& statistics(unsigned slot) const;

  /// Shared memory as a debugger reads it, without time or side effects: offsets 0 to FFFFh.
  Word peek(Offset offset) const;
  void poke(Offset offset, Word word);
  /// Called for every access by a bus to a word of shared memory: its value before and after, the agent (DSP's slot +
  /// 1, 0 for the host), and the end of the access; an empty function: none. Changes nothing.
  using SharedWatch = std::function<void(Offset, Word before, Word value, bool write, unsigned agent, Time done)>;
  void watch_shared(SharedWatch watch);
  /// Called for each attempt of a master on a bus, with that bus's clock: from attempt.frame to attempt.last, per bus
  /// in this order; an empty function: none. Changes nothing.
  using BusWatch = std::function<void(BusId, const pci::Attempt&, const Clock&)>;
  void watch_buses(BusWatch watch);
  /// The beginning of a cycle of a DSP, at its present clock.
  Time time_of(unsigned slot, std::int64_t cycle) const;
  Word symbol(std::string_view name) const;  ///< of the program; std::out_of_range names it
  /// The boot stream for this slot's DSP (Config::boot): the program with dsp_slot, idle_policy and pause_count set.
  std::vector<Word> boot_stream(unsigned slot) const;

  /// Appends the machine's own final state (shared memory, devices' registers, links, each chip's registers and
  /// counters) as words. The report makes the SHA-256.
  void append_state(std::vector<std::uint64_t>& words) const;
  /// Everything that affects the machine's future, except the dock and the host's program; only between calls of
  /// run_until.
  void list_state(state::Visitor& list);

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace machine
