#include "machine/boards/board_fifo.hpp"

namespace machine {

using c40::Address;
using c40::Cycles;
using c40::Word;

Word Fifo::status() const {
  return (in_.empty() ? 0u : has_word) | (out_.size() < depth_ ? has_room : 0u) |
         (in_.size() == depth_ ? in_full : 0u) | (out_.empty() ? out_empty : 0u) | (half(in_) ? in_half_full : 0u) |
         (half(out_) ? out_half_full : 0u) | errors_;
}

Word Fifo::read(Address offset, Cycles now) {
  switch (offset) {
    case 1: return status();
    case 2: return static_cast<Word>(in_.size());
    case 3: return static_cast<Word>(out_.size());
    case 4: return control_;
    default: break;
  }
  if (in_.empty()) {
    errors_ |= underflow;
    return 0;
  }
  // A host that waited for room continues now.
  if (in_.size() == depth_) arrives_from_ = std::max(arrives_from_, now);
  const Word word = in_.front();
  in_.pop_front();
  advance_to(now);
  return word;
}

void Fifo::write(Address offset, Word value, Cycles now) {
  if (offset == 1) errors_ &= ~value;
  if (offset == 4) control_ = value & (on_input | on_empty | on_half);
  if (offset != 0) return;
  if (out_.size() == depth_) {
    errors_ |= overflow;
    return;
  }
  if (out_.empty()) leaves_from_ = std::max(leaves_from_, now + output_cycles_);
  out_.push_back(value);
  advance_to(now);
}

/// If two words move in one cycle, the one to the host is first: the host may wait for it.
void Fifo::advance_to(Cycles now) {
  while (next_word() <= now) {
    if (next_leave() <= next_arrival()) {
      const Cycles at = next_leave();
      sent_.push_back(out_.front());
      out_.pop_front();
      host_.heard(sent_.back(), at);
      leaves_from_ = at + output_cycles_;
    } else {
      const Cycles at = next_arrival();
      in_.push_back(host_.take(at));
      arrives_from_ = at + input_cycles_;
    }
  }
}

bool Fifo::interrupts() const {
  return ((control_ & on_input) != 0 && !in_.empty()) || ((control_ & on_empty) != 0 && out_.empty()) ||
         ((control_ & on_half) != 0 && half(in_));
}

void Fifo::list_state(state::Visitor& list) {
  list("host", host_);
  list("in", in_);
  list("out", out_);
  list("sent", sent_);
  list("arrives_from", arrives_from_);
  list("leaves_from", leaves_from_);
  list("control", control_);
  list("errors", errors_);
}

}  // namespace machine
