#pragma once
// Which DSPs give a sign of life (idle policy "doorbell" only: a DSP that polls the list gives none).
//
// Time is counted in refreshes that the host has made: while it is away nobody can show it a sign.
//
// A sign is a set bit in the mask of idle DSPs, or being the owner of a block that is taken or was just found done. A
// slot that has given none for `limit` refreshes is looked for among the owners; one that is not there either is
// silent, and is reset. If it is silent for as long again it is taken for dead, until its idle bit is seen: a board
// that was put in.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace state {
class Visitor;
}

namespace cmrc {

class Liveness {
 public:
  enum class Verdict : std::uint8_t { silent, dead };

  void sign(unsigned slot, std::int64_t refresh);
  void signs(std::uint32_t mask, std::int64_t refresh);
  /// The host has reset it for another reason: it has time to come back.
  void renewed(unsigned slot, std::int64_t refresh);
  /// Some slot has been quiet for so long that the owners of the taken blocks have to be read.
  bool doubtful(std::int64_t refresh, std::int64_t limit) const;
  /// After they were: what is to be done with whom.
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
  std::array<Slot, 32> slots_{};
};

}  // namespace cmrc
