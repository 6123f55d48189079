#pragma once
/// The engine as the DMA coprocessor sees it.
#include <vector>

#include "c40/engine.hpp"

namespace c40 {

/// What one access at a time, or two, can use.
enum class Unit : std::uint8_t { ram0, ram1, rom, local, global, peripheral, none };
inline constexpr std::size_t unit_count = 7;
Unit unit_of(const Access& access);

/// An access of the processor that the DMA has not passed yet.
struct ProcessorAccess {
  Unit unit = Unit::none;
  bool write = false;
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

  Span take(Unit unit, const DmaPlace& place, Span span);
  Cycles under_way(Unit unit, Cycles at) const;
  Cycles written_until(Unit unit) const;
  int used_by_processor(Unit unit, Cycles begin, Cycles end) const;
  bool wins(Word priority, Cycles at);
  void stall_processor(Cycles at, Cycles cycles);
  Word touch_port(const PortAccess& access, Cycles at);

  void forget() {
    accesses.clear();
    fetch_unit = Unit::none;
    taken_until.fill(long_ago);
    written.fill(long_ago);
  }

  Engine& engine;
  std::vector<ProcessorAccess> accesses;
  Unit fetch_unit = Unit::none;  ///< of the processor's last fetch: the next is expected there too
  static constexpr Cycles long_ago = -1000;
  std::array<Cycles, unit_count> taken_until{}, written{};  ///< by the DMA: until when
  bool touched_link = false;
};

}  // namespace c40
