#pragma once
// The guard of the shared-memory board: a DSP may write only what the task that it has claimed may write.
//
// The guard watches the claims on the bus. The owner of the list's semaphore may write the pool of blocks and the work
// pointer. A write of 0Fh into a block's flag binds the DSP to that block, until it writes FFh there or is reset. A
// bound DSP may write result, notify, heartbeat and flag of its block, the area that TB_AREA names, what a split task
// of that robot keeps, and (error task) the log.
//
// Inaccuracies: reads are not checked, nor are writes to devices (a write posted on bus B may arrive when its task has
// already ended on bus A). A task that takes the list's semaphore for itself can destroy the list until the host
// releases the semaphore.
#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "machine/system/bus_topology.hpp"
#include "state/visitor.hpp"

namespace toolchain {
struct Image;
}

namespace machine {

class Guard {
 public:
  /// The constants come from the program.
  Guard(const toolchain::Image& program, const std::vector<Word>& shared);

  /// Whether a DSP may do this write to shared memory. \param holds_list it owns the list's semaphore
  bool admits(unsigned slot, Offset offset, Word value, bool holds_list);
  /// If the write that has just been reported was refused: the kind of the task, or `no_task`.
  std::optional<Word> take_refusal(unsigned slot, Offset offset, Word value) {
    if (refusals_.empty()) return std::nullopt;
    return find_refusal(slot, offset, value);
  }
  /// The DSP was reset or pulled out.
  void forget(unsigned slot) { bound_.at(slot).reset(); }
  void list_state(state::Visitor& list) {
    list("bound", bound_);
    list("refusals", refusals_);
  }
  Word list_semaphore() const { return list_semaphore_; }

  static constexpr Word no_task = 0xFFFFFFFF;

 private:
  struct Region {
    Offset first = 0, words = 0;
    bool holds(Offset offset) const { return offset - first < words; }
  };
  struct Refusal {
    unsigned slot;
    Offset offset;
    Word value, kind;
  };
  bool refuse(unsigned slot, Offset offset, Word value);
  std::optional<Word> find_refusal(unsigned slot, Offset offset, Word value);
  Word kind(unsigned slot) const { return bound_.at(slot) ? shared_[*bound_[slot] + tb_kind_] : no_task; }
  bool in_area(Offset area, Offset offset) const;

  const std::vector<Word>& shared_;
  Region pool_, log_, kept_;
  std::array<Region, 3> areas_;  // words of one area: of the crane, of each AGV, of each user's task
  Offset work_pointer_, tb_flag_, tb_kind_, tb_area_, tb_result_, tb_notify_, tb_alive_, block_words_, kept_words_;
  Word flag_taken_, flag_done_, kind_error_, list_semaphore_;
  std::array<std::optional<Offset>, most_slots> bound_{};  // offset of the block
  std::deque<Refusal> refusals_;
};

}  // namespace machine
