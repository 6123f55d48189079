#include "c40/pipeline/pipeline_table.hpp"

namespace c40 {
namespace {

constexpr PipelineId most_states = 1 << 18;
constexpr int first_transition_bits = 6, more_transition_bits = 3, most_transition_bits = 12;

std::optional<Cause> only_delay(const StepTiming& timing) {
  std::optional<Cause> found;
  for (std::size_t i = 0; i < pipeline_cause_count; ++i) {
    const auto cause = static_cast<Cause>(i);
    if (cause == Cause::execute || timing.of(cause) == 0) continue;
    if (found) return {};
    found = cause;
  }
  return found;
}

}  // namespace

PipelineTable::PipelineTable() {
  make_transitions(first_transition_bits);
  intern(Pipeline{});
}

void PipelineTable::make_transitions(int bits) {
  transitions_.assign(std::size_t{1} << bits, {});
  hash_shift_ = 64 - bits;
}

PipelineId PipelineTable::intern(const Pipeline& pipeline) {
  auto& ids = ids_[pipeline.hash()];
  for (PipelineId id : ids)
    if (states_[id] == pipeline) return id;
  const auto id = static_cast<PipelineId>(states_.size());
  states_.push_back(pipeline);
  ids.push_back(id);
  full_ = id >= most_states;
  return id;
}

const Transition& PipelineTable::transition(PipelineId before, const Demand& demand, std::uint64_t bits, Word word) {
  const std::uint64_t hash = (bits ^ std::uint64_t{before} << 40 ^ std::uint64_t{word} << 17) * 0x9E3779B97F4A7C15u;
  Transition& entry = transitions_[hash >> hash_shift_];
  if (entry.demand != bits || entry.before != before || entry.word != word) {
    if (states_.size() * 2 > transitions_.size() && hash_shift_ > 64 - most_transition_bits) {
      make_transitions(64 - hash_shift_ + more_transition_bits);
      return transition(before, demand, bits, word);
    }
    entry = {bits, before, word, {}, 0, {}};
    Pipeline pipeline = states_[before];
    entry.timing = pipeline.advance(demand);
    entry.after = intern(pipeline);
    entry.delayed_by = only_delay(entry.timing);
  }
  return entry;
}

PipelineId PipelineTable::flushed(PipelineId before, Cycles cycles) {
  if (cycles >= Pipeline::furthest) return drained;
  Flush& entry = flushes_[(before * std::size_t{31} + static_cast<std::size_t>(cycles)) % flushes_.size()];
  if (entry.before != before || entry.cycles != cycles) {
    Pipeline pipeline = states_[before];
    pipeline.flush(static_cast<int>(cycles));
    entry = {before, cycles, intern(pipeline)};
  }
  return entry.after;
}

void PipelineTable::clear() {
  states_.clear();
  ids_.clear();
  full_ = false;
  flushes_ = {};
  transitions_.assign(transitions_.size(), {});
  intern(Pipeline{});
}

}  // namespace c40
