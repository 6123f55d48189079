#include "toolchain/assembler/checks.hpp"

#include <fmt/format.h>

#include "isa/decode.hpp"
#include "isa/disassemble.hpp"

namespace toolchain {
namespace {

using isa::Instruction;
using isa::is_program_control;
using isa::Operation;

bool is_delayed(const Instruction& instruction) { return instruction.row->delay != isa::Delay::none; }

class Checker {
 public:
  Checker(std::span<const isa::Word> words, isa::Address address, isa::Cpu cpu)
      : words_(words), address_(address), cpu_(cpu) {}

  std::vector<Finding> run() {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      const auto instruction = at(i);
      if (!instruction) continue;
      const auto& row = *instruction->row;
      if (is_delayed(*instruction)) check_slots(i, *instruction);
      if (row.operation == Operation::rpts) check_repeated(i + 1);
      if (row.operation != Operation::rptb) continue;
      if (instruction->src1.is(isa::Operand::Kind::target))
        check_block_end(i, static_cast<std::size_t>(static_cast<std::int64_t>(i) + instruction->src1.value));
      if (instruction->src1.is(isa::Operand::Kind::address))
        check_block_end(i, static_cast<isa::Word>(instruction->src1.value) - address_);
    }
    return std::move(findings_);
  }

 private:
  std::optional<Instruction> at(std::size_t i) const {
    if (i >= words_.size()) return std::nullopt;
    const auto decoded = isa::decode(words_[i], cpu_);
    if (const auto* instruction = std::get_if<Instruction>(&decoded)) return *instruction;
    return std::nullopt;
  }

  void check_slots(std::size_t i, const Instruction& branch) {
    for (std::size_t slot = 1; slot <= 3; ++slot) {
      const auto in_slot = at(i + slot);
      if (in_slot && is_program_control(*in_slot))
        findings_.push_back(
            {i + slot, fmt::format("program control in slot {} of the delayed '{}'", slot,
                                   isa::disassemble(branch, 0).substr(0, isa::disassemble(branch, 0).find(' ')))});
    }
  }

  void check_repeated(std::size_t i) {
    const auto repeated = at(i);
    if (repeated && is_program_control(*repeated)) findings_.push_back({i, "RPTS cannot repeat program control"});
  }

  void check_block_end(std::size_t start, std::size_t end) {
    if (end <= start || end >= words_.size()) return;
    const auto last = at(end);
    if (last && is_program_control(*last))
      findings_.push_back({end, "the last instruction of a repeated block cannot be program control"});
    for (std::size_t i = end > start + 3 ? end - 3 : start + 1; i < end; ++i) {
      const auto near_end = at(i);
      if (near_end && is_delayed(*near_end))
        findings_.push_back({i, "none of the last four instructions of a repeated block can be a delayed branch"});
    }
  }

  std::span<const isa::Word> words_;
  isa::Address address_;
  isa::Cpu cpu_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_code(std::span<const isa::Word> words, isa::Address address, isa::Cpu cpu) {
  return Checker(words, address, cpu).run();
}

}  // namespace toolchain
