#pragma once
/// The DMA coprocessor (c40-hardware.md 3): six channels, in split mode twelve halves, take turns on one internal bus:
/// a read, then its write. It runs by itself; processor and DMA meet only at memory ports and buses.
///
/// Inaccuracies: the quirks of 3.9 are not modelled. The registers of a list take effect together, when the last one
/// has been read. A DMA read of a word that the processor writes in the same cycle, or in the next, sees the new word.
#include <array>
#include <optional>
#include <vector>

#include "c40/peripherals/dma_registers.hpp"
#include "c40/peripherals/dma_wait.hpp"
#include "c40/pipeline/timing.hpp"

namespace c40 {

/// Half a channel: all of a unified channel, or the primary or auxiliary half in split mode.
struct DmaHalf {
  bool has_data = false;  ///< a word was read and not yet written
  Word data = 0;
  bool listing = false;  ///< reading a list of register values
  std::uint8_t listed = 0;
  std::array<Word, 7> list{};
  Address list_at = 0;
  Cycles since = 0;  ///< when the half was started, or its last access was done
  Cycles first = 0;  ///< no access before this cycle
  friend bool operator==(const DmaHalf&, const DmaHalf&) = default;
};

struct DmaChannel {
  std::array<Word, dma_register_count> registers{};  ///< by DmaRegister; control without STATUS
  std::array<DmaHalf, 2> halves{};                   ///< primary or unified, auxiliary
  bool read_event = false, write_event = false;      ///< latched by the sources that DIE selects
  bool auxiliary_first = false;                      ///< split mode: the primary half was served last
  Word& operator[](DmaRegister r) { return registers[static_cast<std::size_t>(r)]; }
  Word operator[](DmaRegister r) const { return registers[static_cast<std::size_t>(r)]; }
  friend bool operator==(const DmaChannel&, const DmaChannel&) = default;
};

/// The DMA coprocessor's whole state.
struct DmaState {
  std::array<DmaChannel, dma_channel_count> channels{};
  Cycles now = 0;                 ///< all cycles before are done
  std::int8_t current = -1;       ///< the half that owns the internal bus: 2 * channel + half
  std::int8_t last = -1;          ///< the half served last
  std::int8_t ended = -1;         ///< the half whose block ends in cycle `now`
  bool waits_for_answer = false;  ///< `current` has an access to a window under way
  Cycles answered_until = 0;      ///< the end of the last access to a window
  Cycles conflict =
      -2;  ///< priority 01: the cycle of the last conflict with the processor, and whether the DMA lost it
  bool lost = false;
  friend bool operator==(const DmaState&, const DmaState&) = default;
};

/// The place of an address, for the DMA.
struct DmaPlace {
  enum class Kind : std::uint8_t { memory, peripheral, port, window, nothing } kind = Kind::nothing;
  Access access{};
};

/// The rest of the chip, as the DMA coprocessor uses it.
class DmaContext {
 public:
  virtual ~DmaContext() = default;
  virtual DmaPlace place(Address address, bool write) = 0;
  virtual Word read(Address address, Cycles at) = 0;
  virtual void write(Address address, Word value, Cycles at) = 0;
  /// An input FIFO has a word, or an output FIFO has room.
  virtual bool port_ready(Address address, bool write) const = 0;
  /// If the event of code `code` of DIE is a level, this level; nothing if the event is latched.
  virtual std::optional<bool> level(int channel, bool write, Word code) const = 0;
  virtual Word dma_interrupt_enable() const = 0;
  /// The cycles of an access; the first is at `from` or later and before `limit`. Nothing if the processor delays the
  /// access longer.
  struct Span {
    Cycles begin = 0, end = 0;
  };
  virtual std::optional<Span> acquire(const DmaPlace& place, Cycles from, Cycles limit, Word priority) = 0;
  /// The control word started a half of a channel, or both, in cycle `at`.
  virtual void started(int channel, Word control, Cycles at) = 0;
  /// A block of a channel has ended in cycle `at`; `interrupt`: the processor gets an interrupt.
  virtual void block_ended(int channel, bool auxiliary, bool interrupt, Cycles at) = 0;
};

/// An access of the DMA that the chip cannot complete alone.
struct DmaRequest {
  int channel = 0;
  bool write = false;
  Address address = 0;
  Word value = 0;
  Cycles cycle = 0;
  bool nothing_there = false;  ///< a fault, not a window
};

class Dma {
 public:
  Dma(DmaState& state, DmaContext& context) : s_(state), context_(context) {}

