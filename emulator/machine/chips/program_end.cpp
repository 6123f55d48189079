#include "machine/chips/program_end.hpp"

#include "isa/decode.hpp"

namespace machine {

ProgramEnd program_end(toolchain::Word word, toolchain::Address pc) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  if (instruction == nullptr) return ProgramEnd::none;
  if (instruction->row->mnemonic == "idle" || instruction->row->mnemonic == "idle2") return ProgramEnd::idle;
  const isa::Operand& target = instruction->src1;
  const bool to_itself = (instruction->row->mnemonic == "b?" || instruction->row->mnemonic == "br") &&
                         instruction->condition == isa::Condition::U && target.is(isa::Operand::Kind::target) &&
                         pc + static_cast<toolchain::Address>(target.value) == pc;
  return to_itself ? ProgramEnd::halt : ProgramEnd::none;
}

std::set<toolchain::Address> program_ends(const toolchain::Image& image) {
  std::set<toolchain::Address> ends;
  for (const toolchain::Image::Section& section : image.sections) {
    toolchain::Address address = section.address;
    for (const toolchain::Word word : section.words) {
      if (program_end(word, address) != ProgramEnd::none) ends.insert(address);
      ++address;
    }
  }
  return ends;
}

}  // namespace machine
