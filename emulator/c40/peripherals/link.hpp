#pragma once
/// The link between two communication ports: one token, one word at a time (c40-hardware.md 2.4 to 2.6). It belongs to
/// neither chip: whoever owns several chips drives it, in time.
///
/// How a network is run. Each linked port of a chip has the link as its listener (Chip::attach); the chip then stops
/// before it touches that port (StopInfo::Reason::port_access, with the cycle). Whoever owns chips and links lets the
/// earliest such access happen first:
///
///     link.advance_to(clock.at(access.cycle));        // every link of that chip, at least the port's own
///     if (access.ready(chip.port(access.port)))       // else it waits: try again after the link's next event
///       chip.complete_port(cycle);                    // the access takes place there, at or after access.cycle
///
/// What a chip does in its cycle t is seen by the link at t + enter_cycles, so accesses of different chips at one
/// instant may come in any order. A link's events at an instant come before accesses at that instant. A chip that
/// watches its ports (Chip::watches_ports: interrupts or DMA wait for them) may be run no further than the earliest of:
/// next_event() of its links; and, for each link, the earliest time at which the other end could act, plus lookahead().
///
/// Words are never duplicated and never vanish unsaid: at any time, for each direction,
///     sent (by the port) = received (by the other) + under way + lost.
///
/// Inaccuracies: a word and a token exchange take whole cycles of the side that sends (that gets the token), beginning
/// at its next cycle; the bytes' handshake is not modelled. With a halted input channel a side does not give the token
/// away. A word is not begun while the other side's input FIFO has no room.
#include <array>
#include <deque>
#include <optional>
#include <string>

#include "c40/clock.hpp"
#include "c40/peripherals/comm_port.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// In H1 cycles (c40-hardware.md 2.6); fidelity.md says which are known.
struct LinkParameters {
  int word_cycles = 5;   ///< one word, FIFO to FIFO; of the sender
  int token_cycles = 6;  ///< from the request until the new owner can send; of the new owner
  int enter_cycles = 1;  ///< from an access of the chip until the link sees it; at least 1
  int exit_cycles = 1;   ///< from the end of a word until the receiver can read it; of the receiver
  friend bool operator==(const LinkParameters&, const LinkParameters&) = default;
};

/// What happened on a link.
struct LinkEvent {
  enum class Kind : std::uint8_t {
    word,      ///< `side` sent `word`: it left the output FIFO at `time`
    token,     ///< the token has arrived at `side`
    lost,      ///< `word`, on its way from `side`, is lost: `bytes` of its four had crossed
    dead,      ///< after a reset of one side both or neither hold the token: nothing moves until both are reset
    cut,       ///< the wires were cut
    restored,  ///< and joined again
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
    std::string name;  ///< as in messages, "DSP 0 port 3"
    int number = 0;    ///< of the port
    CommPort* port = nullptr;
    PacedClock clock{Clock{20'000'000}};
  };

  /// Throws std::invalid_argument if both ends are one port, if both or neither hold the token (boards join one of
  /// ports 0 to 2 with one of 3 to 5), if the clocks differ by more than a factor of 2, or if a parameter is out of
  /// range.
  Link(Side first, Side second, LinkParameters parameters = {});
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// To be given to Chip::attach. Side 0 or 1.
  PortListener& listener(int side) { return ends_.at(static_cast<std::size_t>(side)); }

  /// The next instant at which something changes by itself; `never` if only an access can change anything.
  Time next_event() const { return at_rest() ? never : next_of_what_moves(); }
  /// All that can happen by itself are exchanges of the token: neither side can send a word, whoever has it.
  bool only_exchanges_token() const;
  /// Lets everything up to and including `time` happen. Time never goes back.
  void advance_to(Time time);
  /// An access of one end cannot change what the other end sees earlier than this after it.
  Time lookahead() const;
  void set_clock(int side, PacedClock clock) { ends_.at(static_cast<std::size_t>(side)).clock = clock; }

  /// At `time`, which must not lie before what was advanced to: a word that is being sent is lost; a token exchange is
  /// not completed. Both ports keep what they hold.
  void cut(Time time);
  void restore(Time time);
  bool is_cut() const { return cut_; }
  /// Both or neither hold the token.
  bool is_dead() const { return ends_[0].port->token == ends_[1].port->token; }

  /// Words that left `side`: those that arrived, those under way and those lost on the way.
  struct Counters {
    std::uint64_t sent = 0, arrived = 0, lost = 0, tokens = 0;
    friend bool operator==(const Counters&, const Counters&) = default;
  };
  const Counters& counters(int side) const { return ends_.at(static_cast<std::size_t>(side)).counters; }
  /// Words of `side` that have left its FIFO and cannot be read yet.
  std::size_t under_way(int side) const { return ends_.at(static_cast<std::size_t>(side)).arriving.size(); }
  /// Words that neither arrived nor are accounted for, as a sentence; none unless the model has a fault. For each
  /// direction: written = sent
  /// + discarded + in the output FIFO, sent = arrived + under way + lost, and arrived = read + discarded + in the input
  /// FIFO.
  std::optional<std::string> unbalanced() const;
  const std::string& name(int side) const { return ends_.at(static_cast<std::size_t>(side)).name; }
  const LinkParameters& parameters() const { return parameters_; }

  LinkListener* listener_of_events = nullptr;

  /// What is on its way, and what it has seen of the ports, which are in the chips. Listeners and clocks stay.
  void list_state(state::Visitor& list);

 private:
  /// What the link has seen of a side's port so far.
  struct View {
    Time from{};  ///< when it comes to be seen
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
    std::deque<View> views;  ///< not seen yet
    View seen;
    Time requested = never;        ///< since when it has something to send, as seen
    bool has_sent = false;         ///< a word since it got the token
    std::deque<Arrival> arriving;  ///< its words on their last cycle
    Counters counters;

    void changed(const CommPort& side, Cycles at) override;
    void about_to_reset(Cycles at) override;
    void was_reset(const CommPort& side, Cycles at) override;
    bool wants() const;
    void list_state(state::Visitor& list);
  };
  enum class Action : std::uint8_t { none, word, token };

  /// So most links are, most of the time.
  bool at_rest() const {
    const auto quiet = [](const End& end) { return end.views.empty() && end.arriving.empty(); };
    return action_ == Action::none && quiet(ends_[0]) && quiet(ends_[1]);
  }
  Time next_of_what_moves() const;
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
  int action_side_ = 0;  ///< who sends, or gets the token
  Time begins_{}, ends_at_{};
};

}  // namespace c40
