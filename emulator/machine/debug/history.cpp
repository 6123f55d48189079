#include "machine/debug/history.hpp"

#include <algorithm>
#include <array>
#include <functional>

namespace machine::debug {
namespace {

constexpr std::size_t least_chunk = 4096, most_chunk = 65536;
constexpr std::uint64_t chunk_mask = 0x1FFF;  // on average one boundary in 8 K bytes

/// A number for each byte, for the rolling hash: splitmix64.
std::array<std::uint64_t, 256> gear_table() {
  std::array<std::uint64_t, 256> table{};
  std::uint64_t seed = 0;
  for (std::uint64_t& entry : table) {
    std::uint64_t z = seed += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    entry = z ^ z >> 31;
  }
  return table;
}

/// The length of the first chunk: it ends where the preceding bytes say so, independent of their place in the text. So
/// an insertion into a text changes only the chunks around it.
std::size_t chunk_length(std::string_view text) {
  static const std::array<std::uint64_t, 256> gear = gear_table();
  const std::size_t end = std::min(text.size(), most_chunk);
  std::uint64_t hash = 0;
  for (std::size_t i = least_chunk; i < end; ++i) {
    hash = (hash << 1) + gear[static_cast<std::uint8_t>(text[i])];
    if ((hash >> 40 & chunk_mask) == 0) return i + 1;
  }
  return end;
}

// Snapshots take at most one part in this number of the host's time.
constexpr int share_of_time = 32;

}  // namespace

bool History::due(Time now) const {
  if (snapshots_.empty()) return true;
  if (now - snapshots_.back().place.time < limits_.period) return false;
  return std::chrono::steady_clock::now() - last_made_ >= cost_ * share_of_time;
}

History::Chunk History::kept(std::string_view text) {
  const std::size_t hash = std::hash<std::string_view>{}(text);
  const auto [begin, end] = chunks_.equal_range(hash);
  for (auto at = begin; at != end; ++at)
    if (Chunk chunk = at->second.lock(); chunk && *chunk == text) return chunk;
  auto chunk = std::make_shared<const std::string>(text);
  chunks_.emplace(hash, chunk);
  return chunk;
}

void History::add(Place place, std::string_view state, std::chrono::nanoseconds took) {
  const auto begin = std::chrono::steady_clock::now();
  Snapshot snapshot{place, {}};
  while (!state.empty()) {
    const std::size_t length = chunk_length(state);
    snapshot.chunks.push_back(kept(state.substr(0, length)));
    state.remove_prefix(length);
  }
  snapshots_.push_back(std::move(snapshot));
  if (bytes() > limits_.bytes) thin_out();
  last_made_ = std::chrono::steady_clock::now();
  cost_ = took + (last_made_ - begin);
}

void History::add_near(Place place, std::string state) { near_.emplace(place, std::move(state)); }

const History::Snapshot* History::find(Time time) const {
  const auto after = std::ranges::upper_bound(snapshots_, time, {}, [](const Snapshot& s) { return s.place.time; });
  return after == snapshots_.begin() ? nullptr : &*std::prev(after);
}

std::optional<History::Place> History::before(Time time) const {
  const Snapshot* found = find(time);
  if (near_ && near_->first.time <= time && (found == nullptr || found->place.time <= near_->first.time))
    return near_->first;
  return found == nullptr ? std::nullopt : std::optional(found->place);
}

std::string History::state_before(Time time) const {
  const Snapshot* found = find(time);
  if (near_ && near_->first.time <= time && (found == nullptr || found->place.time <= near_->first.time))
    return near_->second;
  std::string text;
  for (const Chunk& chunk : found->chunks) text += *chunk;
  return text;
}

void History::forget_after(Time time) {
  std::erase_if(snapshots_, [&](const Snapshot& s) { return s.place.time > time; });
  if (near_ && near_->first.time > time) near_.reset();
}

std::size_t History::bytes() const {
  std::size_t sum = near_ ? near_->second.size() : 0;
  for (const auto& [hash, chunk] : chunks_)
    if (const auto alive = chunk.lock()) sum += alive->size();
  return sum;
}

// Removes the snapshot whose neighbours are closest together relative to their age, so gaps grow with age. The first
// and the last one stay.
void History::thin_out() {
  while (snapshots_.size() > 3 && bytes() > limits_.bytes) {
    const Time now = snapshots_.back().place.time;
    std::size_t least = 1;
    double smallest = 0;
    for (std::size_t i = 1; i + 2 < snapshots_.size(); ++i) {
      const auto gap = static_cast<double>((snapshots_[i + 1].place.time - snapshots_[i - 1].place.time).count());
      const auto age = static_cast<double>((now - snapshots_[i].place.time).count());
      if (i == 1 || gap / age < smallest) least = i, smallest = gap / age;
    }
    snapshots_.erase(snapshots_.begin() + static_cast<std::ptrdiff_t>(least));
    std::erase_if(chunks_, [](const auto& entry) { return entry.second.expired(); });
  }
}

HistoryInfo History::info() const {
  if (snapshots_.empty()) return {};
  return {snapshots_.size(), bytes(), snapshots_.front().place.time, snapshots_.back().place.time};
}

}  // namespace machine::debug
