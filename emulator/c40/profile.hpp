#pragma once
/// Where a program's cycles go: per instruction, and per routine as it was called. It listens to the trace, so that it adds up
/// exactly what the chip accounted.
#include <map>
#include <optional>

#include "c40/chip.hpp"

namespace c40 {

class Profile final : public TraceSink {
 public:
  struct Entry {
    std::uint64_t instructions = 0;
    Cycles cycles = 0;
    Causes causes{};
    void add(const Entry& other);
  };
  /// A place that was called, interrupted to, or where the program began; it reaches up to the next one.
  struct Routine {
    std::uint64_t calls = 0;
    Entry own;  ///< without what it called
  };

  /// \param entry where the program begins. \param next hears everything too; may be null and must outlive this.
  explicit Profile(Address entry, TraceSink* next = nullptr);

  void instruction(const TraceRecord& record) override;
  void interrupt(Word vector, Cycles cycle) override;

  /// By address.
  const std::map<Address, Entry>& instructions() const { return instructions_; }
  std::map<Address, Routine> routines() const;
  /// What belongs to no instruction: interrupt entries, idling. \param total the chip's causes of the same run.
  Causes outside(const Causes& total) const;

 private:
  TraceSink* next_;
  std::map<Address, Entry> instructions_;
  std::map<Address, std::uint64_t> calls_;
  int until_arrival_ = 0;             ///< instructions until the first one of a called routine; 0: no call under way
  std::optional<Address> return_to_;  ///< of the call under way: there if it was not taken
};

}  // namespace c40
