#pragma once
/// A probe gets chosen instructions and accesses of a chip, without changing anything. Other instructions cost nothing
/// more: blocks end before chosen instructions, and chosen words are in areas of their own.
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "c40/values/types.hpp"

namespace c40 {

/// An access to a chosen word, after it.
struct ProbedAccess {
  Address address = 0;
  Word before = 0;  ///< for memory: the word's old value; else the value read or written
  Word value = 0;   ///< the value read or written
  bool write = false;
  bool interrupt = false;  ///< the entry to an interrupt saves the PC
  int channel = -1;        ///< the DMA channel; -1: the processor
  Address pc = 0;          ///< address of the instruction; for the DMA: the processor's PC
  /// The access has been done in a chip that was run up to here: for an instruction, when the next one begins.
  Cycles cycle = 0;
};

/// Must not change the chip.
class Probe {
 public:
  virtual ~Probe() = default;
  /// A chosen instruction is next, from this cycle on; called once for a cycle.
  virtual void reaches(Address pc, Cycles cycle) = 0;
  virtual void accessed(const ProbedAccess& access) = 0;
  /// The chip stops before SWI, which calls a debugger.
  virtual void called(Address /*pc*/, Cycles /*cycle*/) {}
};

struct AddressRange {
  Address first = 0;
  Word words = 1;
  bool contains(Address address) const { return address - first < words; }
  friend bool operator==(const AddressRange&, const AddressRange&) = default;
};

/// What a probe gets.
struct ProbePlan {
  std::set<Address> code;          ///< before the instructions at these addresses
  std::vector<AddressRange> data;  ///< after accesses to these addresses: memory, peripheral registers, windows
};

/// A chip's probe, if it has one.
class ProbePoint {
 public:
  void set(Probe* probe, ProbePlan plan) {
    probe_ = probe;
    plan_ = probe == nullptr ? ProbePlan{} : std::move(plan);
    on_code_ = !plan_.code.empty();
    on_data_ = !plan_.data.empty();
    reported_.reset();
  }
  bool on_code() const { return on_code_; }
  bool on_data() const { return on_data_; }
  bool at(Address pc) const { return on_code_ && plan_.code.contains(pc); }
  bool sees(Address address) const {
    for (const AddressRange& range : plan_.data)
      if (range.contains(address)) return true;
    return false;
  }
  void reaches(Address pc, Cycles cycle) {
    if (reported_ == cycle || !at(pc)) return;
    reported_ = cycle;
    probe_->reaches(pc, cycle);
  }
  /// The chip's state was replaced: the same cycle may come again.
  void restart() { reported_.reset(), noted_.clear(); }
  /// Drops the accesses of an instruction that may not take place.
  void forget() { noted_.clear(); }
  void note(const ProbedAccess& access) {
    if (sees(access.address)) noted_.push_back(access);
  }
  void called(Address pc, Cycles cycle) {
    if (probe_ != nullptr) probe_->called(pc, cycle);
  }
  bool has_noted() const { return !noted_.empty(); }
  /// The instruction is complete.
  void tell_noted(Address pc, Cycles cycle) {
    for (ProbedAccess& access : noted_) {
      access.pc = pc, access.cycle = cycle;
      probe_->accessed(access);
    }
    noted_.clear();
  }
  void tell(const ProbedAccess& access) {
    if (sees(access.address)) probe_->accessed(access);
  }

 private:
  Probe* probe_ = nullptr;
  ProbePlan plan_;
  bool on_code_ = false, on_data_ = false;
  std::optional<Cycles> reported_;
  std::vector<ProbedAccess> noted_;
};

}  // namespace c40
