#pragma once
/// Snapshots of a run, from which any instant is reached again. What two snapshots have in common is kept once.
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "machine/time.hpp"

namespace machine::debug {

struct HistoryLimits {
  Time period =
      std::chrono::milliseconds{500};  ///< between two snapshots, or more where these would cost much of the run's time
  std::size_t bytes = std::size_t{512} << 20;  ///< beyond it snapshots are thinned out, the older the more
};

struct HistoryInfo {
  std::size_t snapshots = 0, bytes = 0;
  Time first{}, last{};
};

class History {
 public:
  explicit History(HistoryLimits limits) : limits_(limits) {}

  struct Place {
    Time time{};
    std::size_t changes = 0;  ///< by hand, that had been made
  };
  /// A snapshot is due at `now`.
  bool due(Time now) const;
  /// \param took host time that making the state took
  void add(Place place, std::string_view state, std::chrono::nanoseconds took);
  /// One beside the others, for steps back from near there; it takes the place of the one before.
  void add_near(Place place, std::string state);
  /// The last one at or before an instant; none before the first.
  std::optional<Place> before(Time time) const;
  std::string state_before(Time time) const;
  /// What is later is gone.
  void forget_after(Time time);
  HistoryInfo info() const;

 private:
  using Chunk = std::shared_ptr<const std::string>;
  struct Snapshot {
    Place place;
    std::vector<Chunk> chunks;
  };
  Chunk kept(std::string_view text);
  const Snapshot* find(Time time) const;
  std::size_t bytes() const;
  void thin_out();

  HistoryLimits limits_;
  std::vector<Snapshot> snapshots_;  ///< by time
  std::optional<std::pair<Place, std::string>> near_;
  std::unordered_multimap<std::size_t, std::weak_ptr<const std::string>> chunks_;  ///< by hash
  std::chrono::steady_clock::time_point last_made_{};
  std::chrono::nanoseconds cost_{0};
};

}  // namespace machine::debug