  Word read(int channel, DmaRegister reg) const;
  /// A write of the processor in cycle `at`. A half that it starts begins in the next cycle or later.
  void write(int channel, DmaRegister reg, Word value, Cycles at);
  /// DIE was `before` until cycle `at`. A half that waits for another event now begins in the next cycle or later.
  void interrupt_enable_changed(Word before, Cycles at);
  void reset();
  /// Executes everything before `limit`. Stops before an access that the chip cannot complete, and after an access to a
  /// linked port.
  /// \return the access to a window, or to an address where nothing is; answer it with `answer`.
  std::optional<DmaRequest> advance_to(Cycles limit);
  /// The same, if it is not busy and no end of a block is to be done.
  void rest_until(Cycles limit);
  /// The access to a window ends in cycle `at`; the DMA continues there.
  void answer(Word value, Cycles at);
  /// A half could continue now: it is started and waits for no event or FIFO.
  bool busy() const;
  /// Its last access is done; the end of the block, with the interrupt, is still to come.
  bool ends() const { return s_.ended >= 0; }
  /// The end of a block is still to be done in cycle `limit` itself.
  bool ends_at(Cycles limit) const { return ends() && s_.now <= limit; }
  /// Does the end of the block.
  void end();
  /// The waits of started halves that could not continue now.
  std::vector<DmaWait> waits() const;
  /// A channel is started, and may be waiting; or the end of its block is still to come.
  bool active() const;
  /// The ports that started channels use: bit n.
  Word ports_used() const;
  /// Latches an event for the channels whose DIE fields select it. `codes` gives the event's code for each channel and
  /// direction.
  template <class Selects>
  bool latch(Selects selects) {
    bool any = false;
    for (int c = 0; c < dma_channel_count; ++c) {
      if (at_rest(c)) continue;
      for (bool write : {false, true})
        if (latches_for(c, write) && selects(c, write, event_code(c, write))) {
          (write ? channel(c).write_event : channel(c).read_event) = true;
          any = true;
        }
    }
    return any;
  }
  /// Whether an event would be latched.
  template <class Selects>
  bool latches(Selects selects) const {
    for (int c = 0; c < dma_channel_count; ++c) {
      if (at_rest(c)) continue;
      for (bool write : {false, true})
        if (latches_for(c, write) && selects(c, write, event_code(c, write))) return true;
    }
    return false;
  }
  /// When the last access of all halves was done, or a half was started.
  Cycles last_done() const;
  /// Stops the present advance after an access to a linked port, or where the channels may begin to use another port.
  bool stop_requested = false;

 private:
  struct Half {
    int channel = 0, half = 0;
  };
  DmaChannel& channel(int c) { return s_.channels[static_cast<std::size_t>(c)]; }
  const DmaChannel& channel(int c) const { return s_.channels[static_cast<std::size_t>(c)]; }
  DmaHalf& state(Half h) { return channel(h.channel).halves[static_cast<std::size_t>(h.half)]; }
  const DmaHalf& state(Half h) const { return channel(h.channel).halves[static_cast<std::size_t>(h.half)]; }
  Word word_of(Half h) const { return channel(h.channel)[DmaRegister::control]; }
  static Half half_of(int index) { return {index / 2, index % 2}; }

  bool split(int c) const { return dma_control::SPLIT.in(channel(c)[DmaRegister::control]); }
  // Neither half is started. This is the usual state of most channels.
  bool at_rest(int c) const {
    return (channel(c)[DmaRegister::control] & (dma_control::START.mask() | dma_control::AUX_START.mask())) == 0;
  }
  bool latches_for(int c, bool write) const;
  /// START or AUX START. Without SPLIT MODE the auxiliary half is in reset.
  Word start(Half h) const;
  std::array<Word, 2> starts(int c) const { return {start({c, 0}), start({c, 1})}; }
  void reset_halves(int c);
  void start_halves(int c, const std::array<Word, 2>& before, Cycles at, Cycles first);
  bool begins_with_list(Half h) const;
  void set_start(Half h, Word value);
  Word mode(Half h) const;
  DmaRegister counter_of(Half h) const { return h.half == 1 ? DmaRegister::auxiliary_counter : DmaRegister::counter; }
  DmaRegister link_of(Half h) const { return h.half == 1 ? DmaRegister::auxiliary_link : DmaRegister::link; }
  Word event_code(int c, bool write) const { return event_code(c, write, context_.dma_interrupt_enable()); }
  static Word event_code(int c, bool write, Word die);
  bool event_ready(int c, bool write) const;
  void take_event(int c, bool write);
  bool synchronised(Half h) const;
  Address address(Half h) const;
  bool ready(Half h) const;
  bool runs(Half h) const;
  std::optional<int> pick() const;
  bool step(Cycles limit, std::optional<DmaRequest>& request);
  void done(Half h, bool divided, Word value, Cycles end);
  void served(Half h, bool divided);
  void end_block(Half h, Cycles at);
  void move(Word& address, Word index, bool reversed);
  void begin_list(Half h);
  void load_list(Half h, bool divided);

  DmaState& s_;
  DmaContext& context_;
};

/// DMA registers are at 1000A0h + 10h * channel (c40-hardware.md 1.3).
bool is_dma_register(Address address);
int dma_channel_of(Address address);
DmaRegister dma_register(Address address);

}  // namespace c40
