#include "isa/hazards.hpp"

namespace isa {
namespace {

using Kind = Operand::Kind;

void form_address(Hazards& h, const Operand& operand) {
  if (operand.is(Kind::direct)) h.address_reads |= set_of(Register::DP);
  if (!operand.is(Kind::indirect)) return;
  h.address_reads |= set_of(operand.reg);
  if (modn::modifies(operand.modn)) h.address_updates |= set_of(operand.reg);
  if (modn::is_circular(operand.modn)) h.address_reads |= set_of(Register::BK);
  if (modn::index(operand.modn) == modn::Index::IR0) h.address_reads |= set_of(Register::IR0);
  if (modn::index(operand.modn) == modn::Index::IR1) h.address_reads |= set_of(Register::IR1);
}

void read(Hazards& h, const Operand& operand) {
  form_address(h, operand);
  if (operand.is_memory()) ++h.memory_reads;
  if (operand.is(Kind::reg)) h.operand_reads |= set_of(operand.reg);
}

void write(Hazards& h, const Operand& operand, WriteStage stage) {
  form_address(h, operand);
  if (operand.is_memory()) ++h.memory_writes;
  if (!operand.is(Kind::reg)) return;
  RegisterSet& written = stage == WriteStage::decode ? h.decode_writes
                         : stage == WriteStage::read ? h.read_writes
                                                     : h.execute_writes;
  written |= set_of(operand.reg);
}

void use_stack(Hazards& h, bool push) {
  h.address_reads |= set_of(Register::SP);
  h.address_updates |= set_of(Register::SP);
  ++(push ? h.memory_writes : h.memory_reads);
}

void add_implied(Hazards& h, const Instruction& instruction) {
  using enum Operation;
  switch (instruction.row->operation) {
    case push:
    case pushf:
    case call: return use_stack(h, true);
    case trap: ++h.memory_reads; return use_stack(h, true);
    case pop:
    case popf:
    case rets:
    case reti: return use_stack(h, false);
    case lat:
      ++h.memory_reads;
      h.execute_writes |= set_of(Register::R11);
      return;
    case laj: h.execute_writes |= set_of(Register::R11); return;
    case rpts: h.execute_writes |= set_of(Register::RC) | set_of(Register::RS) | set_of(Register::RE); return;
    case rptb: h.execute_writes |= set_of(Register::RS) | set_of(Register::RE); return;
    case db: h.address_reads |= set_of(instruction.dst.reg); return;
    case nop:
      h.memory_reads = 0;  // NOP *ARn++ forms the address but does not access memory.
      return;
    default: return;
  }
}

}  // namespace

Hazards hazards(const Instruction& instruction) {
  Hazards h;
  for (const Operand* source : {&instruction.src1, &instruction.src2, &instruction.src3, &instruction.src4})
    read(h, *source);
  write(h, instruction.dst, instruction.row->write_stage);
  write(h, instruction.dst2, WriteStage::execute);
  add_implied(h, instruction);
  return h;
}

}  // namespace isa
