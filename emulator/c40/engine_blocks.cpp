// Recording blocks and running them.
#include <algorithm>
#include <utility>

#include "c40/engine.hpp"
#include "c40/handler_tables.hpp"

namespace c40 {
namespace {

constexpr std::size_t longest_block = 64, longest_cached_block = Cache::segment_words;

void add_timing(Costs& costs, const StepTiming& t) {
  const auto charge = [&](Cause cause, int cycles) {
    auto& cost = costs[static_cast<std::size_t>(cause)];
    cost = static_cast<std::uint16_t>(cost + cycles);
  };
  charge(Cause::execute, t.execute());
  charge(Cause::branch, t.branch);
  charge(Cause::register_conflict, t.register_conflict);
  charge(Cause::memory_conflict, t.memory_conflict);
  charge(Cause::cache_miss, t.cache_miss);
  charge(Cause::wait_state, t.wait_state);
}

}  // namespace

BlockKey Engine::key() {
  const Core& core = state_.core;
  BlockKey key;
  key.pc = core.pc;
  key.pipeline = pipeline_.id();
  const bool repeat = (core.modes & st::RM) != 0;
  if (repeat) key.repeat_end = core.r[reg::RE];
  key.mode = ((core.modes & st::SETCOND) != 0 ? BlockKey::set_condition : 0u) | (repeat ? BlockKey::repeat : 0u) |
             static_cast<std::uint32_t>(core.repeat_single) << BlockKey::repeat_single;
  if (caching()) {
    key.mode |= BlockKey::cached | (cache_.frozen() ? BlockKey::frozen : 0u);
    key.hits = cache_.hits_from(core.pc);
  }
  return key;
}

// PC is where by_blocks() looked.
Block* Engine::find_or_record(Cycles limit, Stepped& why) {
  const BlockKey k = key();
  Block* const block = blocks_.find(k);
  // The exit that led here leads here every time; but at a breakpoint, each run of blocks ends.
  if (Block::Exit* from = onward_.take_exit(); from != nullptr && block != nullptr && from->chained && !breakpoints.contains(k.pc)) from->next = block;
  if (block != nullptr) return block;
  if (blocks_.full()) flush_blocks();
  record(k, limit, why);
  return nullptr;
}

bool Engine::recordable(const Bound& bound) const {
  using enum isa::Operation;
  // Their slots are fetched before CF changes.
  if (caching() && bound.flow == Flow::delayed && (bound.row->operation == lat || bound.row->operation == reti)) return false;
  if (bound.flow == Flow::stop || bound.flow == Flow::annulling) return false;
  if (bound.reads_status || bound.writes_status || bound.writes_interrupts) return false;
  return !(bound.writes_repeat && bound.flow == Flow::straight && (state_.core.modes & st::RM) != 0);
}

// Executes as it records. Whatever cannot stand in a block ends it.
void Engine::record(const BlockKey& k, Cycles limit, Stepped& why) {
  Core& core = state_.core;
  auto block = std::make_unique<Block>();
  block->key = k;
  Cycles at = 0;
  Costs costs{};
  bool reads_repeat = false, closed = false, chained = true;
  Step step;
  PipelineId before = 0, after = k.pipeline;  // of the last instruction in the block: the one that ends it may have been executed
  while (!closed) {
    const std::size_t n = block->size;
    if (n != 0 && state_.cycle >= limit) return;
    if (n >= longest_block && core.delay_slots == 0) break;
    if (n != 0 && breakpoints.contains(core.pc)) break;
    Step look;
    const bool known = fetch(look);
    const bool cached = caching();
    const bool crowded = cached && n + (look.site != nullptr && look.site->bound.flow == Flow::delayed ? 4 : 1) > longest_cached_block;
    if (!known || look.paged || crowded || cached != ((k.mode & BlockKey::cached) != 0) || !recordable(look.site->bound)) {
      if (n == 0) {
        known ? exact_sites_.add(k.pc, false) : exact_sites_.remove(k.pc);
        why = exact_step(step, false);
        return;
      }
      fault_.reset();
      // Slots cannot be left to a block of their own.
      if (core.delay_slots != 0) return;
      break;
    }
    before = pipeline_.id();
    const auto slots = static_cast<std::uint8_t>(core.delay_slots);
    const bool ends_repeat = (k.mode & BlockKey::repeat) != 0 && core.pc == k.repeat_end;
    why = exact_step(step, true);
    if (why != Stepped::done || !step.plain) {
      if (n == 0) why == Stepped::external ? exact_sites_.add(k.pc, true) : exact_sites_.remove(k.pc);
      if (n == 0 || slots != 0) return;
      break;
    }
    const Bound& bound = step.site->bound;
    for (std::size_t i = 0; i < step.site->demand.count; ++i)
      if (step.site->demand.data[i].write && step.address[i] - k.pc <= n) return;  // it changes itself
    Op op = step.site->ops[0];
    op.pc = k.pc + static_cast<Address>(n);
    if (bound.flow == Flow::directed || bound.row->operation == isa::Operation::lat ||
        bound.row->operation == isa::Operation::reti)
      op.direction = step.taken || (bound.flow == Flow::delayed && core.delay_taken) ? 1 : 0;
    block->ops.push_back(op);
    block->start.push_back(at);
    block->causes.push_back(costs);
    block->pipelines.push_back(before);
    block->delay_slots.push_back(slots);
    ++block->size;
    reads_repeat |= bound.reads_repeat;
    chained &= !bound.dynamic_target && bound.row->operation != isa::Operation::reti;
    if (cached) block->words.push_back(step.word);
    at += step.timing->total;
    add_timing(costs, *step.timing);
    after = pipeline_.id();
    Op terminal;
    terminal.pc = op.pc + 1;
    if (bound.flow == Flow::branch || bound.flow == Flow::directed) {
      close_with_branch(*block, step, before, chained);
      closed = true;
    } else if (slots == 1) {
      terminal.handler = &execute::end_of_delay;
      closed = true;
    } else if (ends_repeat && slots == 0 && bound.flow == Flow::straight) {
      terminal.handler = &execute::end_of_repeat;
      block->repeats = closed = true;
    }
    if (terminal.handler != nullptr) {
      block->ops.push_back(terminal);
      close_straight(*block, at, costs, after, chained);
    }
  }
  if (!closed) {
    Op terminal;
    terminal.handler = &execute::end_of_block;
    terminal.pc = k.pc + static_cast<Address>(block->size);
    block->ops.push_back(terminal);
    close_straight(*block, at, costs, after, chained);
  }
  block->start.push_back(at);
  block->causes.push_back(costs);
  block->pipelines.push_back(block->exits[0].pipeline);
  block->last_start = block->start[block->size - 1];
  for (Block::Exit& exit : block->exits) exit.size = block->size;
  block->uses_cache = (k.mode & BlockKey::cached) != 0;
  block->plain = !block->repeats && !block->uses_cache;
  const std::uint32_t own_words = block->size < longest_cached_block ? (1u << block->size) - 1 : ~0u;
  block->all_hits = (~k.hits & own_words) == 0;
  const bool same_fetches = !block->uses_cache || block->all_hits || (k.mode & BlockKey::frozen) != 0;
  block->self_loop = block->repeats && !reads_repeat && same_fetches && block->exits[1].pipeline == k.pipeline && (k.mode >> BlockKey::repeat_single & 3) != 1;
  const Bound& last = step.site->bound;
  block->only_nop = block->self_loop && block->size == 1 && last.is_nop;
  if (block->self_loop && block->size == 1 && last.repeated != nullptr) block->ops[0].handler = last.repeated;
  blocks_.add(std::move(block), memory_);
}

void Engine::close_straight(Block& block, Cycles cycles, const Costs& costs, PipelineId end, bool chained) {
  for (Block::Exit& exit : block.exits) {
    exit.cycles = cycles;
    exit.causes = costs;
    exit.pipeline = end;
    exit.chained = chained;
  }
}

void Engine::close_with_branch(Block& block, const Step& step, PipelineId before, bool chained) {
  const std::size_t last = block.size - 1;
  for (std::size_t direction = 0; direction < 2; ++direction) {
    Block::Exit& exit = block.exits[direction];
    Pipeline pipeline = pipelines_[before];
    Demand demand = demand_of(step);
    demand.flush_cost = direction == 1 ? step.site->bound.taken_cost : step.site->bound.not_taken_cost;
    const StepTiming timing = pipeline.advance(demand);
    exit.cycles = block.start[last] + timing.total;
    exit.causes = block.causes[last];
    add_timing(exit.causes, timing);
    exit.pipeline = pipelines_.intern(pipeline);
    exit.chained = chained;
  }
}

// ---- running ----

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
  if (!block.self_loop || core.r[reg::RS] != block.key.pc || breakpoints.contains(block.key.pc)) return 1;
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
    const auto first = std::lower_bound(begin + static_cast<std::ptrdiff_t>(from), begin + static_cast<std::ptrdiff_t>(block.size), budget);
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

// Block after block, as long as each leads to one that is known. What every block costs is here: counts and cycles only.
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
    if (block == nullptr || block->key.pc != core.pc || core.attention) [[unlikely]] break;
  }
  state_.cycle = cycle;
  pipeline_.set(exit->pipeline);
  if (!core.attention) onward_.after(*exit);
}

// One that repeats or comes from the cache, from the middle, or with a budget that does not cover it. Null: it was left.
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

// After the exact engine did the instruction that the block could not: back into the block if everything is as recorded.
void Engine::rejoin(Block& block) {
  const Core& core = state_.core;
  const std::size_t at = core.pc - block.key.pc;
  if (at == 0 || at >= block.size || core.delay_slots != block.delay_slots[at]) return;
  if (pipeline_.id() != block.pipelines[at]) return;
  onward_.inside(block, at);
}

void Engine::settle_counts() {
  blocks_.settle(state_.causes, state_.instructions);
  pipeline_.settle();
}

void Engine::flush_blocks() {
  settle_counts();
  blocks_.clear(memory_);
  exact_sites_.clear();
  onward_.clear();
  cache_.mark_code(memory_);
}

void Engine::process_code_writes() {
  Core& core = state_.core;
  for (std::size_t i = 0; i < core.code_writes; ++i) cache_.memory_written(core.code_written[i]);
  core.code_writes = 0;
  flush_blocks();
}

}  // namespace c40
