#pragma once
/// A block while it is being recorded: the exact engine executes, and tells of each instruction that is through.
#include <memory>

#include "c40/block.hpp"
#include "c40/decoded_slots.hpp"

namespace c40 {

class BlockRecording {
 public:
  BlockRecording(const CodeBlockKey& key, PipelineTable& pipelines);

  /// Instructions so far.
  std::size_t size() const { return block_->size; }
  /// The last instruction leaves the straight line, or ends a repetition: nothing more can follow.
  bool closed() const { return closed_; }
  /// The block is long enough to be left at an instruction that stands in no slots.
  bool full() const;
  /// No room for another instruction of a block that comes from the cache, with the slots that it has.
  bool crowded_by(const DecodedSlot* next) const;
  bool cached() const { return (block_->key.mode & CodeBlockKey::cached) != 0; }

  /// How an instruction stood before and after it was executed.
  struct StepContext {
    PipelineId before = 0, after = 0;
    std::uint8_t slots = 0;    ///< of a delayed branch that were to come, itself included
    bool delay_taken = false;  ///< afterwards
    Cycles window_start = 0;   ///< of its access through a window, if it has one
  };
  void append(const Step& step, const StepContext& context);

  /// Closes it where it stands. \param last the last instruction executed, in the block or not
  std::unique_ptr<CodeBlock> finish(const BoundInstruction& last);

 private:
  void close_with_branch(const Step& step, PipelineId before);
  void end_with(Handler terminal);

  PipelineTable& pipelines_;
  std::unique_ptr<CodeBlock> block_;
  Cycles at_ = 0;  ///< since its beginning
  Costs costs_{};
  PipelineId after_;
  bool reads_repeat_ = false;
  bool chained_ = true;
  bool closed_ = false;
};

}  // namespace c40
