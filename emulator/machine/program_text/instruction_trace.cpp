#include "machine/program_text/instruction_trace.hpp"

#include <fmt/format.h>

#include <iterator>

#include "isa/ascii.hpp"
#include "isa/disassemble.hpp"

namespace machine {
namespace {

std::string line_start(c40::Cycles cycle, unsigned slot) { return fmt::format("{} [dsp {}] ", cycle, slot); }

/// A value of a register or a word of memory. The low 32 bits of an extended register may be an address.
std::string value_text(std::uint64_t value, bool extended, const Labels* labels) {
  if (labels)
    if (const auto name = labels->names.name(static_cast<c40::Address>(value)))
      return extended ? fmt::format("{:02X}:{}", value >> 32, *name) : *name;
  return fmt::format("{:0{}X}", value, extended ? 10 : 8);
}

/// The result of a float instruction is not an address, even if its fraction looks like one.
bool gives_floats(isa::Word word) {
  const auto decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  return instruction != nullptr && (instruction->row->destination == isa::OperandClass::floating ||
                                    instruction->row->source == isa::OperandClass::floating);
}

/// All but the cycle of each instruction.
void add_causes(std::string& line, const c40::Causes& causes) {
  for (std::size_t cause = 1; cause < c40::cause_count; ++cause)
    if (causes[cause] != 0)
      fmt::format_to(std::back_inserter(line), " {}={}", name(static_cast<c40::Cause>(cause)), causes[cause]);
}

std::string line_of(const c40::TraceRecord& record, unsigned slot, const Labels* labels) {
  std::string line = line_start(record.cycle, slot);
  auto out = std::back_inserter(line);
  if (labels) {
    const auto symbols = [labels](c40::Address address) { return labels->names.name(address).value_or(""); };
    fmt::format_to(out, "{} -  {}", labels->names.text(record.pc), labels->source(record.pc, record.word, symbols));
  } else {
    fmt::format_to(out, "{:08X} {:08X}  {}", record.pc, record.word, isa::disassemble(record.word, record.pc));
  }
  const std::size_t bare = line.size();
  const Labels* data_labels = labels != nullptr && gives_floats(record.word) ? nullptr : labels;
  for (const c40::RegisterChange& change : record.registers) {
    const bool extended = isa::is_extended(change.reg);
    fmt::format_to(out, " {}={}", ascii::upper(isa::name(change.reg)),
                   value_text(change.value, extended, extended ? data_labels : labels));
  }
  for (const c40::MemoryEvent& event : record.memory)
    if (event.write)
      fmt::format_to(out, " @{}={}", labels ? labels->names.text(event.address) : fmt::format("{:08X}", event.address),
                     value_text(event.value, false, data_labels));
  add_causes(line, record.causes);
  if (line.size() > bare) line.insert(bare, "  ;");
  return line;
}

}  // namespace

std::string to_text(const c40::TraceRecord& record, unsigned slot) { return line_of(record, slot, nullptr); }

std::string to_text(const c40::TraceRecord& record, unsigned slot, const Labels& labels) {
  return line_of(record, slot, &labels);
}

std::string to_text(const c40::InterruptRecord& record, unsigned slot) {
  std::string line =
      line_start(record.cycle, slot) + fmt::format("-------- --------  interrupt  ; vector={}", record.vector);
  add_causes(line, record.causes);
  return line;
}

InstructionText::InstructionText(unsigned slot, Line line, Wanted wanted, std::optional<Labels> labels)
    : slot_(slot), line_(std::move(line)), wanted_(std::move(wanted)), labels_(std::move(labels)) {}

void InstructionText::instruction(const c40::TraceRecord& record) {
  if (!wanted_ || wanted_(record.cycle)) line_(line_of(record, slot_, labels_ ? &*labels_ : nullptr));
}

void InstructionText::interrupt(const c40::InterruptRecord& record) {
  if (!wanted_ || wanted_(record.cycle)) line_(to_text(record, slot_));
}

}  // namespace machine
