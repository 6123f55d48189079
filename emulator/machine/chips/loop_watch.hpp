#pragma once
/// Finds out whether a chip executes a loop that it cannot leave by itself.
///
/// It cannot if the same instructions have, twice in a row, read the same words, written the same words and changed the
/// same registers: the second pass left the same state as the first, so the next pass will do the same, until something
/// outside changes what the loop reads. A loop that takes words from a FIFO, puts words into one, or writes a register
/// of a peripheral does not count.
#include <optional>
#include <set>
#include <vector>

#include "c40/chip/chip.hpp"

namespace state {
class Visitor;
}

namespace machine {

class LoopWatch final : public c40::TraceSink {
 public:
  /// \param next gets the same calls
  LoopWatch(const c40::Chip& chip, c40::TraceSink* next) : chip_(&chip), next_(next) {}
  void instruction(const c40::TraceRecord& record) override;
  void interrupt(const c40::InterruptRecord& record) override;

  struct Loop {
    c40::Address pc = 0;           ///< the lowest address of its instructions
    std::set<c40::Address> reads;  ///< addresses of data
  };
  /// The loop that the last instructions have executed at least twice.
  std::optional<Loop> loop() const;
  void list_state(state::Visitor& list);

 private:
  struct Round {
    std::uint64_t hash = 0;
    c40::Address pc = 0;
    std::vector<c40::Address> reads;
    bool has_effect = false;  ///< other than on registers and memory
  };
  const c40::Chip* chip_;
  c40::TraceSink* next_;
  std::vector<Round> rounds_;
};

}  // namespace machine
