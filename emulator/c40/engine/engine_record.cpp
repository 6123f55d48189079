// Records blocks: the exact engine executes, and its actions are kept.
#include <algorithm>
#include <utility>

#include "c40/engine/block_recording.hpp"
#include "c40/engine/engine.hpp"

namespace c40 {
// Without what depends on the cache's contents.
CodeBlockKey Engine::plain_key() {
  const Core& core = state_.core;
  CodeBlockKey key;
  key.pc = core.pc;
  key.pipeline = pipeline_.id();
  key.mode = cache_.control();
  const bool repeat = (core.modes & st::RM) != 0;
  if (repeat) key.repeat_end = core.r[reg::RE];
  key.mode |= ((core.modes & st::SETCOND) != 0 ? CodeBlockKey::set_condition : 0u) |
              (repeat ? CodeBlockKey::repeat : 0u) |
              static_cast<std::uint32_t>(core.repeat_single) << CodeBlockKey::repeat_single;
  return key;
}

CodeBlockKey Engine::key() {
  CodeBlockKey key = plain_key();
  if (caching()) {
    key.mode |= CodeBlockKey::cached | (cache_.frozen() ? CodeBlockKey::frozen : 0u);
    key.hits = cache_.hits_from(key.pc);
  }
  return key;
}

// PC is the address at which by_blocks() looked.
CodeBlock* Engine::find_or_record(Cycles limit, Stepped& why) {
  const CodeBlockKey k = key();
  CodeBlock* const block = blocks_.find(k);
  // This exit always leads here, so it is linked to the block. Not at a breakpoint, where each run of blocks ends.
  if (CodeBlock::Exit* from = onward_.take_exit(); from != nullptr && block != nullptr && from->chained)
    if (!ends_blocks(k.pc)) {
      from->next = block;
      blocks_.note_recent(*block);
    }
  if (block != nullptr) {
    cache_.note_fit(*block);
    return block;
  }
  const bool ends = at_end();
  if (ends && reported_breakpoint_ != state_.cycle) {
    why = Stepped::breakpoint;
    return nullptr;
  }
  if (ends || !blocks_.may_record(k.pc)) {
    Step step;
    why = exact_step(step, false);
    return nullptr;
  }
  if (blocks_.full()) flush_blocks();
  record(k, limit, why);
  return nullptr;
}

// The block `left` was left before the instruction at PC, whose access reaches another area than at the recording: a
// subroutine copies from memory to a window, and from the window to memory. So there is a block for each area. Null,
// and onward_ as it was: the exact engine executes the instruction.
CodeBlock* Engine::find_or_record_other(CodeBlock& left, Cycles limit, Stepped& why) {
  if (CodeBlock* const block = other_block(left); block != nullptr) {
    onward_.clear();
    return block;
  }
  const Core& core = state_.core;
  const Memory::Area* const area = std::as_const(memory_).find(core.miss_address);
  if (area == nullptr || area->kind == Region::Kind::registers || core.delay_slots != 0 ||
      exact_addresses_.contains(core.pc) || !by_blocks())
    return nullptr;
  CodeBlockKey k = key();
  k.left_for = area->base;
  CodeBlock* block = blocks_.find(k);
  if (block == nullptr) {
    const bool has_room = left.others.back().block == nullptr;
    if (!has_room || blocks_.full()) return nullptr;
    onward_.clear();
    record(k, limit, why);
    const auto room = std::ranges::find(left.others, nullptr, &CodeBlock::Other::block);
    if (CodeBlock* const recorded = blocks_.find(k); recorded != nullptr) *room = {area, recorded};
    return nullptr;
  }
  onward_.clear();
  cache_.note_fit(*block);
  return block;
}

// The block that was recorded beside `left`, and continues from PC.
CodeBlock* Engine::other_block(const CodeBlock& left) {
  const Core& core = state_.core;
  for (const CodeBlock::Other& other : left.others) {
    if (other.block == nullptr) return nullptr;
    CodeBlock& block = *other.block;
    if (block.key.pc != core.pc || !other.area->contains(core.miss_address)) continue;
    const bool fits = !block.uses_cache || (!cache_.stale() && cache_.fits(block));
    if (fits && core.delay_slots == 0 && plain_key().is_elsewhere(block.key)) return &block;
  }
  return nullptr;
}

bool Engine::recordable(const BoundInstruction& bound) const {
  using enum isa::Operation;
  // The slots of these are fetched before CF changes.
  if (caching() && bound.flow == Flow::delayed && (bound.row->operation == lat || bound.row->operation == reti))
    return false;
  if (bound.flow == Flow::stop || bound.flow == Flow::annulling) return false;
  if (bound.reads_status || bound.writes_status || bound.writes_interrupts) return false;
  return !(bound.writes_repeat && bound.flow == Flow::straight && (state_.core.modes & st::RM) != 0);
}

// Executes and records. An instruction that no block can contain ends the recording.
void Engine::record(const CodeBlockKey& k, Cycles limit, Stepped& why) {
  Core& core = state_.core;
  BlockRecording recording(k, pipelines_);
  Step step;
  while (!recording.closed()) {  // a block cannot end between a branch and its delay slots
    const std::size_t n = recording.size();
    if (n != 0 && state_.cycle >= limit) {
      if (core.delay_slots != 0 || !blocks_.is_cut_again_and_again(k.pc)) return;
      break;
    }
    if (recording.full() && core.delay_slots == 0) break;
    if (n != 0 && (ends_blocks(core.pc) || at_end())) {
      if (core.delay_slots != 0) return blocks_.gave_up(k.pc);
      break;
    }
    Step look;
    const bool known = fetch(look);
    const bool cached = caching();
    const bool crowded = cached && recording.crowded_by(look.decoded);
    if (!known || look.paged || crowded || cached != recording.cached() || !recordable(look.decoded->bound)) {
      if (n == 0) {
        known ? exact_addresses_.add(k.pc, false) : exact_addresses_.remove(k.pc);
        why = exact_step(step, false);
        return;
      }
      fault_.reset();
      if (core.delay_slots != 0) return blocks_.gave_up(k.pc);
      break;
    }
    BlockRecording::StepContext context{.before = pipeline_.id(), .slots = static_cast<std::uint8_t>(core.delay_slots)};
    why = exact_step(step, true);
    const auto writes_own_code = [&] {
      for (std::size_t i = 0; i < step.decoded->demand.count; ++i)
        if (step.decoded->demand.data[i].write && step.address[i] - k.pc <= n) return true;
      return false;
    };
    if (why != Stepped::done || !step.repeatable) {
      if (n == 0 && k.left_for == CodeBlockKey::none)
        why == Stepped::done ? exact_addresses_.add(k.pc, true) : exact_addresses_.remove(k.pc);
      if (n == 0) return;
      if (context.slots != 0 || writes_own_code()) return blocks_.gave_up(k.pc);
      break;
    }
    if (step.windows != 0) context.window_start = access_start(step, step.windows >> 1, context.before);
    if (writes_own_code()) return blocks_.gave_up(k.pc);
    context.after = pipeline_.id();
    context.delay_taken = core.delay_taken;
    recording.append(step, context);
  }
  blocks_.add(recording.finish(step.decoded->bound), memory_);
}

}  // namespace c40
