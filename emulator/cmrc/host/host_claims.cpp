// The host and the claims of the DSPs: finds the claimed blocks, and chooses the DSP to ring for each waiting block.
#include <algorithm>
#include <bit>
#include <iterator>

#include "cmrc/host/host.hpp"

namespace cmrc {

using report::EventKind;

void Host::pointer_read(Word pointer) {
  claimed_before(pointer);
  if (!look_past(Step::passed)) collect_taken();
}

void Host::collect_taken() {
  for (const std::size_t index : list_.order()) {
    if (list_[index].flag == Flag::taken) flags_.push_back(index);
  }
  if (flags_.empty())
    signs_.clear();
  else
    signs_ = flags_;
  next_flag();
}

void Host::claimed_before(Word pointer) {
  const auto at_pointer = [&](std::size_t index) { return words_.block(index) == pointer; };
  const auto first = std::find_if(linked_.begin(), linked_.end(), at_pointer);
  if (first == linked_.end() && pointer != 0) {
    pointer_in_doubt_ = true;  // a DSP that runs wild has written here
    return;
  }
  std::for_each(linked_.begin(), first, [this](std::size_t index) {
    if (waits(index)) list_.take(index);
  });
  linked_.erase(linked_.begin(), first);
}

// DSPs pass over a block that is for another DSP alone, and claim one behind it (claim_own.asm); they stop at the first
// block that any DSP may claim. \returns false if no flag has to be read
bool Host::look_past(Step step) {
  passed_.clear();
  if (!own_linked_ || pointer_in_doubt_) return false;
  std::ranges::copy_if(linked_, std::back_inserter(passed_), [this](std::size_t index) { return waits(index); });
  if (passed_.empty()) return false;
  step_ = step;
  port_->read(words_.block(passed_.front()) + words_.flag, 1, 0);
  return true;
}

// \returns whether it was the last one
bool Host::passed_read(Word flag) {
  const std::size_t index = passed_.front();
  passed_.pop_front();
  if (flag != words_.flag_waiting)
    taken_at_last(index);
  else if (!own_slot(index))
    passed_.clear();
  if (passed_.empty()) return true;
  port_->read(words_.block(passed_.front()) + words_.flag, 1, 0);
  return false;
}

// Its flag says that the block is claimed, though it may be behind the work pointer, where DSPs follow its link.
void Host::taken_at_last(std::size_t index) {
  list_.take(index);
  list_.pass_through(index);
}

// The pointer may be wrong, but the block's flag has been read. If the host has taken the list from its holder, it has
// reset the holder just now, and nobody has claimed a block since.
void Host::taken_in_doubt(std::size_t index) {
  taken_at_last(index);
  list_[index].resets = holder_ ? resets_ - 1 : resets_;
}

// Chooses one idle DSP for each eligible block, by falling J: for a block for one DSP alone that DSP; for another block
// the lowest for which no block of its own waits, or else the lowest. So a DSP stays free for its own work if another
// one can do the blocks before it: a DSP that is rung later comes to the list later.
void Host::ring(Word idle) {
  liveness_.signs(idle, looks());
  Word wanted = 0;  // slots for which a block of their own waits
  for (const std::size_t index : linked_) {
    if (const auto own = own_slot(index); own && list_[index].importance > 0) wanted |= Word{1} << *own;
  }
  for (const std::size_t index : linked_) {
    if (list_[index].importance == 0) break;
    const auto own = own_slot(index);
    const Word free = (idle & ~wanted) != 0 ? idle & ~wanted : idle;
    const Word may = own ? idle & Word{1} << *own : free;
    if (may == 0) continue;
    const auto slot = static_cast<Word>(std::countr_zero(may));
    idle &= ~(Word{1} << slot);
    port_->write(words_.doorbell_ring, slot);
    note(EventKind::doorbell, {slot, 0, 0, 0, 0});
    ++counts_.doorbells;
  }
  end_refresh();
}

}  // namespace cmrc
