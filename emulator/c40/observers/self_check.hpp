#pragma once
/// Rules of the manual that a program can break without a visible effect on the chip, checked at each instruction of a
/// run. A trace sink: with it the chip runs without blocks, and nothing observable changes.
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip/chip.hpp"
#include "isa/decode.hpp"

namespace c40 {

enum class Rule : std::uint8_t {
  delay_slot,      ///< program control in a slot, or a slot that destroys what its branch has set up
  repeat_block,    ///< an end before the beginning, or an end at which the repeat does not work
  repeat_nesting,  ///< a repeat inside a block without restoring the block's registers
  repeat_single,   ///< RPTS before program control
  self_modifying,  ///< a store to a word that is already in the pipeline
  interlocked,     ///< an interlocked load directly after an interlocked store
  circular,        ///< a circular step outside the buffer's limits
  reserved,        ///< a reserved word: reserved mode, register code, condition or bits; the chip stops with a fault
};
/// "delay_slot"
std::string_view name(Rule rule);
std::vector<std::string_view> rule_names();
/// "c40-isa.md", or "c40-hardware.md"
std::string_view document(Rule rule);
/// One broken rule at one place; repetitions are only counted.
struct Diagnostic {
  Rule rule{};
  std::string_view section;  ///< section of the rule, in the document that document() names
  Address pc = 0;
  Cycles cycle = 0;
  std::string instruction;  ///< disassembled
  std::string message;
  std::uint64_t count = 1;
};

class SelfCheck final : public TraceSink {
 public:
  /// \param next gets everything too; may be null. Both must outlive this object.
  explicit SelfCheck(const Chip& chip, TraceSink* next = nullptr);

  /// Reads registers that were changed from outside.
  void look();
  void hand_on_to(TraceSink* next) { next_ = next; }
  /// To be called when a run has ended: if a reserved word, or a branch that is not allowed, has stopped the chip,
  /// there is no trace record of it.
  void run_ended();

  void instruction(const TraceRecord& record) override;
  void interrupt(const InterruptRecord& record) override;

  /// Called for every broken rule, also a known one: `count` is the number so far.
  std::function<void(const Diagnostic&)> on_breach;

  /// In the order in which they were found.
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  struct Block {
    Address start, end;
  };

  void check_slots(const TraceRecord& record, const isa::Instruction& branch);
  void check_block(const TraceRecord& record, const isa::Instruction& repeat);
  void check_nesting(const TraceRecord& record, const isa::Instruction& instruction);
  void check_interlocked(const TraceRecord& record, const isa::Instruction& instruction);
  void check_repeat_end(const isa::Instruction& instruction);
  void check_stores(const TraceRecord& record);
  void check_circular(const TraceRecord& record, const isa::Operand& operand);
  void report(Rule rule, Address pc, Cycles cycle, Word word, std::string message);
  std::optional<isa::Instruction> at(Address address) const;
  Address behind(Address word, Address ahead) const;
  Word before(isa::Register r) const { return before_[isa::code(r)]; }

  const Chip& chip_;
  TraceSink* next_;
  std::array<Word, isa::register_count> before_{};
  Address annulled_slot_ = 0;                 ///< of the next instruction, 1 to 3; 0: it is not annulled
  std::optional<Address> interlocked_store_;  ///< the address, if the instruction before was an interlocked store
  std::vector<Block> open_;                   ///< blocks interrupted by an inner repeat
  std::vector<Diagnostic> diagnostics_;
  std::map<std::pair<Rule, Address>, std::size_t> known_;
};

}  // namespace c40
