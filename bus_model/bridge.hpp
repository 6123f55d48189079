#pragma once
// A bridge between a processor bus and PCI (plant-and-bus.md 3.6, ruling 25): posts writes in a FIFO and drains
// them in order, words at rising consecutive addresses as one burst; lets a read wait until the FIFO is empty; reads
// ahead to the end of an aligned line and answers the processor's next reads from it. The line is dropped by any write
// of this processor and by a read at or above prefetch_limit; another master's write leaves it stale, as in the real
// thing.
//
// The processor may run ahead of the bus: what it posts carries the clock of its issue, and the bus takes no word
// before its time.
#include <array>
#include <cstdint>

#include "bus_model/bus.hpp"

namespace pci {

/// A posted word.
struct Posted {
  Address address = 0;
  Word value = 0;
  Clocks clock = 0;        ///< when the processor issued it
  std::int64_t stamp = 0;  ///< the caller's own, for instance the exact time
};

class Bridge final : public Initiator {
 public:
  /// What the processor's side is told. Calls come from Bus::step or from Bridge::read.
  class Client {
   public:
    virtual ~Client() = default;
    /// The read's answer reaches the processor at clock `ready`; `arbitration` of the clocks since its issue went by
    /// without the bus.
    virtual void answered(Word value, Clocks ready, Clocks arbitration, Result result) = 0;
    /// The write that found the FIFO full has been taken at clock `ready`.
    virtual void taken(Clocks ready, Clocks arbitration) = 0;
    /// A posted word has reached its target, or its transaction was aborted.
    virtual void landed(const Posted& posted, Clocks clock, Result result) = 0;
  };

  struct Hit {
    Word value;
    Clocks ready;  ///< it may still be on its way
  };

  /// Becomes the bus's next master. Throws std::invalid_argument for a depth, line or latency timer that does not fit.
  Bridge(Bus& bus, const MasterConfig& master, const BridgeConfig& config, Client& client);

  unsigned master() const { return master_; }
  /// A write certainly finds room (more of it may appear with time).
  bool has_room() const { return count_ < config_.post_depth; }
  /// A write by the processor; clocks do not fall from call to call. Without room it waits (taken() follows) and the
  /// processor with it.
  void write(const Posted& posted);
  /// Answers from the line, when it holds the address.
  bool look_up(Address address, Hit& hit) const {
    if (address - line_address_ >= line_words_) return false;
    const Address word = address - line_address_;
    hit = {line_[word], line_first_ + static_cast<Clocks>(word) * line_step_};
    return true;
  }
  /// A read that the line cannot answer; answered() follows.
  void read(Address address, Clocks clock);
  /// The processor stands still until answered() or taken().
  bool blocked() const { return blocked_ != Blocked::no; }
  /// It is a write that waits for room.
  bool blocked_write() const { return blocked_ == Blocked::room; }
  /// No posted word and no read is left.
  bool idle() const { return count_ == 0 && !blocked(); }
  unsigned posted() const { return count_; }
  /// A read goes to the bus with nothing of this processor before it.
  bool is_clear() const { return !busy_ && count_ == 0; }
  /// Leaves the bus at clock `now` and forgets everything: reset, or pulled out.
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
  bool busy_ = false;      // our transaction is on the bus or asks for it
  bool answered_ = false;  // the read on the bus has given the processor its word
  Blocked blocked_ = Blocked::no;
  Address read_address_ = 0;
  Clocks blocked_since_ = 0;
  Clocks blocked_without_bus_ = 0;
  Posted waiting_{};
  Address line_address_ = 0;
  unsigned line_words_ = 0;
  Clocks line_first_ = 0;
  Clocks line_step_ = 0;
  std::array<Word, 64> line_{};
};

}  // namespace pci
