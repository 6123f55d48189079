#pragma once
// The times of a repeated event, in limited memory.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "machine/time/time.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

using machine::Time;

/// While there are few instants, each is kept exactly. Later they are counted in bins of equal length, which doubles as
/// the run grows.
class EventTimes {
 public:
  explicit EventTimes(std::size_t kept_max = 1 << 18, std::size_t bins_max = 1 << 19)
      : kept_max_(kept_max), bins_max_(bins_max) {}

  /// In any order. \param time not negative
  void add(Time time);

  std::uint64_t count() const { return count_; }
  /// Number of instants not after `end`; if `end` lies within a bin, the same share of the bin's count.
  std::uint64_t until(Time end) const;
  /// Length of a bin; 0: each instant is exact.
  Time bin() const { return bin_; }

  /// A number of instants at `time`: within bin() after it, those of one bin.
  struct Group {
    Time time;
    std::uint64_t count;
  };
  /// In the order of time.
  std::vector<Group> in_order() const;

  void list_state(state::Visitor& list);

 private:
  void count_in_bin(Time time);

  std::size_t kept_max_, bins_max_;
  std::uint64_t count_ = 0;
  Time last_{};  // the latest of all instants
  Time bin_{};
  std::vector<Time> kept_;
  std::vector<std::uint32_t> bins_;
};

}  // namespace cmrc
