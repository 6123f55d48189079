#pragma once
/// The link between two communication ports: one token, one word at a time (c40-hardware.md 2.4 to 2.6). A link belongs
/// to neither chip: the owner of the chips advances it in time.
///
/// How to run a network. Each linked port of a chip has the link as its listener (Chip::attach). The chip then stops
/// before it accesses this port (StopInfo::Reason::port_access, with the cycle). The owner of chips and links does the
/// earliest such access first:
///
///     link.advance_to(clock.at(access.cycle));        // every link of that chip, at least the port's own
///     if (access.ready(chip.port(access.port)))       // else it waits: try again after the link's next event
///       chip.complete_port(cycle);                    // the access takes place there, at or after access.cycle
///
/// The link sees at t + enter_cycles what a chip does in its cycle t, so accesses of different chips at one instant may
/// come in any order. A link's events at an instant come before accesses at that instant. A chip that watches its ports
/// (Chip::watches_ports: interrupts or DMA wait for them) may run no further than the earliest of: next_event() of its
/// links; and, for each link, the earliest time at which the other end could act, plus lookahead().
///
/// Words are never duplicated, and every lost word is reported: at any time, for each direction,
///     sent (by the port) = received (by the other) + under way + lost.
///
/// Inaccuracies: a word takes whole cycles of the sending side, a token exchange whole cycles of the side that gets the
/// token, both from its next cycle on. The handshake of the bytes is not modelled. A side with a halted input channel
/// does not give the token away. A word does not begin while the other side's input FIFO is full.
#include <array>
#include <deque>
#include <optional>
#include <string>

#include "c40/peripherals/comm_port.hpp"
#include "c40/values/clock.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// In H1 cycles (c40-hardware.md 2.6); fidelity.md says which of them are known.
struct LinkParameters {
  int word_cycles = 5;   ///< cycles of the sender for one word, FIFO to FIFO
  int token_cycles = 6;  ///< cycles of the new owner from the request until it can send
  int enter_cycles = 1;  ///< from an access of the chip until the link sees it; at least 1
  int exit_cycles = 1;   ///< cycles of the receiver from the end of a word until the word can be read
  friend bool operator==(const LinkParameters&, const LinkParameters&) = default;
};

/// An event of a link.
struct LinkEvent {
  enum class Kind : std::uint8_t {
    word,      ///< `side` sent `word`: it left the output FIFO at `time`
    token,     ///< `side` has got the token
    lost,      ///< `word`, under way from `side`, is lost: `bytes` of its four bytes had crossed
    dead,      ///< after a reset of one side both or neither have the token: nothing moves until both are reset
    cut,       ///< the wires were cut
    restored,  ///< and connected again
  };
  Kind kind = Kind::word;
  Time time{};
  int side = 0;
  Word word = 0;
  int bytes = 0;
};
std::string_view name(LinkEvent::Kind kind);

class LinkListener {
 public:
  virtual ~LinkListener() = default;
  virtual void happened(const LinkEvent& event) = 0;
};

class Link {
 public:
  /// One end. `port` must outlive the link; the clock is that of the chip's cycles.
  struct Side {
    std::string name;  ///< the name in messages, "DSP 0 port 3"
    int number = 0;    ///< the number of the port
    CommPort* port = nullptr;
    PacedClock clock{Clock{20'000'000}};
  };

  /// Throws std::invalid_argument if both ends are one port, if both or neither have the token (boards connect one of
  /// ports 0 to 2 with one of 3 to 5), if the clocks differ by more than a factor of 2, or if a parameter is out of
  /// range.
  Link(Side first, Side second, LinkParameters parameters = {});
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// The listener of side 0 or 1, for Chip::attach.
  PortListener& listener(int side) { return ends_.at(static_cast<std::size_t>(side)); }

