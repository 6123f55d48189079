#include "c40/engine/decoded_slots.hpp"

#include "c40/instructions/handler_tables.hpp"

namespace c40 {

CodeArea::CodeArea(const Memory& memory, const Memory::Area& found, Address pc)
    : area(&found), cacheable(external(found.resource)) {
  Memory::OpenPages any;
  met = memory.meet(found, pc, false, any);
  words = found.data + (met.base - found.base);
  fetch_bits = packed_fetch(met.access, true, false);
  unpaged_words = met.paged ? 0 : met.words;
}

void DecodedSlot::bind_to(const BoundInstruction& instruction, bool with_set_condition) {
  bound = instruction;
  known = true;
  set_condition = with_set_condition;
  keeps_windows = bound.flow == Flow::straight || bound.flow == Flow::branch;
  quick = keeps_windows && !bound.reads_status && !bound.writes_status && !bound.writes_interrupts;
  stale = false;
  quick_key = quick ? key(bound.word, set_condition ? st::SETCOND : 0) : no_key;
  ops[0] = bound.op;
  ops[1].handler = &execute::end_of_step;
  demand = {};
  demand.footprint = bound.footprint;
  data_bits = 0;
  area = {};
  forget_transition();
}

void DecodedSlot::forget_windows() {
  ops[0].access = {};
  demand.count = 0;
  data_bits = 0;
  forget_transition();
  if (stale && quick) quick_key = key(bound.word, set_condition ? st::SETCOND : 0);
  stale = false;
}

void DecodedSlotTable::make(Address count) {
  decoded_slots_ = std::vector<DecodedSlot>(count);
  mask_ = count - 1;
}

DecodedSlot& DecodedSlotTable::slot_for_new(Address pc) {
  if ((*this)[pc].known && mask_ < most - 1) make(4 * (mask_ + 1));
  return (*this)[pc];
}

void DecodedSlotTable::forget() {
  for (DecodedSlot& decoded : decoded_slots_) decoded.forget();
}

void DecodedSlotTable::forget_transitions() {
  for (DecodedSlot& decoded : decoded_slots_) decoded.forget_transition();
}

}  // namespace c40
