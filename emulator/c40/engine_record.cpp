// Recording blocks: the exact engine executes, and what it did is kept.
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

}  // namespace c40
