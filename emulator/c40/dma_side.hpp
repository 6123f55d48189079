#pragma once
/// Where the DMA coprocessor and the processor meet: memory ports, buses, ports, windows.
///
/// The processor is ahead by the read stage of its next instruction: after each of its instructions the DMA follows up
/// to there. In these cycles all data accesses are known, and the next two fetches can be told from the pipeline.
/// Whatever the DMA takes is marked in the pipeline model, so that later fetches and accesses fit around it: a fetch
/// that has slack costs nothing. A data access that the DMA displaces moves with everything after it.
#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "c40/chip.hpp"
#include "c40/instruction_cache.hpp"
#include "c40/memory.hpp"
#include "c40/peripherals.hpp"
#include "c40/pipeline_table.hpp"
#include "c40/ports.hpp"
#include "c40/probe.hpp"
#include "c40/state.hpp"

namespace c40 {

/// What one access at a time, or two, can use.
enum class Unit : std::uint8_t { ram0, ram1, rom, local, global, peripheral, none };
inline constexpr std::size_t unit_count = 7;

/// A data access of the processor that the DMA has not passed yet.
struct ProcessorAccess {
  Access access;
  Cycles begin = 0, end = 0;
};

/// What the DMA means for the instruction that is being executed.
enum class DmaEffect : std::uint8_t {
  none,
  still_felt,  ///< it is at rest, but what it took still counts
  under_way    ///< a channel goes on meanwhile
};

/// The chip as the DMA coprocessor works on it. Marks what it takes in the pipeline, and charges the processor with
/// what that costs.
class DmaSide final : public DmaContext {
 public:
  /// The parts of the chip that the DMA meets.
  struct Parts {
    State& state;
    Memory& memory;
    Ports& ports;
    Peripherals& peripherals;
    const InstructionCache& cache;
    PipelineTable& pipelines;
    PipelineNow& pipeline;
    Dma& dma;
    const PeripheralNotifier& tell;
    ProbePoint& probe;
    std::function<void(Address, Word)> poke;  ///< writes a word of memory, which may be code
  };
  explicit DmaSide(Parts parts) : chip_(std::move(parts)) {}

  DmaPlace place(Address address, bool write) override;
  Word read(Address address, Cycles at) override;
  void write(Address address, Word value, Cycles at) override;
  bool port_ready(Address address, bool write) const override;
  std::optional<bool> level(int channel, bool write, Word code) const override;
  Word dma_interrupt_enable() const override;
  std::optional<Span> acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) override;
  void block_ended(int channel, bool auxiliary, bool interrupt, Cycles at) override;

  // ---- around an instruction of the processor ----

  /// Of the instruction that comes next.
  DmaEffect effect() const {
    if (chip_.peripherals.dma_busy()) return DmaEffect::under_way;
    return undisturbed_ ? DmaEffect::still_felt : DmaEffect::none;
  }
  /// Its accesses will be noted from now on; or not.
  void know_accesses();
  void know_no_accesses() { knows_accesses_ = false; }
  /// What the instruction that was begun in cycle `before`, and is through, used.
  void note_accesses(const Demand& demand, const StepTiming& timing, Cycles before);
  /// What the instruction that is through would have taken if the DMA had been still, where that can differ.
  std::optional<StepTiming> without_dma(const Demand& demand);
  /// An instruction took `held` cycles longer because of the DMA.
  void charge(Cycles held);
  /// One took so many less, because it had been held up before: set against the next cost.
  void gain(Cycles cycles) { gained_ += cycles; }
  /// After cycles in which the processor stood still: what the DMA has begun goes on.
  void mark_under_way();
  /// The pipeline was flushed for so many cycles.
  void flushed(int cycles);
  /// The pipeline is another: nothing is known of how it would stand without the DMA.
  void forget_undisturbed() { undisturbed_.reset(); }

  // ---- while the DMA goes on ----

  /// \param beside_processor the processor goes on as well
  void begin_following(bool beside_processor);
  void end_following();
  /// Of an access of the DMA in cycle `at`.
  void tell_probe(Address address, Word before, Word value, bool write, Cycles at);
  /// Whether it has touched a linked port since this was last asked.
  bool take_touched_link() { return std::exchange(touched_link_, false); }

  std::optional<DmaRequest> request;  ///< reported and not answered
  std::optional<StopInfo> stop;       ///< to be reported after the instruction

  void reset();
  void list_state(state::Visitor& list);

 private:
  /// What the processor does with a unit in a cycle.
  struct Use {
    bool data = false, fetch = false;  ///< an access that begins there would find no room beside the DMA's
    Cycles busy_until = 0;             ///< of an access that began before; or the cycle itself
  };
  struct Fetch {
    Unit unit = Unit::none;
    Cycles begin = 0, end = 0;
  };
  Use use_by_processor(Unit unit, Cycles at) const;
  Span take(Unit unit, const DmaPlace& place, Span span);
  bool follows_write(Unit unit, Cycles at) const;
  bool processor_wrote_until(Unit unit, Cycles at) const;
  bool wins(Word priority, Cycles at);
  void lost_to_one_under_way(Cycles at, Cycles until);
  bool begins_within(Unit unit, Span span) const;
  void displace_data(Unit unit, Span span);
  Word touch_port(const PortAccess& access, Cycles at);
  std::array<std::optional<Access>, 2> fetches_from_memory() const;
  void expect_fetches();

  static constexpr Cycles long_ago = -1000;
  Parts chip_;
  std::vector<ProcessorAccess> accesses_;
  bool knows_accesses_ = false;  ///< of the instructions that are through; else only when they leave the buses
  std::array<Cycles, unit_count> taken_until_{}, written_{};  ///< by the DMA: until when
  Cycles last_taken_ = long_ago;
  bool touched_link_ = false;
  /// The pipeline as it would stand if the DMA had taken nothing: what the DMA costs an instruction is the difference.
  std::optional<PipelineId> undisturbed_;
  Cycles gained_ = 0;  ///< cycles that instructions took less because of what the DMA had cost others before

  // From begin_following() to end_following().
  bool beside_ =
      false;  ///< the processor goes on: it fetches, and what the DMA takes is not there for its next instructions
  bool disturbed_ = false;
  Pipeline pipeline_;  ///< with what the DMA has taken
  std::array<std::optional<Access>, 2>
      next_fetches_{};  ///< of the next two instructions, as far as they are fetched from memory
  std::array<Fetch, 2> fetches_{};
};

}  // namespace c40
