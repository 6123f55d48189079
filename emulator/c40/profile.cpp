#include "c40/profile.hpp"

#include "isa/decode.hpp"

namespace c40 {

void Profile::Entry::add(const Entry& other) {
  instructions += other.instructions;
  cycles += other.cycles;
  for (std::size_t i = 0; i < cause_count; ++i) causes[i] += other.causes[i];
}

Profile::Profile(Address entry, TraceSink* next) : next_(next) { calls_[entry] = 0; }

void Profile::instruction(const TraceRecord& record) {
  if (until_arrival_ > 0 && --until_arrival_ == 0 && record.pc != return_to_) ++calls_[record.pc];
  instructions_[record.pc].add({1, record.cycles, record.causes});
  const isa::Decoded decoded = isa::decode(record.word);
  if (const auto* instruction = std::get_if<isa::Instruction>(&decoded)) {
    using enum isa::Operation;
    const isa::Operation operation = instruction->row->operation;
    const bool late = operation == laj || operation == lat;  // three slots lie between
    if (late || operation == call || operation == trap) {
      until_arrival_ = late ? 4 : 1;
      return_to_ = record.pc + (late ? 4 : 1);
    }
  }
  if (next_ != nullptr) next_->instruction(record);
}

void Profile::interrupt(Word vector, Cycles cycle) {
  until_arrival_ = 1;
  return_to_.reset();
  if (next_ != nullptr) next_->interrupt(vector, cycle);
}

std::map<Address, Profile::Routine> Profile::routines() const {
  std::map<Address, Routine> out;
  for (const auto& [address, calls] : calls_) out[address].calls = calls;
  for (const auto& [address, entry] : instructions_) {
    auto after = out.upper_bound(address);
    if (after == out.begin()) after = std::next(out.try_emplace(address).first);  // code before everything that was called
    std::prev(after)->second.own.add(entry);
  }
  return out;
}

Causes Profile::outside(const Causes& total) const {
  Causes rest = total;
  for (const auto& [address, entry] : instructions_)
    for (std::size_t i = 0; i < cause_count; ++i) rest[i] -= entry.causes[i];
  return rest;
}

}  // namespace c40
