#include "c40/observers/self_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "c40/chip/state.hpp"
#include "c40/values/float40.hpp"
#include "isa/disassemble.hpp"
#include "isa/hazards.hpp"

namespace c40 {
namespace {

using isa::Instruction;
using isa::Operation;
using isa::Register;

constexpr Address slots = 3;    // instructions after a delayed branch that are executed with it
constexpr Address fetched = 3;  // words after the executing one that are already in the pipeline
constexpr isa::RegisterSet repeat_registers =
    isa::set_of(Register::RS) | isa::set_of(Register::RE) | isa::set_of(Register::RC);

isa::RegisterSet written(const Instruction& instruction) {
  const isa::Hazards h = isa::hazards(instruction);
  return h.execute_writes | h.read_writes | h.decode_writes;
}

std::string_view section(Rule rule) {
  static constexpr std::string_view sections[] = {"8.2", "8.3", "8.5", "8.4", "8.1", "7.4", "3.9", "12"};
  return sections[static_cast<std::size_t>(rule)];
}

std::string_view section(isa::Reserved::Reason reason) {
  using enum isa::Reserved::Reason;
  switch (reason) {
    case opcode: return "12";
    case reserved_bits: return "3";
    case register_class: return "1.1";
    case same_register: return "6.1";
    case addressing_mode:
    case displacement: return "3.9";
    case condition: return "4";
    case expansion_register: return "1.2";
  }
  return "";
}

bool repeats_block(const Instruction& instruction) { return instruction.row->operation == Operation::rptb; }
bool repeats(const Instruction& instruction) {
  return repeats_block(instruction) || instruction.row->operation == Operation::rpts;
}

}  // namespace

namespace {
constexpr std::array<std::string_view, 8> names{"delay_slot",     "repeat_block", "repeat_nesting", "repeat_single",
                                                "self_modifying", "interlocked",  "circular",       "reserved"};
static_assert(names.size() == static_cast<std::size_t>(Rule::reserved) + 1 && names.back() == "reserved",
              "one name each, in order");
}  // namespace

std::string_view name(Rule rule) { return names[static_cast<std::size_t>(rule)]; }
std::vector<std::string_view> rule_names() { return {names.begin(), names.end()}; }

std::string_view document(Rule rule) { return rule == Rule::interlocked ? "c40-hardware.md" : "c40-isa.md"; }

SelfCheck::SelfCheck(const Chip& chip, TraceSink* next) : chip_(chip), next_(next) { look(); }

void SelfCheck::look() {
  for (std::uint8_t code = 0; code < isa::register_count; ++code)
    before_[code] = static_cast<Word>(chip_.register_value(static_cast<Register>(code)));
  const Core& core = chip_.state().core;
  annulled_slot_ = core.annul && core.delay_slots != 0 ? slots + 1 - core.delay_slots : 0;
}

std::optional<Instruction> SelfCheck::at(Address address) const {
  try {
    const isa::Decoded decoded = isa::decode(chip_.peek(address));
    if (const auto* instruction = std::get_if<Instruction>(&decoded)) return *instruction;
  } catch (const std::out_of_range&) {
    // No memory there: the fetch itself reports this.
  }
  return std::nullopt;
}

void SelfCheck::report(Rule rule, Address pc, Cycles cycle, Word word, std::string message) {
  const auto [found, fresh] = known_.try_emplace({rule, pc}, diagnostics_.size());
  if (fresh)
    diagnostics_.push_back({rule, section(rule), pc, cycle, isa::disassemble(word, pc), std::move(message)});
  else
    ++diagnostics_[found->second].count;
  if (on_breach) on_breach(diagnostics_[found->second]);
}

void SelfCheck::run_ended() {
  const Address pc = chip_.pc();
  if (!chip_.halted() || known_.contains({Rule::reserved, pc})) return;
  try {
    const isa::Decoded decoded = isa::decode(chip_.peek(pc));
    const auto* reserved = std::get_if<isa::Reserved>(&decoded);
    if (reserved == nullptr) return check_repeat_end(std::get<Instruction>(decoded));
    report(Rule::reserved, pc, chip_.cycle(), reserved->word, std::string(isa::describe(reserved->reason)));
    diagnostics_.back().section = section(reserved->reason);
  } catch (const std::out_of_range&) {
    // No memory there: the fault reports this.
  }
}

void SelfCheck::instruction(const TraceRecord& record) {
  const isa::Decoded decoded = isa::decode(record.word);
  if (const auto* instruction = std::get_if<Instruction>(&decoded)) {
    if (instruction->row->delay != isa::Delay::none) check_slots(record, *instruction);
    if (repeats(*instruction)) check_block(record, *instruction);
    check_nesting(record, *instruction);
    check_stores(record);
    check_interlocked(record, *instruction);
    // An annulled slot has its address arithmetic, if it gets as far as its decode stage (c40-isa.md 8.2).
    const bool forms_addresses = annulled_slot_ < slots;
    for (const isa::Operand* operand : {&instruction->src1, &instruction->src2, &instruction->dst, &instruction->src3,
                                        &instruction->src4, &instruction->dst2})
      if (forms_addresses) check_circular(record, *operand);
  }
  look();
  if (next_ != nullptr) next_->instruction(record);
}

void SelfCheck::interrupt(const InterruptRecord& record) {
  interlocked_store_.reset();
  look();
  if (next_ != nullptr) next_->interrupt(record);
}

void SelfCheck::check_slots(const TraceRecord& record, const Instruction& branch) {
  const Operation operation = branch.row->operation;
  const bool links = operation == Operation::laj || operation == Operation::lat;
  for (Address slot = 1; slot <= slots; ++slot) {
    const auto in_slot = at(record.pc + slot);
    if (!in_slot) continue;
    const auto found = [&](std::string what) {
      report(Rule::delay_slot, record.pc + slot, record.cycle, in_slot->word, std::move(what));
    };
    const std::string of =
        fmt::format("slot {} of {} at {:08X}h", slot, isa::disassemble(record.word, record.pc), record.pc);
    if (isa::is_program_control(*in_slot)) found(fmt::format("program control may not stand in {}", of));
    if (links && (written(*in_slot) & isa::set_of(Register::R11)) != 0)
      found(fmt::format("R11 holds the return address and may not be written in {}", of));
    if (operation == Operation::rptb && (written(*in_slot) & repeat_registers) != 0)
      found(fmt::format("RS, RE and RC may not be written in {}", of));
  }
}

void SelfCheck::check_block(const TraceRecord& record, const Instruction& repeat) {
  const auto found = [&](Rule rule, Address pc, Word word, std::string what) {
    report(rule, pc, record.cycle, word, std::move(what));
  };
  if (!repeats_block(repeat)) {
    const auto repeated = at(record.pc + 1);
    if (repeated && isa::is_program_control(*repeated))
      found(Rule::repeat_single, record.pc + 1, repeated->word,
            fmt::format("RPTS at {:08X}h may not repeat program control", record.pc));
    return;
  }
  const auto start = static_cast<Address>(chip_.register_value(Register::RS));
  const auto end = static_cast<Address>(chip_.register_value(Register::RE));
  if (end < start)
    return found(Rule::repeat_block, record.pc, record.word,
                 fmt::format("the block ends at {:08X}h, before it begins at {:08X}h", end, start));
  if (const auto last = at(end)) {
    if (isa::is_program_control(*last))
      found(Rule::repeat_block, end, last->word,
            fmt::format("the block of {:08X}h may not end with program control", record.pc));
    if ((written(*last) & repeat_registers) != 0)
      found(Rule::repeat_block, end, last->word,
            fmt::format("the last instruction of the block of {:08X}h may not write RS, RE or RC", record.pc));
  }
  for (Address address = std::max(start, end >= slots ? end - slots : 0); address < end; ++address) {
    const auto near_end = at(address);
    if (near_end && near_end->row->delay != isa::Delay::none)
      found(
          Rule::repeat_block, address, near_end->word,
          fmt::format("none of the last four instructions of the block of {:08X}h may be a delayed branch", record.pc));
  }
}

// A repeat inside a block overwrites RS, RE and RC; they have to be restored before the block's last instruction.
void SelfCheck::check_nesting(const TraceRecord& record, const Instruction& instruction) {
  const Block around{before(Register::RS), before(Register::RE)};
  const bool inside = (before(Register::ST) & st::RM) != 0 && record.pc >= around.start && record.pc <= around.end;
  if (repeats(instruction) && inside) open_.push_back(around);
  while (!open_.empty() && record.pc == open_.back().end) {
    const Block broken = open_.back();
    open_.pop_back();
    const bool more =
        static_cast<std::int32_t>(before(Register::RC)) > 0;  // in the last pass ST is read without RM (c40-isa.md 1.4)
    if (before(Register::RS) != broken.start || before(Register::RE) != broken.end ||
        (more && (before(Register::ST) & st::RM) == 0))
      report(Rule::repeat_nesting, record.pc, record.cycle, record.word,
             fmt::format("the block {:08X}h to {:08X}h ends here, but a repeat inside it has taken RS, RE, RC and RM",
                         broken.start, broken.end));
  }
}

// The chip has stopped before a branch that is not allowed at the end of a repeated block (c40-isa.md 8.3).
void SelfCheck::check_repeat_end(const Instruction& instruction) {
  const Address pc = chip_.pc(), end = static_cast<Address>(chip_.register_value(Register::RE));
  if ((chip_.register_value(Register::ST) & st::RM) == 0 || known_.contains({Rule::repeat_block, pc})) return;
  const bool delayed = instruction.row->delay != isa::Delay::none;
  if (!isa::is_program_control(instruction) || end - pc > (delayed ? slots : 0)) return;
  report(Rule::repeat_block, pc, chip_.cycle(), instruction.word,
         end == pc
             ? "a repeated block may not end with program control"
             : fmt::format("a delayed branch may not stand {} words before the end of a repeated block", end - pc));
}

void SelfCheck::check_interlocked(const TraceRecord& record, const Instruction& instruction) {
  const Operation operation = instruction.row->operation;
  const bool loads = operation == Operation::ldii || operation == Operation::ldfi || operation == Operation::sigi;
  if (loads && interlocked_store_ && annulled_slot_ == 0)
    report(Rule::interlocked, record.pc, record.cycle, record.word,
           fmt::format("an interlocked load may not stand straight behind the interlocked store at {:08X}h",
                       *interlocked_store_));
  interlocked_store_.reset();
  const bool stores = operation == Operation::stii || operation == Operation::stfi;
  if (stores && annulled_slot_ == 0) interlocked_store_ = record.pc;
}

void SelfCheck::check_stores(const TraceRecord& record) {
  const bool writes = std::ranges::any_of(record.memory, &MemoryEvent::write);
  if (!writes) return;
  const Core& core = chip_.state().core;
  Address next = core.repeat_single != 0 ? record.pc + 1 : chip_.pc();  // the word under RPTS is fetched once
  for (Address ahead = 1; ahead <= fetched; ++ahead) {
    for (const MemoryEvent& event : record.memory)
      if (event.write && event.address == next)
        report(Rule::self_modifying, record.pc, record.cycle, record.word,
               fmt::format("stores to {:08X}h, {} words ahead: the pipeline has fetched it already", next, ahead));
    next = behind(next, ahead);
  }
}

/// The word executed after one that comes `ahead` words from now.
Address SelfCheck::behind(Address word, Address ahead) const {
  const Core& core = chip_.state().core;
  if (core.delay_slots != 0) return core.delay_slots == ahead ? core.delay_target : word + 1;
  const bool repeats = (core.modes & st::RM) != 0 && static_cast<std::int32_t>(core.r[reg::RC]) > 0;
  return repeats && word == core.r[reg::RE] ? core.r[reg::RS] : word + 1;
}

void SelfCheck::check_circular(const TraceRecord& record, const isa::Operand& operand) {
  if (!operand.is(isa::Operand::Kind::indirect) || !isa::modn::is_circular(operand.modn)) return;
  const Word size = before(Register::BK);
  const isa::modn::Index index = isa::modn::index(operand.modn);
  const Word step = index == isa::modn::Index::IR0   ? before(Register::IR0)
                    : index == isa::modn::Index::IR1 ? before(Register::IR1)
                                                     : operand.displacement();
  const auto found = [&](std::string what) {
    report(Rule::circular, record.pc, record.cycle, record.word, std::move(what));
  };
  if (size == 0) return found("BK is 0: there is no circular buffer");
  if (step > size) return found(fmt::format("a step of {} in a circular buffer of BK = {} words", step, size));
  Word mask = size;
  for (unsigned shift = 1; shift < 32; shift *= 2) mask |= mask >> shift;
  const Word place = before(operand.reg) & mask;
  if (place >= size)
    found(fmt::format("{} points {} words into a circular buffer of BK = {}", isa::name(operand.reg), place, size));
}

}  // namespace c40
