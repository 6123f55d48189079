#pragma once
/// The engine as the DMA coprocessor sees it.
#include <vector>

#include "c40/engine.hpp"

namespace c40 {

/// What one access at a time, or two, can use.
enum class Unit : std::uint8_t { ram0, ram1, rom, local, global, peripheral, none };
inline constexpr std::size_t unit_count = 7;
Unit unit_of(const Access& access);

/// A data access of the processor that the DMA has not passed yet.
struct ProcessorAccess {
  Access access;
  Cycles begin = 0, end = 0;
};

struct Engine::DmaSide final : DmaSurroundings {
  explicit DmaSide(Engine& owner) : engine(owner) {}

  DmaPlace place(Address address, bool write) override;
  Word read(Address address, Cycles at) override;
  void write(Address address, Word value, Cycles at) override;
  bool port_ready(Address address, bool write) const override;
  std::optional<bool> level(int channel, bool write, Word code) const override;
  Word dma_interrupt_enable() const override;
  std::optional<Span> acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) override;
  void block_ended(int channel, bool auxiliary, bool interrupt, Cycles at) override;

  /// What the processor does with a unit in a cycle.
  struct Use {
    bool data = false, fetch = false;  ///< an access that begins there would find no room beside the DMA's
    Cycles busy_until = 0;             ///< of an access that began before; or the cycle itself
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

  void know_accesses();
  void begin_following(bool beside_processor);
  void end_following();
  void expect_fetches();
  void mark_under_way();
  void forget();
  void list_state(state::Visitor& list);

  Engine& engine;
  std::optional<DmaRequest> request;  ///< reported and not answered
  std::optional<StopInfo> stop;       ///< to be reported after the instruction
  std::vector<ProcessorAccess> accesses;
  bool knows_accesses = false;  ///< of the instructions that are through; else only when they leave the buses
  static constexpr Cycles long_ago = -1000;
  std::array<Cycles, unit_count> taken_until{}, written{};  ///< by the DMA: until when
  Cycles last_taken = long_ago;
  bool touched_link = false;

  // While the DMA follows the processor.
  bool beside = false;  ///< the processor goes on: it fetches, and what the DMA takes is not there for its next instructions
  bool disturbed = false;
  Pipeline pipeline;  ///< with what the DMA has taken
  struct Fetch {
    Unit unit = Unit::none;
    Cycles begin = 0, end = 0;
  };
  std::array<std::optional<Access>, 2> next_fetches{};  ///< of the next two instructions, as far as they are fetched from memory
  std::array<Fetch, 2> fetches{};
  /// The pipeline as it would stand if the DMA had taken nothing: what the DMA costs an instruction is the difference.
  std::optional<PipelineId> undisturbed;
  Cycles gained = 0;  ///< cycles that instructions took less because of what the DMA had cost others before
};

}  // namespace c40
