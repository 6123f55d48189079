#pragma once
// A chip's instructions as the lines of docs/trace.md, and as hashes of those lines per stretch of cycles.
#include <functional>
#include <string>

#include "c40/chip.hpp"
#include "machine/time.hpp"

namespace machine {

/// "12 [dsp 0] 00300004 6A06FFFB  bnz 00300000h  ; branch=3", without the line's end.
std::string to_text(const c40::TraceRecord& record, unsigned slot);

/// Writes each instruction that begins in [from, to) cycles.
class InstructionText final : public c40::TraceSink {
 public:
  using Line = std::function<void(const std::string& line)>;
  InstructionText(unsigned slot, Line line, c40::Cycles from = 0,
                  c40::Cycles to = std::numeric_limits<c40::Cycles>::max());
  void instruction(const c40::TraceRecord& record) override;
  void interrupt(c40::Word vector, c40::Cycles cycle) override;

 private:
  unsigned slot_;
  Line line_;
  c40::Cycles from_, to_;
};

}  // namespace machine
