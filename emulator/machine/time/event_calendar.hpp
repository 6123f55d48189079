#pragma once
// The calendar of events: the instant of each actor's next event, and the earliest of them.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

#include "machine/time/time.hpp"

namespace machine {

/// A tree in which each node is the earlier of its two children. At one instant the lower number is the earlier.
class EventCalendar {
 public:
  struct Turn {
    Time time = never;
    std::size_t who = 0;
  };

  /// Adds an actor; its event is set afterwards.
  std::size_t add() {
    const std::size_t who = count_++;
    if (count_ > leaves_) {
      const std::vector<Turn> before(leaf(0), leaf(leaves_));
      leaves_ = std::bit_ceil(count_);
      nodes_.resize(2 * leaves_);
      std::copy(before.begin(), before.end(), leaf(0));
      for (std::size_t i = before.size(); i < leaves_; ++i) *leaf(i) = {never, i};
      for (std::size_t i = leaves_ - 1; i > 0; --i) nodes_[i] = earlier_child(i);
    }
    return who;
  }

  void set(std::size_t who, Time time) {
    if (leaf(who)->time == time) return;
    leaf(who)->time = time;
    for (std::size_t i = (leaves_ + who) / 2; i > 0; i /= 2) {
      const Turn& earlier = earlier_child(i);
      if (earlier.who == nodes_[i].who && earlier.time == nodes_[i].time) return;  // nothing has changed further up
      nodes_[i] = earlier;
    }
  }

  /// The same for an actor that has just acted. It was the earliest, so all nodes above it change: none is looked at
  /// before.
  void set_after_turn(std::size_t who, Time time) {
    leaf(who)->time = time;
    for (std::size_t i = (leaves_ + who) / 2; i > 0; i /= 2) nodes_[i] = earlier_child(i);
  }

  Time time(std::size_t who) const { return nodes_[leaves_ + who].time; }
  const Turn& earliest() const { return nodes_[1]; }
  /// The earliest event of all actors other than `who`.
  Time earliest_of_others(std::size_t who) const {
    Time earliest = never;
    for (std::size_t i = leaves_ + who; i > 1; i /= 2) earliest = std::min(earliest, nodes_[i ^ 1U].time);
    return earliest;
  }

 private:
  // Node i has the children 2i and 2i + 1; the leaves, which are the actors, come after the last inner node.
  std::vector<Turn>::iterator leaf(std::size_t who) {
    return nodes_.begin() + static_cast<std::ptrdiff_t>(leaves_ + who);
  }
  const Turn& earlier_child(std::size_t node) const {
    const Turn *const left = &nodes_[2 * node], *const right = left + 1;
    return right->time < left->time ? *right : *left;
  }

  std::size_t count_ = 0, leaves_ = 1;
  std::vector<Turn> nodes_{2};
};

}  // namespace machine
