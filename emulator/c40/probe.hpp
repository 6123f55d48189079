#pragma once
/// Who is told of chosen instructions and accesses of a chip, while the chip goes on as if nobody looked. What is not
/// chosen costs nothing: blocks end before chosen instructions, and chosen words stand in areas of their own.
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "c40/types.hpp"

namespace c40 {

/// An access to a chosen word, after it.
struct ProbedAccess {
  Address address = 0;
  Word before = 0;  ///< of memory: what the word held; else the value read or written
  Word value = 0;   ///< read or written
  bool write = false;
  bool interrupt = false;  ///< the entry to an interrupt saves the PC
  int channel = -1;        ///< of the DMA; -1: the processor's
  Address pc = 0;          ///< of the instruction; of the DMA: where the processor stands
  Cycles cycle = 0;        ///< when it is done: of an instruction, when the next one begins
};

/// Must change nothing of the chip.
class Probe {
 public:
  virtual ~Probe() = default;
  /// A chosen instruction is next, from this cycle on; told once for a cycle.
  virtual void reaches(Address pc, Cycles cycle) = 0;
  virtual void accessed(const ProbedAccess& access) = 0;
};

struct AddressRange {
  Address first = 0;
  Word words = 1;
  bool contains(Address address) const { return address - first < words; }
  friend bool operator==(const AddressRange&, const AddressRange&) = default;
};

/// What a probe is told of.
struct ProbePlan {
  std::set<Address> code;          ///< before the instructions there
  std::vector<AddressRange> data;  ///< after accesses there: memory, peripheral registers, windows
};

/// A chip's probe, if it has one.
class ProbePoint {
 public:
  void set(Probe* probe, ProbePlan plan) {
    probe_ = probe;
    plan_ = probe == nullptr ? ProbePlan{} : std::move(plan);
    on_code_ = !plan_.code.empty();
    on_data_ = !plan_.data.empty();
    told_.reset();
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
    if (told_ == cycle || !at(pc)) return;
    told_ = cycle;
    probe_->reaches(pc, cycle);
  }
  /// The chip's state is another: the same cycle may come again.
  void restart() { told_.reset(), noted_.clear(); }
  /// Of an instruction that may yet not take place.
  void forget() { noted_.clear(); }
  void note(const ProbedAccess& access) {
    if (sees(access.address)) noted_.push_back(access);
  }
  bool has_noted() const { return !noted_.empty(); }
  /// The instruction is through.
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
  std::optional<Cycles> told_;
  std::vector<ProbedAccess> noted_;
};

}  // namespace c40
