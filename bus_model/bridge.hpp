#pragma once
// A bridge between a processor bus and PCI (plant-and-bus.md 3.6, ruling 25). The bridge posts writes in a FIFO and
// drains them in order; words at rising consecutive addresses form one burst. A read waits until the FIFO is empty. The
// bridge reads ahead to the end of an aligned line, and answers the processor's next reads from this line. Any write of
// this processor, and a read at or above prefetch_limit, drops the line. A write of another master leaves the line
// stale, as in the real device.
//
// The processor may run ahead of the bus: each posted word carries the clock of its issue, and the bus takes no word
// before this clock.
#include <array>
#include <cstdint>

#include "bus_model/bus.hpp"

namespace pci {

/// A posted word.
struct Posted {
  Address address = 0;
  Word value = 0;
  Clocks clock = 0;  ///< when the processor issued it
  // The caller's own:
  std::int64_t stamp = 0;  ///< for instance the exact time
  std::uint64_t mark = 0;
};

class Bridge final : public Initiator {
 public:
  /// The processor's side of the bridge. Calls come from Bus::step or from Bridge::read.
  class Client {
   public:
    virtual ~Client() = default;
    /// The read's answer reaches the processor at clock `ready`. `arbitration` is how many clocks since the read's
    /// issue passed without the bus.
    virtual void answered(Word value, Clocks ready, Clocks arbitration, Result result) = 0;
    /// The write that found the FIFO full has got its place at clock `ready`.
    virtual void taken(Clocks ready, Clocks arbitration) = 0;
    /// A posted word has reached its target, or the word's transaction was aborted.
    virtual void landed(const Posted& posted, Clocks clock, Result result) = 0;
  };

  struct Hit {
    Word value;
    Clocks ready;  ///< the answer may still be under way
  };

  /// Becomes the bus's next master. Throws std::invalid_argument for a depth, line or latency timer that does not fit.
  Bridge(Bus& bus, const MasterConfig& master, const BridgeConfig& config, Client& client);

  unsigned master() const { return master_; }
  /// The FIFO certainly has room for a write (bus steps may free more room).
  bool has_room() const { return count_ < config_.post_depth; }
  /// A write by the processor; clocks do not fall from call to call. If the FIFO is full, the write and the processor
  /// wait, and taken() follows.
  void write(const Posted& posted);
  /// Answers from the line, if the line holds the address.
  bool look_up(Address address, Hit& hit) const {
    if (address - line_address_ >= line_words_) return false;
    const Address word = address - line_address_;
    hit = {line_[word], line_first_ + static_cast<Clocks>(word) * line_step_};
    return true;
  }
  /// A read that the line cannot answer; answered() follows. The processor may issue it ahead of the bus: `seen` is the
  /// first clock whose events come after the issue.
  void read(Address address, Clocks clock, Clocks seen = 0);
  /// The processor waits for answered() or taken().
  bool blocked() const { return blocked_ != Blocked::no; }
  /// The processor waits with a write, for room in the FIFO.
  bool blocked_write() const { return blocked_ == Blocked::room; }
  /// No posted word and no read remains.
  bool idle() const { return count_ == 0 && !blocked(); }
  unsigned posted() const { return count_; }
  /// Leaves the bus at clock `now` and drops all its words: the processor is reset or pulled out.
  void clear(Clocks now);
  void list_state(state::Visitor& list);

  unsigned framed(const Attempt& attempt, bool first, Clocks now, std::span<Word> room) override;
  void arriving(const Attempt& attempt, std::span<const Word> words) override;
  void completed(const Transaction& transaction, std::span<const Word> words) override;

 private:
  enum class Blocked : std::uint8_t { no, read, room };
  static constexpr unsigned most_posted = 64;

  void push(const Posted& posted, Clocks earliest);
  void submit_write(Clocks earliest);
  void submit_read(Clocks earliest);
  void answer(Word value, Clocks ready, Result result);
  const Posted& entry(unsigned i) const { return fifo_[(head_ + i) % most_posted]; }

  Bus& bus_;
  Client& client_;
  BridgeConfig config_;
  unsigned master_;
  std::array<Posted, most_posted> fifo_{};
  unsigned head_ = 0;
  unsigned count_ = 0;
  unsigned in_flight_ = 0;
  bool busy_ = false;      // this bridge's transaction is on the bus or requests the bus
  bool answered_ = false;  // the read on the bus has given the processor its word
  Blocked blocked_ = Blocked::no;
  Address read_address_ = 0;
  Clocks blocked_since_ = 0;
  Clocks seen_ = 0;  // events of the bus before this clock do not know of the wait
  Clocks blocked_without_bus_ = 0;
  Posted waiting_{};
  Address line_address_ = 0;
  unsigned line_words_ = 0;
  Clocks line_first_ = 0;
  Clocks line_step_ = 0;
  std::array<Word, 64> line_{};
};

}  // namespace pci
