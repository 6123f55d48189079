// Running blocks.
#include <algorithm>
#include <utility>

#include "c40/engine.hpp"
#include "c40/handler_tables.hpp"

namespace c40 {

// Leaves a block before instruction `at`, having entered it before `from`.
void Engine::leave(Block& block, std::size_t from, std::size_t at) {
  Core& core = state_.core;
  state_.cycle += block.start[at] - block.start[from];
  add_difference(state_.causes, block.causes[at], block.causes[from]);
  state_.instructions += at - from;
  core.pc = block.key.pc + static_cast<Address>(at);
  core.delay_slots = at < block.size ? block.delay_slots[at] : 0;
  pipeline_.set(block.pipelines[at]);
  cache_.fetch(block, from, at);
}

// `passes` passes through a repeated block are done: what the loop hardware made of them.
Block::Exit& Engine::end_repeat(Block& block, std::uint32_t passes) {
  Core& core = state_.core;
  core.r[reg::RC] -= passes;
  Block::Exit& again = block.exits[1];
  blocks_.count(again, passes - 1);
  state_.cycle += (passes - 1) * again.cycles;
  if (static_cast<std::int32_t>(core.r[reg::RC]) >= 0) {
    core.pc = core.r[reg::RS];
    if (core.repeat_single == 1) core.repeat_single = 2;
    return again;
  }
  core.modes &= ~st::RM;
  core.repeat_single = 0;
  return block.exits[0];
}

// How often a block that follows itself may run in one go.
std::uint32_t Engine::passes_within(const Block& block, Cycles limit) const {
  const Core& core = state_.core;
  if (!block.self_loop || core.r[reg::RS] != block.key.pc || ends_blocks(block.key.pc)) return 1;
  const auto count = static_cast<std::int32_t>(core.r[reg::RC]);
  if (count <= 0) return 1;
  const Cycles affordable = (limit - state_.cycle) / block.exits[1].cycles;
  return static_cast<std::uint32_t>(std::clamp<Cycles>(affordable, 1, Cycles{count} + 1));
}

// A repeated block, as many passes as the budget covers. A handler may do several at once and takes them off loop_left.
Block::Exit* Engine::run_repeated(Block& block, Cycles limit) {
  Core& core = state_.core;
  const std::uint32_t passes = passes_within(block, limit);
  core.loop_left = block.only_nop ? 0 : passes - 1;
  for (;;) {
    const Outcome outcome = block.ops[0].handler(core, block.ops.data());
    if (outcome.exit > Exit::taken) [[unlikely]] {
      const std::uint32_t done = passes - 1 - core.loop_left;  // whole passes before the one that was left
      core.r[reg::RC] -= done;
      if (done != 0) cache_.fetch(block, 0, block.size);
      blocks_.count(block.exits[1], done);
      state_.cycle += done * block.exits[1].cycles;
      left_block(block, 0, outcome);
      return nullptr;
    }
    if (core.loop_left == 0) {
      cache_.fetch(block, 0, block.size);
      return &end_repeat(block, passes);
    }
    --core.loop_left;
  }
}

// From the middle, or with a budget that does not cover all of it.
Block::Exit* Engine::run_part(Block& block, std::size_t from, Cycles limit) {
  Core& core = state_.core;
  core.loop_left = 0;
  const Cycles budget = limit - state_.cycle + block.start[from];
  Outcome outcome;
  if (block.last_start >= budget) {
    const auto begin = block.start.begin();
    const auto first = std::lower_bound(begin + static_cast<std::ptrdiff_t>(from),
                                        begin + static_cast<std::ptrdiff_t>(block.size), budget);
    const auto at = static_cast<std::size_t>(first - begin);
    const Handler handler = std::exchange(block.ops[at].handler, &execute::budget_end);
    outcome = block.ops[from].handler(core, &block.ops[from]);
    block.ops[at].handler = handler;
  } else {
    outcome = block.ops[from].handler(core, &block.ops[from]);
  }
  if (outcome.exit > Exit::taken) {
    left_block(block, from, outcome);
    return nullptr;
  }
  cache_.fetch(block, from, block.size);
  Block::Exit& exit = block.repeats ? end_repeat(block, 1) : block.exits[outcome.exit == Exit::taken];
  // The count that run_blocks will add stands for the whole block.
  state_.cycle -= block.start[from];
  state_.instructions -= from;
  add_difference(state_.causes, Costs{}, block.causes[from]);
  return &exit;
}

// Block after block, as long as each leads to one that is known. What every block costs is here: counts and cycles
// only.
void Engine::run_blocks(Block* block, std::size_t from, Cycles limit) {
  Core& core = state_.core;
  Block::Exit* exit = nullptr;
  Cycles cycle = state_.cycle;
  for (;;) {
    if (block->plain && from == 0 && block->last_start < limit - cycle) [[likely]] {
      const Outcome outcome = block->ops[0].handler(core, block->ops.data());
      if (outcome.exit > Exit::taken) [[unlikely]] {
        state_.cycle = cycle;
        return left_block(*block, 0, outcome);
      }
      exit = &block->exits[outcome.exit == Exit::taken];
    } else {
      if (exit != nullptr && (cycle >= limit || (block->uses_cache && !cache_.fits(*block)))) break;
      state_.cycle = cycle;
      exit = run_special(*block, from, limit);
      if (exit == nullptr) return;
      cycle = state_.cycle;
      from = 0;
    }
    blocks_.count(*exit, 1);
    cycle += exit->cycles;
    block = exit->next;
    if (block == nullptr || block->key.pc != core.pc || core.attention) [[unlikely]]
      break;
  }
  state_.cycle = cycle;
  pipeline_.set(exit->pipeline);
  if (!core.attention) onward_.after(*exit);
}

// One that repeats or comes from the cache, from the middle, or with a budget that does not cover it. Null: it was
// left.
Block::Exit* Engine::run_special(Block& block, std::size_t from, Cycles limit) {
  if (from != 0 || block.last_start >= limit - state_.cycle) return run_part(block, from, limit);
  if (block.repeats) return run_repeated(block, limit);
  const Outcome outcome = block.ops[0].handler(state_.core, block.ops.data());
  if (outcome.exit > Exit::taken) [[unlikely]] {
    left_block(block, 0, outcome);
    return nullptr;
  }
  cache_.fetch(block, 0, block.size);
  return &block.exits[outcome.exit == Exit::taken];
}

void Engine::left_block(Block& block, std::size_t from, const Outcome& outcome) {
  const auto at = static_cast<std::size_t>(outcome.at - block.ops.data());
  if (outcome.exit == Exit::left_after) {
    const std::uint8_t slots = block.delay_slots[at];
    leave(block, from, at + 1);
    state_.core.delay_slots = slots;
    advance_pc(block.key.pc + static_cast<Address>(at));
    return;
  }
  leave(block, from, at);
  if (outcome.exit == Exit::cut) {
    onward_.inside(block, at);
  } else {
    onward_.missed(block);
  }
}

// After the exact engine did the instruction that the block could not: back into the block if everything is as
// recorded.
void Engine::rejoin(Block& block) {
  const Core& core = state_.core;
  const std::size_t at = core.pc - block.key.pc;
  if (at == 0 || at >= block.size || core.delay_slots != block.delay_slots[at]) return;
  if (pipeline_.id() != block.pipelines[at]) return;
  onward_.inside(block, at);
}

}  // namespace c40
