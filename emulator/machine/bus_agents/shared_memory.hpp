#pragma once
// The shared-memory board on bus A: 64 K words of SRAM, semaphores, the doorbell unit, fence and reset registers
// (c40_programs/include/task_block.inc).
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "bus_model/bus.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/symbols.hpp"
#include "state/visitor.hpp"

namespace machine {

/// The DSPs that may write; one register for both buses.
struct Fence {
  Word mask = ~Word{0};
  bool closed(unsigned slot) const { return (mask >> slot & 1) == 0; }
};

/// The effects of the registers on the outside.
class DoorbellClient {
 public:
  virtual ~DoorbellClient() = default;
  virtual void ring(unsigned slot, pci::Clocks clock) = 0;
  virtual void reset_slot(unsigned slot, pci::Clocks clock) = 0;
  virtual void semaphore_event(unsigned number, SemaphoreEvent event, unsigned owner, pci::Clocks clock) = 0;
};

/// Agents as the buses' transactions carry them: 0 is the host, n + 1 is DSP slot n.
constexpr bool is_host(unsigned agent) { return agent == 0; }

class Guard;
class SharedRegisters;

class SharedSram final : public pci::Target {
 public:
  static constexpr Offset size = 0x10000;
  explicit SharedSram(const Fence& fence) : fence_{fence}, words_(size) {}
  bool takes_all() const override { return true; }
  Word read(pci::Address offset, const pci::Access& access) override {
    if (watch_) [[unlikely]]
      watch_(offset, words_[offset], words_[offset], false, access);
    return words_[offset];
  }
  void read_burst(pci::Address offset, std::span<Word> words, pci::Access access, pci::Clocks step) override {
    if (watch_) [[unlikely]]
      return pci::Target::read_burst(offset, words, access, step);
    std::copy_n(words_.begin() + static_cast<std::ptrdiff_t>(offset), words.size(), words.begin());
  }
  void write(pci::Address offset, Word value, const pci::Access& access) override;
  void set_guard(Guard& guard, const SharedRegisters& registers) { guard_ = &guard, registers_ = &registers; }
  /// Called for every access by a bus, before it; an empty function: none. Changes nothing.
  using Watch = std::function<void(Offset, Word before, Word value, bool write, const pci::Access&)>;
  void set_watch(Watch watch) { watch_ = std::move(watch); }
  std::vector<Word>& words() { return words_; }
  const std::vector<Word>& words() const { return words_; }

 private:
  // Not inlined: a word of the host needs neither, and is stored without a frame.
  [[gnu::noinline]] void write_of_dsp(pci::Address offset, Word value, const pci::Access& access);
  [[gnu::noinline]] void store_watched(Offset offset, Word value, const pci::Access& access);
  void store(Offset offset, Word value, const pci::Access& access) {
    if (watch_) [[unlikely]]
      return store_watched(offset, value, access);
    words_[offset] = value;
  }

  const Fence& fence_;
  Guard* guard_ = nullptr;
  const SharedRegisters* registers_ = nullptr;
  Watch watch_;
  std::vector<Word> words_;
};

/// Offsets here and in the .inc file count from bus address 0; the window starts at `base`.
class SharedRegisters final : public pci::Target {
 public:
  static constexpr Offset base = SharedSram::size;
  static constexpr Offset size = 0x1000;

  SharedRegisters(const Symbols& symbols, unsigned slots, Clock bus_clock, Fence& fence, DoorbellClient& client);

  /// Whether there is a register for this access. Only the host may ring doorbells, fence and reset.
  bool answers(Offset offset, bool write, bool by_host) const;
  /// A write to this offset acts on a DSP.
  bool acts_on_dsps(Offset offset) const { return offset == symbols_.doorbell_ring || offset == symbols_.reset_dsp; }
  /// Number of writes so far that acted on a DSP.
  std::uint64_t acted() const { return acted_; }
  /// The board of a slot is gone or starts again: it is not idle.
  void clear_idle(unsigned slot) { idle_ &= ~(Word{1} << slot); }
  /// 0: free; DSP slot + 1, or host_owner.
  unsigned holder(unsigned number) const { return semaphores_.at(number).owner; }
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list) {
    list("semaphores", semaphores_);
    list("idle", idle_);
    list("acted", acted_);
  }

  pci::Answer answer(pci::Address offset, unsigned words, bool write, const pci::Access& access) override;
  Word read(pci::Address offset, const pci::Access& access) override;
  void write(pci::Address offset, Word value, const pci::Access& access) override;

 private:
  struct Semaphore {
    std::uint8_t owner = 0;  // 0: free; slot + 1, host_owner
    pci::Clocks since = 0;
  };
  static constexpr std::size_t most_semaphores = 64;

  Word acquire(unsigned number, const pci::Access& access);
  void release(unsigned number, const pci::Access& access);
  Word microseconds_held(const Semaphore& semaphore, pci::Clocks now) const;

  const Symbols& symbols_;
  unsigned slots_;
  Clock clock_;
  Fence& fence_;
  DoorbellClient& client_;
  std::array<Semaphore, most_semaphores> semaphores_{};
  Word idle_ = 0;
  std::uint64_t acted_ = 0;
};

}  // namespace machine
