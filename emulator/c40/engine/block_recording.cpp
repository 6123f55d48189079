#include "c40/engine/block_recording.hpp"

#include <utility>

#include "c40/instructions/handler_tables.hpp"
#include "c40/memory/cache.hpp"

namespace c40 {
namespace {

constexpr std::size_t longest_block = 64, longest_cached_block = Cache::segment_words;

void add_timing(Costs& costs, const StepTiming& t) {
  for (std::size_t i = 0; i < pipeline_cause_count; ++i) costs[i] = static_cast<std::uint16_t>(costs[i] + t.causes[i]);
}

// Bit n: costs[n] is not 0.
std::uint32_t charged(const Costs& costs) {
  std::uint32_t causes = 0;
  for (std::size_t cause = 0; cause < pipeline_cause_count; ++cause)
    causes |= std::uint32_t{costs[cause] != 0} << cause;
  return causes;
}

}  // namespace

BlockRecording::BlockRecording(const CodeBlockKey& key, PipelineTable& pipelines)
    : pipelines_(pipelines), block_(std::make_unique<CodeBlock>()), after_(key.pipeline) {
  block_->key = key;
}

bool BlockRecording::full() const { return size() >= longest_block; }

bool BlockRecording::crowded_by(const DecodedSlot* next) const {
  const std::size_t words = next != nullptr && next->bound.flow == Flow::delayed ? 4 : 1;
  return size() + words > longest_cached_block;
}

void BlockRecording::append(const Step& step, const StepContext& context) {
  const BoundInstruction& bound = step.decoded->bound;
  const CodeBlockKey& key = block_->key;
  const isa::Operation operation = bound.row->operation;
  Op op = step.decoded->ops[0];
  op.pc = key.pc + static_cast<Address>(size());
  if (bound.flow == Flow::directed || operation == isa::Operation::lat || operation == isa::Operation::reti)
    op.direction = step.taken || (bound.flow == Flow::delayed && context.delay_taken) ? 1 : 0;
  for (std::uint8_t k = 0; k < 2; ++k)
    if ((step.windows >> k & 1u) != 0) {
      op.access[k] = {};  // the guard fails each time
      block_->windows.push_back({.at = size(),
                                 .access = k,
                                 .area = step.decoded->area[k],
                                 .start = context.window_start,
                                 .interlocked = bound.row->interlocked,
                                 .lock = lock_after(operation)});
    }
  block_->ops.push_back(op);
  block_->start.push_back(at_);
  block_->causes.push_back(costs_);
  block_->pipelines.push_back(context.before);
  block_->delay_slots.push_back(context.slots);
  ++block_->size;
  reads_repeat_ |= bound.reads_repeat;
  chained_ &= !bound.dynamic_target && operation != isa::Operation::reti;
  if (cached()) block_->words.push_back(step.word);
  at_ += step.timing->total;
  add_timing(costs_, *step.timing);
  after_ = context.after;
  const bool ends_repeat = (key.mode & CodeBlockKey::repeat) != 0 && op.pc == key.repeat_end;
  if (bound.flow == Flow::branch || bound.flow == Flow::directed) {
    close_with_branch(step, context.before);
  } else if (context.slots == 1) {
    end_with(&execute::end_of_delay);
  } else if (ends_repeat && context.slots == 0 && bound.flow == Flow::straight) {
    block_->repeats = true;
    end_with(&execute::end_of_repeat);
  }
}

void BlockRecording::end_with(Handler terminal) {
  Op op;
  op.handler = terminal;
  op.pc = block_->key.pc + static_cast<Address>(size());
  block_->ops.push_back(op);
  for (CodeBlock::Exit& exit : block_->exits) {
    exit.cycles = at_;
    exit.causes = costs_;
    exit.pipeline = after_;
    exit.chained = chained_;
  }
  closed_ = true;
}

void BlockRecording::close_with_branch(const Step& step, PipelineId before) {
  const std::size_t last = size() - 1;
  for (std::size_t direction = 0; direction < 2; ++direction) {
    CodeBlock::Exit& exit = block_->exits[direction];
    Pipeline pipeline = pipelines_[before];
    Demand demand = step.demand();
    demand.flush_cost = direction == 1 ? step.decoded->bound.taken_cost : step.decoded->bound.not_taken_cost;
    const StepTiming timing = pipeline.advance(demand);
    exit.cycles = block_->start[last] + timing.total;
    exit.causes = block_->causes[last];
    add_timing(exit.causes, timing);
    exit.pipeline = pipelines_.intern(pipeline);
    exit.chained = chained_;
  }
  closed_ = true;
}

std::unique_ptr<CodeBlock> BlockRecording::finish(const BoundInstruction& last) {
  if (!closed_) end_with(&execute::end_of_block);
  CodeBlock& block = *block_;
  const CodeBlockKey& key = block.key;
  block.start.push_back(at_);
  block.causes.push_back(costs_);
  for (const Costs& costs : block.causes) block.charged |= charged(costs);
  block.pipelines.push_back(block.exits[0].pipeline);
  block.last_start = block.start[block.size - 1];
  for (CodeBlock::Exit& exit : block.exits) {
    exit.size = block.size;
    exit.charged = charged(exit.causes);
  }
  block.uses_cache = cached();
  block.changes_cache = cached() && (key.mode & CodeBlockKey::frozen) == 0;
  if (!block.repeats && !block.uses_cache) block.plain_start = block.last_start;
  block.in_one_go = !block.repeats || (!block.windows.empty());
  if (cached()) block.own_words = block.size < longest_cached_block ? (1u << block.size) - 1 : ~0u;
  block.all_hits = (~key.hits & block.own_words) == 0;
  const bool same_fetches = !block.changes_cache || block.all_hits;
  const bool first_of_single = (key.mode >> CodeBlockKey::repeat_single & 3) == 1;
  block.self_loop =
      block.repeats && !reads_repeat_ && same_fetches && block.exits[1].pipeline == key.pipeline && !first_of_single;
  const bool alone = block.self_loop && block.size == 1;
  block.only_nop = alone && last.is_nop;
  if (alone && last.repeated != nullptr) block.ops[0].handler = last.repeated;
  return std::move(block_);
}

}  // namespace c40