  /// The next instant at which the link changes by itself; `never` if only an access can change anything.
  Time next_event() const { return next_; }
  /// Only the token can move by itself: neither side can send a word, whichever has the token.
  bool only_exchanges_token() const;
  /// Executes everything up to and including `time`. Time never goes back.
  void advance_to(Time time);
  /// An access at one end changes what the other end sees no earlier than this much later.
  Time lookahead() const;
  void set_clock(int side, PacedClock clock) { ends_.at(static_cast<std::size_t>(side)).clock = clock; }

  /// Cuts the wires at `time`, not before the time already reached. A word under way is lost; a token exchange is not
  /// completed. Both ports keep their contents.
  void cut(Time time);
  void restore(Time time);
  bool is_cut() const { return cut_; }
  /// Both or neither have the token.
  bool is_dead() const { return ends_[0].port->token == ends_[1].port->token; }

  /// Words sent by `side`: arrived, under way, and lost on the way.
  struct Counters {
    std::uint64_t sent = 0, arrived = 0, lost = 0, tokens = 0;
    friend bool operator==(const Counters&, const Counters&) = default;
  };
  const Counters& counters(int side) const { return ends_.at(static_cast<std::size_t>(side)).counters; }
  /// Words of `side` that have left its FIFO and cannot be read yet.
  std::size_t under_way(int side) const { return ends_.at(static_cast<std::size_t>(side)).arriving.size(); }
  /// Names words that are missing from the account, as a sentence; nothing unless the model has a fault. For each
  /// direction: written = sent + discarded + in the output FIFO, sent = arrived + under way + lost, and arrived = read
  /// + discarded + in the input FIFO.
  std::optional<std::string> unbalanced() const;
  const std::string& name(int side) const { return ends_.at(static_cast<std::size_t>(side)).name; }
  const LinkParameters& parameters() const { return parameters_; }

  LinkListener* listener_of_events = nullptr;

  /// The words under way, and what the link has seen of the ports; the ports themselves are in the chips. Listeners and
  /// clocks stay.
  void list_state(state::Visitor& list);

 private:
  /// The part of a side's port that the link has seen so far.
  struct View {
    Time from{};  ///< when the link sees it
    std::uint64_t written = 0, read = 0;
    bool input_halted = false, output_halted = false;
    bool shows_the_same(const View& other) const {
      return written == other.written && read == other.read && input_halted == other.input_halted &&
             output_halted == other.output_halted;
    }
  };
  struct Arrival {
    Time time{};
    Word word = 0;
  };
  struct End final : PortListener {
    Link* link = nullptr;
    int side = 0;
    std::string name;
    CommPort* port = nullptr;
    PacedClock clock{Clock{20'000'000}};
    std::deque<View> views;  ///< not seen by the link yet
    View seen;
    Time requested = never;        ///< the time since which the side has something to send, as the link sees it
    bool has_sent = false;         ///< the side has sent a word since it got the token
    std::deque<Arrival> arriving;  ///< the side's words in their last cycle
    Counters counters;

    void changed(const CommPort& side, Cycles at) override;
    void about_to_reset(Cycles at) override;
    void was_reset(const CommPort& side, Cycles at) override;
    bool wants() const;
    void see(Time time);
    void list_state(state::Visitor& list);
  };
  enum class Action : std::uint8_t { none, word, token };

  void plan();
  void happen(Time time);
  void decide(Time time);
  void begin(Action action, int side, int cycles, Time time);
  void finish_word(Time time);
  void lose_word(Time time);
  bool can_send(const End& owner, const End& other) const;
  void tell(LinkEvent::Kind kind, Time time, int side, Word word = 0, int bytes = 0);

  LinkParameters parameters_;
  std::array<End, 2> ends_;
  bool cut_ = false;
  Action action_ = Action::none;
  int action_side_ = 0;  ///< the side that sends, or gets the token
  Time begins_{}, ends_at_{};
  Time next_ = never;  ///< the next event; kept by plan()
};

}  // namespace c40
