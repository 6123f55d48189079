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
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "c40/values/types.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"

namespace c40 {
class Chip;
}
namespace pci {
class Bus;
struct Attempt;
struct BusStatistics;
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

struct ChipFault;
struct Config;
class HostProgram;
class Net;
class Observer;
struct ScriptedEvent;
class SlotWire;

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
  /// Calls `tell` for each attempt that is on a bus now, as far as it has come.
  void each_attempt_under_way(const BusWatch& tell) const;
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
