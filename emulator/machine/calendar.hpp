#pragma once
// Who is next: the instant of each actor's next event, and the earliest of them.
#include <bit>
#include <cstddef>
#include <vector>

#include "machine/time.hpp"

namespace machine {

/// A tree in which each node is the earlier of its two children. At one instant the lower number is the earlier.
class Calendar {
 public:
  struct Turn {
    Time time = never;
    std::size_t who = 0;
  };

  /// A place for one more actor; its event is set afterwards.
  std::size_t add() {
    const std::size_t who = count_++;
    if (count_ > times_.size()) {
      times_.resize(std::bit_ceil(count_), never);
      earlier_.resize(times_.size());
      for (std::size_t i = times_.size() - 1; i > 0; --i) earlier_[i] = earlier_of(2 * i, 2 * i + 1);
    }
    return who;
  }

  void set(std::size_t who, Time time) {
    if (times_[who] == time) return;
    times_[who] = time;
    for (std::size_t i = (who + times_.size()) / 2; i > 0; i /= 2) {
      const std::size_t earlier = earlier_of(2 * i, 2 * i + 1);
      if (earlier == earlier_[i] && earlier != who) return;  // above, nothing has changed
      earlier_[i] = earlier;
    }
  }

  Time time(std::size_t who) const { return times_[who]; }
  Turn earliest() const {
    const std::size_t who = times_.size() > 1 ? earlier_[1] : 0;
    return {times_[who], who};
  }

 private:
  // Node i has the children 2i and 2i + 1; the leaves, which are the actors, stand behind the last inner node.
  std::size_t first_of(std::size_t node) const { return node < times_.size() ? earlier_[node] : node - times_.size(); }
  std::size_t earlier_of(std::size_t left, std::size_t right) const {
    const std::size_t a = first_of(left), b = first_of(right);
    return times_[b] < times_[a] ? b : a;
  }

  std::size_t count_ = 0;
  std::vector<Time> times_{never};
  std::vector<std::size_t> earlier_{0};
};

}  // namespace machine
