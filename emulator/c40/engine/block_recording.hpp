#pragma once
/// A block during its recording: the exact engine executes, and reports each completed instruction.
#include <memory>

#include "c40/engine/block.hpp"
#include "c40/engine/decoded_slots.hpp"

namespace c40 {

class BlockRecording {
 public:
  BlockRecording(const CodeBlockKey& key, PipelineTable& pipelines);

  /// Number of instructions so far.
  std::size_t size() const { return block_->size; }
  /// The last instruction branches or ends a repetition: no instruction can follow.
  bool closed() const { return closed_; }
  /// The block is long enough to end at an instruction that is not in a delay slot.
  bool full() const;
  /// A block of cached code has no room for another instruction with its delay slots.
  bool crowded_by(const DecodedSlot* next) const;
  bool cached() const { return (block_->key.mode & CodeBlockKey::cached) != 0; }

  /// The context of an instruction before and after its execution.
  struct StepContext {
    PipelineId before = 0, after = 0;
    std::uint8_t slots = 0;    ///< delay slots that were still to come, including this instruction
    bool delay_taken = false;  ///< after the instruction
    Cycles window_start = 0;   ///< the beginning of its access through a window, if it has one
  };
  void append(const Step& step, const StepContext& context);

  /// Ends the recording. \param last the last instruction executed, in the block or not
  std::unique_ptr<CodeBlock> finish(const BoundInstruction& last);

 private:
  void close_with_branch(const Step& step, PipelineId before);
  void end_with(Handler terminal);

  PipelineTable& pipelines_;
  std::unique_ptr<CodeBlock> block_;
  Cycles at_ = 0;  ///< since the beginning of the block
  Costs costs_{};
  PipelineId after_;
  bool reads_repeat_ = false;
  bool chained_ = true;
  bool closed_ = false;
};

}  // namespace c40
