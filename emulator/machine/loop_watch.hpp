#pragma once
/// Whether a chip goes round a loop that it cannot leave by itself.
///
/// It can not if, twice in a row, the same instructions have read the same words, written the same and changed the same
/// registers: what the second round left is what the first one left, so the next will do the same, until something
/// outside changes what it reads. A loop that takes words from a FIFO, gives some to one, or writes to any register of
/// a peripheral is not taken for one.
#include <optional>
#include <set>
#include <vector>

#include "c40/chip.hpp"

namespace state {
class Visitor;
}

namespace machine {

class LoopWatch final : public c40::TraceSink {
 public:
  /// \param next hears what this one hears
  LoopWatch(const c40::Chip& chip, c40::TraceSink* next) : chip_(&chip), next_(next) {}
  void instruction(const c40::TraceRecord& record) override;
  void interrupt(c40::Word vector, c40::Cycles cycle) override;

  struct Loop {
    c40::Address pc = 0;           ///< the least address of its instructions
    std::set<c40::Address> reads;  ///< addresses of data
  };
  /// The loop that the last instructions have gone round at least twice.
  std::optional<Loop> loop() const;
  void list_state(state::Visitor& list);

 private:
  struct Round {
    std::uint64_t hash = 0;
    c40::Address pc = 0;
    std::vector<c40::Address> reads;
    bool has_effect = false;  ///< beyond registers and memory
  };
  const c40::Chip* chip_;
  c40::TraceSink* next_;
  std::vector<Round> rounds_;
};

}  // namespace machine
