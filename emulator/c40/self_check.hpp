#pragma once
/// Rules of the manual that a program may break without the chip noticing, checked instruction by instruction while it
/// runs. A trace sink: with it the chip runs without blocks, and nothing observable changes.
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip.hpp"
#include "isa/decode.hpp"

namespace c40 {

enum class Rule : std::uint8_t {
  delay_slot,      ///< program control in a slot, or a slot that spoils what its branch has set up
  repeat_block,    ///< an end before the beginning, or an end that the repeat cannot leave from
  repeat_nesting,  ///< a repeat inside a block, and the block's registers not restored
  repeat_single,   ///< RPTS before program control
  self_modifying,  ///< a store to a word that the pipeline has fetched already
  interlocked,     ///< an interlocked load straight behind an interlocked store
  circular,        ///< a circular step outside what the buffer allows
  reserved,  ///< a word that is no instruction: reserved mode, register code, condition or bits; the chip stops with a
             ///< fault
};
/// "delay_slot"
std::string_view name(Rule rule);
std::vector<std::string_view> rule_names();
/// "c40-isa.md", or "c40-hardware.md"
std::string_view document(Rule rule);
/// One breach; later ones of the same rule at the same place are only counted.
struct Diagnostic {
  Rule rule{};
  std::string_view section;  ///< where the rule stands, in the document that document() names
  Address pc = 0;
  Cycles cycle = 0;
  std::string instruction;  ///< disassembled
  std::string message;
  std::uint64_t count = 1;
};

class SelfCheck final : public TraceSink {
 public:
  /// \param next hears everything too; may be null. Both must outlive this.
  explicit SelfCheck(const Chip& chip, TraceSink* next = nullptr);

  /// Takes note of registers that were changed from outside.
  void look();
  void hand_on_to(TraceSink* next) { next_ = next; }
  /// To be called when a run has ended: a chip that a reserved word, or a branch that may not stand there, has stopped
  /// sends no record of it.
  void run_ended();

  void instruction(const TraceRecord& record) override;
  void interrupt(Word vector, Cycles cycle) override;

  /// Hears every breach, also one that was known: `count` says how many there have been.
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
  Word before(isa::Register r) const { return before_[isa::code(r)]; }

  const Chip& chip_;
  TraceSink* next_;
  std::array<Word, isa::register_count> before_{};
  std::optional<Address> interlocked_store_;  ///< the instruction before was one, at this address
  std::vector<Block> open_;                   ///< blocks that an inner repeat has broken into
  std::vector<Diagnostic> diagnostics_;
  std::map<std::pair<Rule, Address>, std::size_t> known_;
};

}  // namespace c40
