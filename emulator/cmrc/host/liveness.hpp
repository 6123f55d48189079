#pragma once
// Which DSPs show a sign of life (only with idle policy "doorbell": a DSP that polls the list shows none).
//
// Time is counted in refreshes of the host: while the host is paused, it can see no sign.
//
// A sign is a set bit in the mask of idle DSPs, or being the owner of a block that is claimed or was just found
// finished. A slot without a sign for `limit` refreshes is looked for among the owners; if it is not there either, it
// is silent, and is reset. If it is silent for the same time again, it counts as dead until its idle bit is seen: a new
// board was plugged in.
#include <array>
#include <cstdint>
#include <vector>

#include "machine/system/bus_topology.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

class Liveness {
 public:
  enum class Verdict : std::uint8_t { silent, dead };

  void sign(unsigned slot, std::int64_t refresh);
  void signs(std::uint32_t mask, std::int64_t refresh);
  /// The host has reset the DSP for another reason: it gets time to come back.
  void renewed(unsigned slot, std::int64_t refresh);
  /// A slot has been silent for so long that the owners of the claimed blocks have to be read.
  bool doubtful(std::int64_t refresh, std::int64_t limit) const;
  /// The result after the owners were read: what to do with which slot.
  struct Finding {
    unsigned slot;
    Verdict verdict;
  };
  std::vector<Finding> judge(std::int64_t refresh, std::int64_t limit);
  void list_state(state::Visitor& list);

 private:
  enum class State : std::uint8_t { unknown, alive, reset };
  struct Slot {
    State state = State::unknown;
    std::int64_t last = 0;
  };
  Slot& known(unsigned slot);

  std::array<Slot, machine::most_slots> slots_{};
  std::size_t known_ = 0;  // slots from this one on are unknown
};

}  // namespace cmrc
