#pragma once
/// Where the DMA coprocessor and the processor compete: memory ports, buses, ports, windows.
///
/// The processor is ahead by the read stage of its next instruction: after each instruction of the processor, the DMA
/// advances to this stage. Up to there all data accesses are known, and the pipeline gives the next two fetches. Each
/// cycle that the DMA uses is marked in the pipeline model, so that later fetches and accesses fit around it. A fetch
/// with slack costs nothing. A data access that the DMA displaces moves together with everything after it.
#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/chip/state.hpp"
#include "c40/memory/instruction_cache.hpp"
#include "c40/memory/memory.hpp"
#include "c40/observers/probe.hpp"
#include "c40/peripherals/peripherals.hpp"
#include "c40/peripherals/ports.hpp"
#include "c40/pipeline/pipeline_table.hpp"

namespace c40 {

/// How far the DMA is behind the processor: the read stage of the next instruction is one cycle before its execute
/// stage.
inline constexpr Cycles read_lead = 1;

/// A resource that one access, or two, can use at a time.
enum class Unit : std::uint8_t { ram0, ram1, rom, local, global, peripheral, none };
inline constexpr std::size_t unit_count = 7;

/// A data access of the processor in a cycle that the DMA has not reached yet.
struct ProcessorAccess {
  Access access;
  Cycles begin = 0, end = 0;
};

/// How the DMA affects the instruction in execution.
enum class DmaEffect : std::uint8_t {
  none,
  still_felt,  ///< the DMA is at rest, but the cycles that it used still count
  under_way    ///< a channel continues meanwhile
};

/// The chip as seen by the DMA coprocessor. Marks the cycles that the DMA uses in the pipeline, and charges the
/// processor with their cost.
class DmaSide final : public DmaContext {
 public:
  /// The parts of the chip that the DMA needs.
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
  void started(int channel, Word control, Cycles at) override;

  // ---- around an instruction of the processor ----

  /// The effect on the next instruction. `busy`: Peripherals::dma_busy().
  DmaEffect effect(bool busy) const {
    if (busy) return DmaEffect::under_way;
    return undisturbed_ ? DmaEffect::still_felt : DmaEffect::none;
  }
  /// From now on accesses of the processor are noted, or not.
  void know_accesses();
  void know_no_accesses() { knows_accesses_ = false; }
  /// Notes the resources used by the completed instruction that began in cycle `before`.
  void note_accesses(const Demand& demand, const StepTiming& timing, Cycles before);
  /// The timing that the completed instruction would have had without the DMA, if that can differ.
  std::optional<StepTiming> without_dma(const Demand& demand);
  /// An instruction took `held` cycles longer because of the DMA.
  void charge(Cycles held);
  /// An instruction took fewer cycles because of an earlier delay: deducted from the next cost.
  void gain(Cycles cycles) { gained_ += cycles; }
  /// After cycles in which the processor was stopped: the DMA continues what it has begun.
  void mark_under_way();
  /// The pipeline was flushed for so many cycles.
  void flushed(Cycles cycles);
  /// The pipeline was replaced: its state without the DMA is unknown.
  void forget_undisturbed() { undisturbed_.reset(); }

  // ---- while the DMA runs ----

  /// \param beside_processor the processor continues as well
  void begin_following(bool beside_processor);
  void end_following();
  /// Reports an access of a channel in cycle `at` to the probe.
  void tell_probe(int channel, Address address, Word before, Word value, bool write, Cycles at);
  /// Whether the DMA has accessed a linked port since the last call.
  bool take_touched_link() { return std::exchange(touched_link_, false); }

  std::optional<DmaRequest> request;  ///< reported and not answered
  std::optional<StopInfo> stop;       ///< to be reported after the instruction

  /// The chip is held for so many cycles from cycle `from` on: what is under way ends later.
  void stand_still(Cycles from, Cycles cycles);
  void reset();
  void list_state(state::Visitor& list);

 private:
  /// The processor's use of a resource in a cycle.
  struct Use {
    bool data = false, fetch = false;  ///< an access that begins in this cycle would find no room beside the DMA's
    Cycles busy_until = 0;             ///< end of an access that began before; or the cycle itself
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
  bool knows_accesses_ =
      false;  ///< accesses of completed instructions are known; else only when they release the buses
  std::array<Cycles, unit_count> taken_until_{},
      written_{};  ///< until when the DMA uses, and has written, each resource
  Cycles last_taken_ = long_ago;
  bool touched_link_ = false;
  /// The pipeline as it would be without the DMA. The difference is what the DMA costs an instruction.
  std::optional<PipelineId> undisturbed_;
  Cycles gained_ = 0;  ///< cycles that instructions took less because of the DMA's earlier cost

  // From begin_following() to end_following().
  bool beside_ = false;  ///< the processor continues: it fetches, and the cycles that the DMA uses are not free for its
                         ///< next instructions
  bool disturbed_ = false;
  Pipeline pipeline_;                                    ///< with the DMA's cycles
  std::array<std::optional<Access>, 2> next_fetches_{};  ///< the next two instructions' fetches from memory
  std::array<Fetch, 2> fetches_{};
};

}  // namespace c40
