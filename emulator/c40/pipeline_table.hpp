#pragma once
/// States of the pipeline by number, and what the pipeline model makes of an instruction in each, remembered: the model
/// costs some hundred host instructions, and the same few transitions come again and again.
#include <cstdint>
#include <deque>
#include <limits>
#include <unordered_map>
#include <vector>

#include "c40/timing.hpp"

namespace c40 {

using PipelineId = std::uint32_t;

/// All of a demand but the footprint, in one number.
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

/// What the pipeline model makes of an instruction in a state of the pipeline: it depends on nothing else.
struct Transition {
  std::uint64_t demand = ~std::uint64_t{0};  ///< packed, but for the footprint, which is the word's
  PipelineId before = 0;
  Word word = 0;
  StepTiming timing;
  PipelineId after = 0;
};

class PipelineTable {
 public:
  static constexpr PipelineId drained = 0;  ///< of an empty pipeline

  PipelineTable();
  /// The number of a state. It stays until clear().
  PipelineId intern(const Pipeline& pipeline);
  const Pipeline& operator[](PipelineId id) const { return states_[id]; }
  /// Of the instruction `word` with the demand `demand`, of which `bits` is the packed form. The reference holds until
  /// the next call.
  const Transition& transition(PipelineId before, const Demand& demand, std::uint64_t bits, Word word);
  /// So many states that memory asks for clear().
  bool full() const { return full_; }
  /// Numbers are given out anew.
  void clear();

 private:
  std::deque<Pipeline> states_;
  std::unordered_map<std::uint64_t, std::vector<PipelineId>> ids_;  ///< by hash
  std::vector<Transition> transitions_;                             ///< direct mapped
  bool full_ = false;
};

/// The state of the pipeline of one chip: by its number as long as that is known; else `state`, which somebody may have
/// changed.
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
  /// Brings `state` up to date.
  void settle() {
    if (id_ != unknown) state_ = table_[id_];
  }
  /// The same, and `state` may be changed after it.
  Pipeline& release() {
    settle();
    id_ = unknown;
    return state_;
  }
  /// Only `state` counts, whatever went before.
  void forget() { id_ = unknown; }

 private:
  static constexpr PipelineId unknown = std::numeric_limits<PipelineId>::max();
  PipelineTable& table_;
  Pipeline& state_;
  PipelineId id_ = unknown;
};

}  // namespace c40
