#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <string>

#include "isa/decode.hpp"
#include "isa/disassemble.hpp"
#include "isa/hazards.hpp"
#include "isa/table.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/cpu.hpp"
#include "python/bindings/interpreter/without_gil.hpp"

namespace {

const char* kind_name(isa::Operand::Kind kind) {
  using Kind = isa::Operand::Kind;
  switch (kind) {
    case Kind::none: return "none";
    case Kind::reg: return "register";
    case Kind::direct: return "direct";
    case Kind::indirect: return "indirect";
    case Kind::immediate_int: return "immediate_int";
    case Kind::immediate_float: return "immediate_float";
    case Kind::expansion: return "expansion";
    case Kind::target: return "target";
    case Kind::address: return "address";
    case Kind::trap: return "trap";
  }
  return "";
}

const char* flag_class_name(isa::FlagClass flags) {
  using X = isa::FlagClass;
  switch (flags) {
    case X::none: return "";
    case X::A: return "A";
    case X::B: return "B";
    case X::L: return "L";
    case X::S: return "S";
    case X::SA: return "SA";
    case X::F: return "F";
    case X::G: return "G";
    case X::ieee: return "F*";
    case X::normalize: return "NORM";
    case X::round: return "RND";
    case X::multiply_add: return "MPY||";
  }
  return "";
}

py::object operand_dict(const isa::Operand& operand, isa::Cpu cpu) {
  using Kind = isa::Operand::Kind;
  if (operand.is(Kind::none)) return py::none();
  py::dict out;
  out["kind"] = kind_name(operand.kind);
  if (operand.is(Kind::reg) || operand.is(Kind::indirect)) out["register"] = std::string(isa::name(operand.reg, cpu));
  if (operand.is(Kind::indirect)) out["modn"] = operand.modn;
  if (!operand.is(Kind::reg)) out["value"] = operand.value;
  return out;
}

std::vector<std::string> register_names(isa::RegisterSet set) {
  std::vector<std::string> names;
  for (int i = 0; i < isa::register_count; ++i)
    if ((set >> i & 1) != 0) names.emplace_back(isa::name(static_cast<isa::Register>(i)));
  return names;
}

py::dict hazards_dict(const isa::Instruction& instruction) {
  const isa::Hazards h = isa::hazards(instruction);
  py::dict out;
  out["address_reads"] = register_names(h.address_reads);
  out["address_updates"] = register_names(h.address_updates);
  out["operand_reads"] = register_names(h.operand_reads);
  out["decode_writes"] = register_names(h.decode_writes);
  out["read_writes"] = register_names(h.read_writes);
  out["execute_writes"] = register_names(h.execute_writes);
  out["memory_reads"] = h.memory_reads;
  out["memory_writes"] = h.memory_writes;
  return out;
}

py::object decode_dict(isa::Word word, const std::string& processor) {
  const isa::Cpu cpu = cpu_called(processor);
  const isa::Decoded decoded = isa::decode(word, cpu);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  if (instruction == nullptr) return py::none();
  py::dict out;
  out["word"] = word;
  out["row"] = instruction->row - isa::rows(cpu).data();
  out["mnemonic"] = std::string(instruction->row->mnemonic);
  out["mnemonic2"] = std::string(instruction->row->mnemonic2);
  out["operation"] = std::string(isa::name(instruction->row->operation));
  out["operation2"] = std::string(isa::name(instruction->row->operation2));
  out["condition"] = std::string(isa::name(instruction->condition));
  out["src1"] = operand_dict(instruction->src1, cpu);
  out["src2"] = operand_dict(instruction->src2, cpu);
  out["dst"] = operand_dict(instruction->dst, cpu);
  out["src3"] = operand_dict(instruction->src3, cpu);
  out["src4"] = operand_dict(instruction->src4, cpu);
  out["dst2"] = operand_dict(instruction->dst2, cpu);
  out["hazards"] = hazards_dict(*instruction);
  return out;
}

py::object reserved_reason(isa::Word word, const std::string& cpu) {
  const isa::Decoded decoded = isa::decode(word, cpu_called(cpu));
  if (const auto* reserved = std::get_if<isa::Reserved>(&decoded))
    return py::str(std::string(isa::describe(reserved->reason)));
  return py::none();
}

py::list row_dicts(const std::string& cpu) {
  py::list out;
  for (const isa::Row& row : isa::rows(cpu_called(cpu))) {
    py::dict entry;
    entry["picture"] = std::string(row.picture);
    entry["mask"] = row.bits.mask;
    entry["match"] = row.bits.match;
    entry["mnemonic"] = std::string(row.mnemonic);
    entry["mnemonic2"] = std::string(row.mnemonic2);
    entry["operation"] = std::string(isa::name(row.operation));
    entry["operation2"] = std::string(isa::name(row.operation2));
    entry["modes"] = row.modes;
    entry["flags"] = flag_class_name(row.flags);
    entry["cycles"] = row.cycles;
    entry["conditional"] = row.conditional();
    entry["c4x_only"] = row.c4x_only;
    entry["section"] = std::string(row.section);
    out.append(entry);
  }
  return out;
}

/// Sweeps the decoder.
std::uint64_t count_instructions(isa::Word first, std::uint64_t count, isa::Word step) {
  const WithoutGil released;
  std::uint64_t legal = 0;
  isa::Word word = first;
  for (std::uint64_t i = 0; i < count; ++i, word += step)
    legal += std::holds_alternative<isa::Instruction>(isa::decode(word)) ? 1 : 0;
  return legal;
}

}  // namespace

void bind_isa(py::module_& core) {
  py::module_ m = core.def_submodule("isa", "The instruction table of the TMS320C4x: decoding, disassembly, metadata.");
  m.def("decode", &decode_dict, py::arg("word"), py::arg("cpu") = "c40",
        "The word's operation and operands as a dict, or None if the word is reserved.");
  m.def("reserved_reason", &reserved_reason, py::arg("word"), py::arg("cpu") = "c40",
        "Why the word is reserved, or None if it is an instruction.");
  m.def(
      "disassemble",
      [](isa::Word word, isa::Address pc, const isa::SymbolLookup& symbols, const std::string& cpu) {
        return isa::disassemble(word, pc, symbols, cpu_called(cpu));
      },
      py::arg("word"), py::arg("pc") = 0, py::arg("symbols") = isa::SymbolLookup(), py::arg("cpu") = "c40",
      "Text that assembles at address pc to the same word; symbols(address) may name branch targets ('' if it has no "
      "name).");
  m.def("rows", &row_dicts, py::arg("cpu") = "c40", "The instruction table, one dict per encoding.");
  m.def("count_instructions", &count_instructions, py::arg("first"), py::arg("count"), py::arg("step") = 1,
        "How many of `count` words from `first` on, `step` apart, are instructions.");
}
