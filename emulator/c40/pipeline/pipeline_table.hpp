#pragma once
/// Numbered states of the pipeline, and for each the remembered results of the pipeline model. The model costs some
/// hundred host instructions, and the same few transitions come again and again.
#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "c40/pipeline/timing.hpp"

namespace c40 {

using PipelineId = std::uint32_t;

/// A demand without its footprint, in one number.
constexpr std::uint64_t packed(const Access& access) {
  return static_cast<std::uint64_t>(access.resource) | std::uint64_t{access.write} << 3 |
         std::uint64_t{access.strobe1} << 4 | std::uint64_t{access.waits} << 5;
}
constexpr std::uint64_t packed_data(const Demand& demand) {
  std::uint64_t bits = std::uint64_t{demand.count} << 12;
  for (std::size_t i = 0; i < demand.count; ++i) bits |= packed(demand.data[i]) << (17 + 10 * i);
  return bits;
}
constexpr std::uint64_t packed_fetch(const Access& fetch, bool fetched, bool missed) {
  return packed(fetch) | std::uint64_t{fetched} << 10 | std::uint64_t{missed} << 11;
}
constexpr std::uint64_t packed_flush(int cost) { return static_cast<std::uint64_t>(cost) << 14; }
constexpr std::uint64_t packed(const Demand& demand) {
  return packed_fetch(demand.fetch, demand.fetched, demand.fetch_missed) | packed_flush(demand.flush_cost) |
         packed_data(demand);
}

/// The pipeline model's result for an instruction in a state of the pipeline. It depends on nothing else.
struct Transition {
  std::uint64_t demand = ~std::uint64_t{0};  ///< packed, without the footprint, which follows from the word
  PipelineId before = 0;
  Word word = 0;
  StepTiming timing;
  PipelineId after = 0;
  std::optional<Cause> delayed_by;  ///< the one cause of all cycles but the first, if there is one
};

/// The table of transitions begins small, so that a chip is made quickly, and grows with the number of states.
class PipelineTable {
 public:
  static constexpr PipelineId drained = 0;  ///< the empty pipeline

  PipelineTable();
  /// The number of a state, valid until clear().
  PipelineId intern(const Pipeline& pipeline);
  const Pipeline& operator[](PipelineId id) const { return states_[id]; }
  /// The transition of the instruction `word` with the demand `demand`; `bits` is the packed demand. The reference is
  /// valid until the next call.
  const Transition& transition(PipelineId before, const Demand& demand, std::uint64_t bits, Word word);
  /// The state after `cycles` without an instruction.
  PipelineId flushed(PipelineId before, Cycles cycles);
  /// There are so many states that clear() is needed to limit memory.
  bool full() const { return full_; }
  /// Drops all states; numbers start again.
  void clear();

 private:
  struct Flush {
    PipelineId before = 0;
    Cycles cycles = -1;
    PipelineId after = 0;
  };

  void make_transitions(int bits);

  std::deque<Pipeline> states_;
  std::unordered_map<std::uint64_t, std::vector<PipelineId>> ids_;  ///< by hash
  std::vector<Transition> transitions_;                             ///< direct mapped by the upper bits of a hash
  std::array<Flush, 64> flushes_{};                                 ///< the same, of `flushed`
  int hash_shift_ = 0;                                              ///< leaves as many of its bits as the table has
  bool full_ = false;
};

/// The pipeline state of one chip: its number if known, else `state`, which a caller may have changed.
class PipelineNow {
 public:
  PipelineNow(PipelineTable& table, Pipeline& state) : table_(table), state_(state) {}

  PipelineId id() {
    if (id_ == unknown) [[unlikely]]
      id_ = table_.intern(state_);
    return id_;
  }
  const Pipeline& get() { return table_[id()]; }
  bool is(PipelineId id) const { return id_ == id; }
  void set(PipelineId id) { id_ = id; }
  /// `cycles` pass without an instruction.
  void flush(Cycles cycles) { id_ = table_.flushed(id(), cycles); }
  /// Brings `state` up to date.
  void settle() {
    if (id_ != unknown) state_ = table_[id_];
  }
  /// The same; afterwards the caller may change `state`.
  Pipeline& release() {
    settle();
    id_ = unknown;
    return state_;
  }
  /// From now on only `state` counts.
  void forget() { id_ = unknown; }

 private:
  static constexpr PipelineId unknown = std::numeric_limits<PipelineId>::max();
  PipelineTable& table_;
  Pipeline& state_;
  PipelineId id_ = unknown;
};

}  // namespace c40
