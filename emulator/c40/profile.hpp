#pragma once
/// Where a program's cycles go: per instruction, and per routine as it was called. It listens to the trace, so that it
/// adds up exactly what the chip accounted.
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include "c40/chip.hpp"

namespace c40 {

/// Counts per address, and how often each place was called.
class ProfileCounts {
 public:
  struct Entry {
    std::uint64_t instructions = 0;
    Cycles cycles = 0;
    Causes causes{};
    Word word = 0;  ///< the instruction, as it was executed last
    void add(const Entry& other);
  };

  void add(Address address, const Entry& entry) { at(address).add(entry); }
  void called(Address address, std::uint64_t times = 1) { calls_[address] += times; }
  void add(const ProfileCounts& other);
  /// Back to nothing; the room for the counts is kept.
  void clear();

  /// By address.
  std::map<Address, Entry> instructions() const;
  const std::map<Address, std::uint64_t>& calls() const { return calls_; }
  Entry total() const;

 private:
  static constexpr Address page_words = 1024;
  using Page = std::array<Entry, page_words>;
  Entry& at(Address address);

  std::unordered_map<Address, std::unique_ptr<Page>> pages_;  // by number; their order is never seen
  Page* page_ = nullptr;                                      // the last one used
  Address page_number_ = 0;
  std::vector<Address> touched_;
  std::map<Address, std::uint64_t> calls_;
};

/// A place that was called, interrupted to, or where the program began; it reaches up to the next one.
struct Routine {
  std::uint64_t calls = 0;
  ProfileCounts::Entry own;  ///< without what it called
};
/// Everything counted, by the routine that it lies in. \param starts where routines begin besides those that were
/// called here
std::map<Address, Routine> routines(const ProfileCounts& counts, const std::set<Address>& starts);

/// Counts one chip's instructions and calls.
class Profile final : public TraceSink {
 public:
  /// \param counts must outlive this or be replaced by count_into. \param next hears everything too; may be null.
  explicit Profile(ProfileCounts& counts, TraceSink* next = nullptr) : counts_(&counts), next_(next) {}
  void count_into(ProfileCounts& counts) { counts_ = &counts; }
  void hand_on_to(TraceSink* next) { next_ = next; }

  void instruction(const TraceRecord& record) override;
  void interrupt(Word vector, Cycles cycle) override;

 private:
  ProfileCounts* counts_;
  TraceSink* next_;
  std::unordered_map<Word, int>
      arrivals_;  ///< per instruction word: how many instructions after it the called routine begins; 0 for no call
  int until_arrival_ = 0;             ///< instructions until the first one of a called routine; 0: no call under way
  std::optional<Address> return_to_;  ///< of the call under way: there if it was not taken
};

}  // namespace c40
