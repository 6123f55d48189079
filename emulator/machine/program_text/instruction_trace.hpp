#pragma once
// A chip's instructions as lines of docs/trace.md.
#include <functional>
#include <optional>
#include <string>

#include "c40/chip/chip.hpp"
#include "machine/program_text/address_names.hpp"
#include "machine/program_text/source_text.hpp"
#include "machine/time/time.hpp"

namespace machine {

/// "12 [dsp 0] 00300004 6A06FFFB  bnz 00300000h  ; branch=3", without the line's end.
std::string to_text(const c40::TraceRecord& record, unsigned slot);

/// "1643 [dsp 0] -------- --------  interrupt  ; vector=37 interrupt=8"
std::string to_text(const c40::InterruptRecord& record, unsigned slot);

/// The program's names for addresses, for lines that do not change when the program moves in memory.
struct Labels {
  AddressNames names;
  SourceText source;
  static Labels of_program(const toolchain::Image& image) {
    return {AddressNames(image), SourceText(image, SourceText::Label::dropped)};
  }
  static Labels of_dock(const toolchain::Image& image) {
    return {AddressNames::of_dock(image), SourceText(image, SourceText::Label::dropped)};
  }
};

/// "12 [dsp 0] start+0x4 -  bnz start  ; branch=3": labels instead of addresses, also for addresses in registers and
/// words, and no instruction word.
std::string to_text(const c40::TraceRecord& record, unsigned slot, const Labels& labels);

/// Writes the instructions of a chip, or those that begin in some of its cycles.
class InstructionText final : public c40::TraceSink {
 public:
  using Line = std::function<void(const std::string& line)>;
  using Wanted = std::function<bool(c40::Cycles cycle)>;
  /// With labels if given. \param wanted empty for all cycles
  InstructionText(unsigned slot, Line line, Wanted wanted = {}, std::optional<Labels> labels = {});
  void instruction(const c40::TraceRecord& record) override;
  void interrupt(const c40::InterruptRecord& record) override;

 private:
  unsigned slot_;
  Line line_;
  Wanted wanted_;
  std::optional<Labels> labels_;
};

}  // namespace machine
