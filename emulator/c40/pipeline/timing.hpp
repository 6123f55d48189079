#pragma once
/// The pipeline model (c40-hardware.md 7.5): the cycles of each instruction in fetch, decode, read and execute, and the
/// causes of its delay. The model does not know what instructions do: it gets a description of each instruction in
/// program order. Time is computed only here: the exact engine calls the model per instruction, and a block's constants
/// are the model's results during the recording.
///
/// All times are relative to T, "the cycle in which the next instruction without conflicts would execute". T is the
/// chip's cycle count. A standard branch moves T by its whole cost, so its refill is charged to the branch itself.
///
/// Inaccuracies: stalls from outside (a shared bus) stop everything, posted writes included. A change of strobe between
/// a fetch and a data read costs nothing.
#include <array>
#include <cstdint>
#include <optional>

#include "c40/pipeline/cycle_set.hpp"
#include "c40/pipeline/pipeline_stages.hpp"
#include "c40/pipeline/timing_parameters.hpp"
#include "c40/values/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// The resource that an access uses. `ideal` never conflicts (board `flat`, hits of the instruction cache).
enum class Resource : std::uint8_t { ideal, ram0, ram1, rom, local, global, peripheral };

constexpr bool external(Resource r) { return r == Resource::local || r == Resource::global; }

struct Access {
  Resource resource = Resource::ideal;
  std::uint8_t waits = 0;
  bool write = false;
  bool strobe1 = false;  ///< if a change of strobe costs a cycle (STRB SWITCH): the access is on STRB1
  friend bool operator==(const Access&, const Access&) = default;
};

/// What an instruction does to the pipeline, wherever its operands are. Masks are by register code.
struct Footprint {
  std::uint32_t address_uses = 0;   ///< registers used in address generation (decode)
  std::uint32_t operand_reads = 0;  ///< address registers read as plain operands
  std::uint32_t late_writes = 0;    ///< address registers written in execute
  std::uint32_t early_writes = 0;   ///< address registers written in read (LDA)
};

/// One instruction as the model gets it: its footprint, its fetch, its data accesses.
struct Demand {
  Footprint footprint;
  Access fetch;
  bool fetched = true;        ///< false for the repetitions of RPTS
  bool fetch_missed = false;  ///< the instruction cache is on and does not have the word
  std::uint8_t count = 0;
  std::array<Access, 2> data{};
  int flush_cost = 0;  ///< cost of a standard branch in this direction; 0 for everything else
};

/// Cycles that one instruction added to T, in total and by cause; `start` is the beginning of each data access,
/// relative to the old T.
struct StepTiming {
  int total = 1;
  std::array<std::int16_t, pipeline_cause_count> causes{};  ///< their sum is `total`
  int of(Cause cause) const { return causes[static_cast<std::size_t>(cause)]; }
  std::array<int, 2> start{};
  PipelineStages stages;  ///< relative to the old T
  friend bool operator==(const StepTiming&, const StepTiming&) = default;
};

/// What still affects the next instructions, relative to T and normalised: equal futures have equal values.
class Pipeline {
 public:
  /// Cycles before T that can still matter, and the number of cycles from T on for which accesses can be known. Two
  /// reads of one bus with the most wait states, behind a write with as many, take 99 cycles from the earliest fetch of
  /// the next instruction to T.
  static constexpr int depth = CycleSet::before, furthest = CycleSet::from;
  /// Advances by one instruction.
  StepTiming advance(const Demand& demand);
  /// Empties the pipeline at T (reset, interrupt entry); bus writes under way continue.
  void flush(int cycles);
  /// The DMA uses a resource in the cycles [from, to), relative to T; later accesses fit around this.
  void take(Resource resource, int from, int to);
  /// An access of a completed instruction in [from, to), relative to T, is cancelled.
  void give_back(Resource resource, int from, int to);
  /// T advances by `cycles`, because an access of a completed instruction has to wait; what is over does not move.
  void hold(int cycles);
  /// An access of a completed instruction takes place in [from, to), relative to T, after such a wait.
  void make_again(const Access& access, int from, int to);
  /// The cycles [from, to), relative to T, of the fetches of the next two instructions, as far as completed
  /// instructions decide them; from == to: no fetch from this resource.
  struct Interval {
    int from = 0, to = 0;
  };
  std::array<Interval, 2> expected_fetches(const std::array<std::optional<Access>, 2>& fetches) const;
  /// The end of the data accesses of all completed instructions, relative to T; nothing if it was long ago.
  std::optional<int> busy_until(Resource resource) const;

  friend bool operator==(const Pipeline&, const Pipeline&) = default;
  std::uint64_t hash() const;
  void list_state(state::Visitor& list);
  /// For the next instruction, relative to T.
  int earliest_fetch() const { return fetch_ready_; }

 private:
  struct Bus {
    CycleSet busy;          ///< cycles used by data
    std::int8_t free = -1;  ///< first cycle after all data accesses
    std::int8_t write_end = -2;
    std::int8_t read_end = -2;
    bool read_strobe1 = false;  ///< of the read that ended then
    friend bool operator==(const Bus&, const Bus&) = default;
  };
  /// Accesses to a memory on the chip: 0 to 3 in each cycle, in two bits.
  struct Ports {
    std::array<CycleSet, 2> bits;
    int in(int cycle) const { return int{bits[0].has(cycle)} + 2 * int{bits[1].has(cycle)}; }
    void add(int cycle, int accesses);
    friend bool operator==(const Ports&, const Ports&) = default;
  };
  static constexpr std::size_t block_count = 3, bus_count = 3;  ///< RAM 0, RAM 1, ROM; local, global, peripheral
  static constexpr std::size_t address_register_count = 13;     ///< AR0 to AR7, DP, IR0, IR1, BK, SP

  int port_use(std::size_t block, int cycle) const;
  void mark(Resource resource, int from, int to, int change);
  int place_fetch(const Access& fetch, int from) const;
  int decode_at(const Footprint& footprint, int from) const;
  void settle(int shift, int fetch_ready, int read_entered);

  struct Placed;
  void place_reads(const Demand& demand, Placed& at, StepTiming& out) const;
  int place_on_bus(const Access& read, Placed& at) const;
  void place_writes(const Demand& demand, Placed& at, StepTiming& out) const;
  static void charge(const Demand& demand, const Placed& at, StepTiming& out);
  void move_readiness(const Footprint& footprint, const Placed& at);
  void forget_before(int cycle);
  void move_on(const Demand& demand, const Placed& at);

  std::int8_t fetch_ready_ = -3;   ///< earliest fetch of the next instruction
  std::int8_t read_entered_ = -2;  ///< the cycle in which the last instruction left decode
  std::uint32_t waited_for_ = 0;   ///< address registers for which the next instruction may wait in decode
  std::array<std::int8_t, address_register_count> ready_{};  ///< the first cycle in which it can use each of them
  std::array<Ports, block_count> ports_{};
  std::array<Bus, bus_count> buses_{};
};

}  // namespace c40
