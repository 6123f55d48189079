#include "machine/instruction_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "isa/disassemble.hpp"

namespace machine {
namespace {

std::string upper(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c); });
  return result;
}

std::string line_start(c40::Cycles cycle, unsigned slot) { return fmt::format("{} [dsp {}] ", cycle, slot); }

}  // namespace

std::string to_text(const c40::TraceRecord& record, unsigned slot) {
  std::string line = line_start(record.cycle, slot) +
                     fmt::format("{:08X} {:08X}  {}", record.pc, record.word, isa::disassemble(record.word, record.pc));
  const std::size_t bare = line.size();
  auto out = std::back_inserter(line);
  for (const c40::RegisterChange& change : record.registers)
    fmt::format_to(out, " {}={:0{}X}", upper(isa::name(change.reg)), change.value,
                   isa::is_extended(change.reg) ? 10 : 8);
  for (const c40::MemoryEvent& event : record.memory)
    if (event.write) fmt::format_to(out, " @{:08X}={:08X}", event.address, event.value);
  for (std::size_t cause = 1; cause < c40::cause_count; ++cause)
    if (record.causes[cause] != 0)
      fmt::format_to(out, " {}={}", name(static_cast<c40::Cause>(cause)), record.causes[cause]);
  if (line.size() > bare) line.insert(bare, "  ;");
  return line;
}

InstructionText::InstructionText(unsigned slot, Line line, c40::Cycles from, c40::Cycles to)
    : slot_(slot), line_(std::move(line)), from_(from), to_(to) {}

void InstructionText::instruction(const c40::TraceRecord& record) {
  if (from_ <= record.cycle && record.cycle < to_) line_(to_text(record, slot_));
}

void InstructionText::interrupt(c40::Word vector, c40::Cycles cycle) {
  if (from_ <= cycle && cycle < to_)
    line_(line_start(cycle, slot_) + fmt::format("-------- --------  interrupt  ; vector={}", vector));
}

}  // namespace machine
