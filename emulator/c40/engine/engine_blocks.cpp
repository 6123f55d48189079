// Running blocks. The functions of an access through a window are always inline: a frame for each would cost more than
// what some of them do.
#include <algorithm>
#include <utility>

#include "c40/engine/engine.hpp"
#include "c40/instructions/handler_tables.hpp"

namespace c40 {
namespace {

// So often a block is left for an access before other blocks are recorded for it.
constexpr std::uint32_t rarely_left = 8;

}  // namespace

// Leaves a block before instruction `at`. Time before `from`, and everything else before `seen`, is already added.
void Engine::leave(CodeBlock& block, InBlock in, std::size_t at) {
  Core& core = state_.core;
  state_.cycle += block.start[at] - block.start[in.from];
  if (at != in.seen) {
    block.add_causes(state_.causes, in.seen, at);
    state_.instructions += at - in.seen;
    cache_.fetch(block, in.seen, at);
  }
  core.pc = block.key.pc + static_cast<Address>(at);
  core.delay_slots = at < block.size ? block.delay_slots[at] : 0;
  pipeline_.set(block.pipelines[at]);
}

// `passes` passes of a repeated block are done: updates the state of the loop hardware.
[[gnu::always_inline]] inline CodeBlock::Exit& Engine::end_repeat(CodeBlock& block, std::uint32_t passes) {
  Core& core = state_.core;
  core.r[reg::RC] -= passes;
  CodeBlock::Exit& again = block.exits[1];
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

// How often a block that follows itself may run at once.
std::uint32_t Engine::passes_within(const CodeBlock& block, Cycles limit) const {
  const Core& core = state_.core;
  if (!block.self_loop || core.r[reg::RS] != block.key.pc || ends_blocks(block.key.pc)) return 1;
  const auto count = static_cast<std::int32_t>(core.r[reg::RC]);
  if (count <= 0) return 1;
  const Cycles affordable = (limit - state_.cycle) / block.exits[1].cycles;
  return static_cast<std::uint32_t>(std::clamp<Cycles>(affordable, 1, Cycles{count} + 1));
}

// Runs a repeated block for as many passes as the budget covers. A handler may do several at once and subtracts them
// from loop_left.
CodeBlock::Exit* Engine::run_repeated(CodeBlock& block, Cycles limit, Outcome& outcome) {
  Core& core = state_.core;
  const std::uint32_t passes = passes_within(block, limit);
  core.loop_left = block.only_nop ? 0 : passes - 1;
  for (;;) {
    outcome = block.ops[0].handler(core, block.ops.data());
    if (outcome.exit > Exit::taken) [[unlikely]] {
      const std::uint32_t done = passes - 1 - core.loop_left;  // whole passes before the last one, which was left early
      core.r[reg::RC] -= done;
      if (done != 0) cache_.fetch(block);
      blocks_.count(block.exits[1], done);
      state_.cycle += done * block.exits[1].cycles;
      return nullptr;
    }
    if (core.loop_left == 0) {
      cache_.fetch(block);
      return &end_repeat(block, passes);
    }
    --core.loop_left;
  }
}

// Runs from an instruction on, as far as `budget` covers: cycles since the block's beginning.
[[gnu::always_inline]] inline Outcome Engine::run_ops(CodeBlock& block, std::size_t from, Cycles budget) {
  Core& core = state_.core;
  core.loop_left = 0;
  if (block.last_start < budget) [[likely]]
    return block.ops[from].handler(core, &block.ops[from]);
  return run_some_ops(block, from, budget);
}

// The same for a budget that does not cover the whole block.
Outcome Engine::run_some_ops(CodeBlock& block, std::size_t from, Cycles budget) {
  const auto begin = block.start.begin();
  const auto first = std::lower_bound(begin + static_cast<std::ptrdiff_t>(from),
                                      begin + static_cast<std::ptrdiff_t>(block.size), budget);
  const auto at = static_cast<std::size_t>(first - begin);
  const Handler handler = std::exchange(block.ops[at].handler, &execute::budget_end);
  const Outcome outcome = block.ops[from].handler(state_.core, &block.ops[from]);
  block.ops[at].handler = handler;
  return outcome;
}

// The rest of a block was run to its end. The count that run_blocks will add is for the whole block.
[[gnu::always_inline]] inline CodeBlock::Exit& Engine::end_part(CodeBlock& block, InBlock in, const Outcome& outcome) {
  in.seen == 0 ? cache_.fetch(block) : cache_.fetch(block, in.seen, block.size);
  CodeBlock::Exit& exit = block.repeats ? end_repeat(block, 1) : block.exits[outcome.exit == Exit::taken];
  state_.cycle -= block.start[in.from];
  if (in.seen == 0) return exit;
  state_.instructions -= in.seen;
  block.subtract_causes(state_.causes, 0, in.seen);
  return exit;
}

// The window of an instruction, while accesses through windows may be done in blocks.
inline const WindowAccess* Engine::open_window(const CodeBlock& block, std::size_t at) const {
  return peripherals_.dma_active() || probe_.on_data() ? nullptr : block.window(at);
}

// Instruction `at` continues with the answer to the access before which the chip stopped. That the access is the same
// one the instruction checks, as any other (its guard).
inline bool Engine::opens_answer(const CodeBlock& block, std::size_t at) {
  const WindowAccess* const window = open_window(block, at);
  if (window == nullptr) return false;
  const Answer& given = state_.answers[window->access];
  if (!given.given || !window->area->contains(given.address)) return false;
  opened_ = {window, given.address, given.write, {given.value, given.arbitration, given.transfer}, given.comm_port};
  access_.forget_answer(window->access);
  return true;
}

// An access that an instruction could not do goes through a window, as during the recording. Either the access is
// answered (opened_), or the chip stops before it (access_). False: neither.
[[gnu::always_inline]] inline bool Engine::reach_window(CodeBlock& block, InBlock& in, const Outcome& outcome) {
  const Core& core = state_.core;
  const auto at = static_cast<std::size_t>(outcome.at - block.ops.data());
  const WindowAccess* const window = open_window(block, at);
  if (window == nullptr || window->access != core.miss_access || !window->area->contains(core.miss_address) ||
      access_.is_answered())
    return false;
  if (window->area->kind == Region::Kind::registers) return reach_port(block, in, at, *window);
  const bool write = core.miss_write;
  opened_.window = window;
  opened_.address = core.miss_address;
  opened_.write = write;
  ExternalAccess access{core.miss_address,
                        write,
                        window->interlocked,
                        write ? core.miss_value : 0,
                        state_.cycle + block.start[at] - block.start[in.from] + window->start,
                        -1};
  if (write) passed_ = {&block, in, at};
  const bool answered = answers_at_once(access);
  if (write) in = std::exchange(passed_, {}).in;
  if (!answered) {
    leave(block, in, at);
    in = {at, at};
    access_.begin(window->access, access);
    onward_.inside(block, at);
    return true;
  }
  state_.cycle += block.start[at] - block.start[in.from];
  in.from = at;
  return true;
}

// The chip stops before the access to a linked port. False: the register belongs to no such port.
[[gnu::noinline]] bool Engine::reach_port(CodeBlock& block, InBlock& in, std::size_t at, const WindowAccess& window) {
  const Core& core = state_.core;
  if (!is_port_register(core.miss_address)) return false;
  const Word value = core.miss_write ? core.miss_value : 0;
  PortAccess access = port_access(core.miss_address, core.miss_write, value, 0);
  if (ports_.listener(access.port) == nullptr) return false;
  leave(block, in, at);
  in = {at, at};
  access.cycle = state_.cycle + window.start;
  access_.begin(window.access, access);
  onward_.inside(block, at);
  return true;
}

void Engine::catch_up() {
  if (passed_.block == nullptr) return;
  leave(*passed_.block, passed_.in, passed_.at);
  passed_ = {.block = nullptr, .in = {passed_.at, passed_.at}, .at = 0};
}

// Executes instruction `at`, whose access is answered, whatever the budget, and those after it.
[[gnu::always_inline]] inline Outcome Engine::pass_window(CodeBlock& block, std::size_t at, Cycles limit) {
  const WindowAccess* const window = opened_.window;
  const std::size_t k = window->access;
  Op& op = block.ops[at];
  auto& cell = scratch_[k].cell;
  cell = {opened_.answer.value};
  op.access[k] = {cell.data(), opened_.address, 1};
  const Cycles waited = opened_.answer.arbitration + opened_.answer.transfer + opened_.comm_port,
               here = block.start[at];
  const Outcome outcome = run_ops(block, at, std::max(limit - state_.cycle - waited, Cycles{1}) + here);
  op.access[k] = {};
  if (outcome.at == &op && outcome.exit > Exit::taken && outcome.exit != Exit::left_after) {
    state_.answers[k] =
        opened_.given(opened_.write, opened_.address);  // another access of the instruction failed its guard
  } else {
    if (window->lock) state_.locked[window->area->resource == Resource::global] = *window->lock;
    settle_answer(opened_.answer, opened_.comm_port);
  }
  return outcome;
}

// The rest of a block from an instruction on that could not do an access. Null: the block was left, or the chip stops
// before an access (access_).
[[gnu::always_inline]] inline CodeBlock::Exit* Engine::pass_windows(CodeBlock& block, InBlock in, Outcome outcome,
                                                                    Cycles limit) {
  while (outcome.exit > Exit::taken) {
    if (outcome.exit != Exit::miss || !reach_window(block, in, outcome)) {
      left_block(block, in, outcome);
      return nullptr;
    }
    if (access_.any()) return nullptr;
    outcome = pass_window(block, in.from, limit);
  }
  return &end_part(block, in, outcome);
}

// Block after block, as long as each leads to a known one. This is the cost of every block, so only counts and cycles
// are added here.
Engine::Stepped Engine::run_blocks(CodeBlock* block, std::size_t at, Cycles limit) {
  Core& core = state_.core;
  CodeBlock::Exit* exit = nullptr;
  Cycles cycle = state_.cycle;
  InBlock in{at, at};
  const auto leads_on = [&]() __attribute__((always_inline)) {
    blocks_.count(*exit, 1);
    cycle += exit->cycles;
    block = exit->next;
    if (block == nullptr || core.attention) return false;
    if (block->key.pc == core.pc) [[likely]]
      return true;
    block = blocks_.recent(core.pc, block->key);
    return block != nullptr;
  };
  bool on = true;
  if (access_.is_answered() && opens_answer(*block, at)) {
    const Outcome ended = pass_window(*block, at, limit);
    exit = ended.exit <= Exit::taken ? &end_part(*block, in, ended) : pass_windows(*block, in, ended, limit);
    if (exit == nullptr) return before_access();
    cycle = state_.cycle;
    in = {};
    on = leads_on();
  }
  while (on) {
    Outcome outcome;
    if (in.from == 0 && block->plain_start < limit - cycle) [[likely]] {
      const Outcome ended = block->ops[0].handler(core, block->ops.data());
      if (ended.exit <= Exit::taken) [[likely]] {
        exit = &block->exits[ended.exit == Exit::taken];
        if (leads_on()) [[likely]]
          continue;
        break;
      }
      outcome = ended;
      exit = nullptr;
      state_.cycle = cycle;
    } else if (in.from == 0 && block->last_start < limit - cycle && block->in_one_go && cache_.fits(*block)) {
      core.loop_left = 0;
      outcome = block->ops[0].handler(core, block->ops.data());
      if (outcome.exit <= Exit::taken) {
        cache_.fetch(*block);
        exit = block->repeats ? &end_repeat(*block, 1) : &block->exits[outcome.exit == Exit::taken];
      } else {
        exit = nullptr;
        state_.cycle = cycle;
      }
    } else {
      if (exit != nullptr && (cycle >= limit || (block->uses_cache && !cache_.fits(*block)))) break;
      state_.cycle = cycle;
      exit = run_special(*block, in, limit, outcome);
      cycle = state_.cycle;
    }
    if (exit == nullptr) [[unlikely]] {
      exit = pass_windows(*block, in, outcome, limit);
      if (exit == nullptr) {
        CodeBlock* const other = continues_beside(limit);
        if (other == nullptr) return before_access();
        block = other, cycle = state_.cycle, in = {};
        continue;
      }
      cycle = state_.cycle;
    }
    in = {};
    if (!leads_on()) break;
  }
  state_.cycle = cycle;
  pipeline_.set(exit->pipeline);
  if (!core.attention) onward_.after(*exit);
  return Stepped::done;
}

// The block with which to continue after another one was left, if that happens often. Null: none, or something has to
// be looked at first.
[[gnu::noinline]] CodeBlock* Engine::continues_beside(Cycles limit) {
  CodeBlock* const left = onward_.often_missed();
  if (left == nullptr || state_.core.attention || state_.cycle >= limit || !breakpoints.empty() || probe_.on_code())
    return nullptr;
  CodeBlock* const other = other_block(*left);
  if (other != nullptr) onward_.clear();
  return other;
}

// Runs a block that repeats or comes from the cache, from its middle, or with a budget that does not cover it. Null:
// the block was left early.
CodeBlock::Exit* Engine::run_special(CodeBlock& block, InBlock in, Cycles limit, Outcome& outcome) {
  const Cycles budget = limit - state_.cycle + block.start[in.from];
  const bool part = in.from != 0 || block.last_start >= budget;
  if (!part && block.repeats) return run_repeated(block, limit, outcome);
  outcome = run_ops(block, in.from, budget);
  return outcome.exit <= Exit::taken ? &end_part(block, in, outcome) : nullptr;
}

void Engine::left_block(CodeBlock& block, InBlock in, const Outcome& outcome) {
  const auto at = static_cast<std::size_t>(outcome.at - block.ops.data());
  if (outcome.exit == Exit::left_after) {
    const std::uint8_t slots = block.delay_slots[at];
    leave(block, in, at + 1);
    state_.core.delay_slots = slots;
    advance_pc(block.key.pc + static_cast<Address>(at), Flow::straight);
    return;
  }
  leave(block, in, at);
  if (outcome.exit == Exit::cut) {
    onward_.inside(block, at);
  } else {
    const bool elsewhere = outcome.exit == Exit::miss && (at != 0 || block.key.left_for == CodeBlockKey::none);
    onward_.missed(block, elsewhere && ++block.times_left > rarely_left);
  }
}

// The exact engine has executed an instruction that the block could not execute. Returns to the block if everything is
// as recorded.
void Engine::rejoin(CodeBlock& block) {
  const Core& core = state_.core;
  const std::size_t at = core.pc - block.key.pc;
  if (at == 0 || at >= block.size || core.delay_slots != block.delay_slots[at]) return;
  if (pipeline_.id() != block.pipelines[at]) return;
  onward_.inside(block, at);
}

}  // namespace c40
