#pragma once
/// A program's cycles per instruction, and per routine as it was called. The profile listens to the trace, so it adds
/// up exactly what the chip accounted.
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include "c40/chip/chip.hpp"

namespace c40 {

/// Counts per address, and the number of calls of each place.
class ProfileCounts {
 public:
  struct Entry {
    std::uint64_t instructions = 0;
    Cycles cycles = 0;
    Causes causes{};
    Word word = 0;  ///< the instruction, as last executed
    void add(const Entry& other);
  };

  void add(Address address, const Entry& entry) { at(address).add(entry); }
  void called(Address address, std::uint64_t times = 1) { calls_[address] += times; }
  void add(const ProfileCounts& other);
  /// Clears all counts; their memory is kept.
  void clear();

  /// By address.
  std::map<Address, Entry> instructions() const;
  const std::map<Address, std::uint64_t>& calls() const { return calls_; }
  Entry total() const;

 private:
  static constexpr Address page_words = 1024;
  using Page = std::array<Entry, page_words>;
  Entry& at(Address address);

  std::unordered_map<Address, std::unique_ptr<Page>> pages_;  // by number; their order does not matter
  Page* page_ = nullptr;                                      // the last one used
  Address page_number_ = 0;
  std::vector<Address> touched_;
  std::map<Address, std::uint64_t> calls_;
};

/// A place that was called or interrupted to, or the program's start; it extends to the next such place.
struct Routine {
  std::uint64_t calls = 0;
  ProfileCounts::Entry own;  ///< without the routines that it called
};
/// All counts by routine. \param starts further addresses at which routines begin, besides the called ones
std::map<Address, Routine> routines(const ProfileCounts& counts, const std::set<Address>& starts);

/// Counts one chip's instructions and calls.
class Profile final : public TraceSink {
 public:
  /// \param counts must outlive this object or be replaced by count_into. \param next gets everything too; may be null.
  explicit Profile(ProfileCounts& counts, TraceSink* next = nullptr) : counts_(&counts), next_(next) {}
  void count_into(ProfileCounts& counts) { counts_ = &counts; }
  void hand_on_to(TraceSink* next) { next_ = next; }

  void instruction(const TraceRecord& record) override;
  void interrupt(const InterruptRecord& record) override;

 private:
  ProfileCounts* counts_;
  TraceSink* next_;
  std::unordered_map<Word, int>
      arrivals_;  ///< per instruction word: number of instructions until the called routine begins; 0 for no call
  int until_arrival_ = 0;             ///< instructions until the first one of a called routine; 0: no call under way
  std::optional<Address> return_to_;  ///< the return address of the call under way: reached if the call was not taken
};

}  // namespace c40
