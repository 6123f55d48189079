#pragma once
/// Snapshots of a run, from which any instant can be reached again. Common parts of snapshots are stored once.
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "machine/time/time.hpp"

namespace machine::debug {

struct HistoryLimits {
  Time period =
      std::chrono::milliseconds{500};  ///< between two snapshots; longer if these would cost much of the run's time
  std::size_t bytes = std::size_t{512} << 20;  ///< with more bytes, snapshots are thinned out, old ones more
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
    std::size_t changes = 0;  ///< number of changes by hand before it
  };
  /// A snapshot is due at `now`.
  bool due(Time now) const;
  /// \param took the host time of making the state
  void add(Place place, std::string_view state, std::chrono::nanoseconds took);
  /// An additional snapshot for steps back from a nearby instant; it replaces the one before.
  void add_near(Place place, std::string state);
  /// The last snapshot at or before an instant; none before the first.
  std::optional<Place> before(Time time) const;
  std::string state_before(Time time) const;
  /// Removes all later snapshots.
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
