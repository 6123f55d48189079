#include "c40/observers/profile.hpp"

#include "isa/decode.hpp"

namespace c40 {
namespace {

constexpr bool rows_are_in_order() {
  for (std::size_t n = 0; n < cause_count; ++n)
    if (static_cast<std::size_t>(cause_rows[n].cause) != n) return false;
  return cause_count == static_cast<std::size_t>(Cause::halted) + 1;
}
static_assert(rows_are_in_order(), "each cause has one row, in the order of Cause");

/// The number of instructions from this one to the first instruction of the routine that it calls; 0 if it calls none.
int instructions_to_arrival(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  if (instruction == nullptr) return 0;
  switch (instruction->row->operation) {
    case isa::Operation::call:
    case isa::Operation::trap: return 1;
    case isa::Operation::laj:
    case isa::Operation::lat: return 4;  // three slots are in between
    default: return 0;
  }
}

}  // namespace

void ProfileCounts::Entry::add(const Entry& other) {
  instructions += other.instructions;
  cycles += other.cycles;
  for (std::size_t i = 0; i < cause_count; ++i) causes[i] += other.causes[i];
  word = other.word;
}

ProfileCounts::Entry& ProfileCounts::at(Address address) {
  const Address number = address / page_words;
  if (page_ == nullptr || number != page_number_) {
    auto& page = pages_[number];
    if (page == nullptr) page = std::make_unique<Page>();
    page_ = page.get();
    page_number_ = number;
  }
  Entry& entry = (*page_)[address % page_words];
  if (entry.instructions == 0) touched_.push_back(address);
  return entry;
}

void ProfileCounts::add(const ProfileCounts& other) {
  for (const Address address : other.touched_)
    at(address).add((*other.pages_.at(address / page_words))[address % page_words]);
  for (const auto& [address, times] : other.calls_) called(address, times);
}

void ProfileCounts::clear() {
  for (const Address address : touched_) (*pages_.at(address / page_words))[address % page_words] = {};
  touched_.clear();
  calls_.clear();
}

std::map<Address, ProfileCounts::Entry> ProfileCounts::instructions() const {
  std::map<Address, Entry> out;
  for (const Address address : touched_) out[address] = (*pages_.at(address / page_words))[address % page_words];
  return out;
}

ProfileCounts::Entry ProfileCounts::total() const {
  Entry sum;
  for (const auto& [address, entry] : instructions()) sum.add(entry);
  return sum;
}

std::map<Address, Routine> routines(const ProfileCounts& counts, const std::set<Address>& starts) {
  std::map<Address, Routine> all;
  for (const Address start : starts) all.try_emplace(start);
  for (const auto& [address, calls] : counts.calls()) all[address].calls = calls;
  for (const auto& [address, entry] : counts.instructions()) {
    auto after = all.upper_bound(address);
    if (after == all.begin()) after = std::next(all.try_emplace(address).first);  // code before all called routines
    std::prev(after)->second.own.add(entry);
  }
  std::erase_if(all, [](const auto& routine) { return routine.second.own.instructions == 0; });
  return all;
}

void Profile::instruction(const TraceRecord& record) {
  if (until_arrival_ > 0 && --until_arrival_ == 0 && record.pc != return_to_) counts_->called(record.pc);
  counts_->add(record.pc, {1, record.cycles, record.causes, record.word});
  const auto [arrival, is_new] = arrivals_.try_emplace(record.word, 0);
  if (is_new) arrival->second = instructions_to_arrival(record.word);
  if (arrival->second != 0) {
    until_arrival_ = arrival->second;
    return_to_ = record.pc + static_cast<Address>(until_arrival_);
  }
  if (next_ != nullptr) next_->instruction(record);
}

void Profile::interrupt(const InterruptRecord& record) {
  until_arrival_ = 1;
  return_to_.reset();
  if (next_ != nullptr) next_->interrupt(record);
}

}  // namespace c40
