#pragma once
// The names of instructions: the names of the table's rows with every condition, the optional "3", the numbered halves
// of double loads and stores, and TI's short forms (c40-isa.md 11).
#include <string>
#include <string_view>
#include <vector>

#include "isa/table.hpp"

namespace toolchain {

struct Candidate {
  const isa::Row* row = nullptr;
  isa::Condition condition = isa::Condition::U;
  bool exchanged = false;  ///< The text has the halves in the other order than the row.
};

isa::Cpu other_than(isa::Cpu cpu);

/// Rows that a name can mean, in order of preference; empty if there is none.
const std::vector<Candidate>& candidates(std::string_view name, isa::Cpu cpu);
/// The same for two parallel halves.
const std::vector<Candidate>& pair_candidates(std::string_view first, std::string_view second, isa::Cpu cpu);
/// Whether the name is a half of some parallel instruction.
bool is_parallel_name(std::string_view name, isa::Cpu cpu);
/// ": IE is a register of the C3x; the C40 has IIE ...", or nothing.
std::string register_of_other(std::string_view name, isa::Cpu cpu);
/// "'lda' is an instruction of the C40; the C3x has LDI", or nothing.
std::string mnemonic_of_other(std::string_view name, isa::Cpu cpu);
/// "; did you mean 'addi'?" or nothing.
std::string suggestion(std::string_view name, isa::Cpu cpu);

}  // namespace toolchain
