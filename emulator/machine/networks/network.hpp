#pragma once
/// Networks of chips: up to 64, each with its own program, board and clock, connected by links between communication
/// ports, by memories that several of them access, and by nets between their pins (docs/networks.md).
///
/// Order: machine/time/scheduler.hpp. A chip runs ahead as long as it uses only its own resources, and stops before it
/// accesses a linked port or a shared memory. A chip whose ports can interrupt it or move its DMA, or that has a net at
/// its pins, runs no further than the earliest effect on it. At one instant: links, nets, actions, chips by their
/// numbers.
///
/// Inaccuracies: a wait that is cut short by a reset, a hold or the end of the run is not counted under the cause
/// "communication port": up to the reset or hold the chip counts as halted; at the end its count stops where the wait
/// began. An access of the DMA to a shared memory makes its processor's access wait, whatever that accesses. A program
/// that polls a value that never changes is found only if no timer of its chip runs, and some ten thousand cycles after
/// the last event.
#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/peripherals/events.hpp"
#include "c40/peripherals/link.hpp"
#include "io/text_error.hpp"
#include "machine/boards/board_devices.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/boards/board_reserved.hpp"
#include "machine/networks/net.hpp"
#include "machine/time/scheduler.hpp"
#include "machine/time/time.hpp"
#include "state/file.hpp"
#include "toolchain/objects/image.hpp"

namespace state {
class Visitor;
}

namespace machine {

/// An impossible network. The message names chip, port or link, and what would be right.
class NetworkError : public io::TextError<std::invalid_argument> {
 public:
  using TextError::TextError;
};

inline constexpr std::size_t most_chips = 64;
inline constexpr double default_clock_mhz = 40;  ///< CLKIN, for a board without clock_mhz

/// One end of a link.
struct PortName {
  std::size_t chip = 0;
  int port = 0;
  friend auto operator<=>(const PortName&, const PortName&) = default;
};
/// "0.3"; also with a chip's name, "root.3". \throws NetworkError
PortName parse_port(std::string_view text, const std::vector<std::string>& chips);
std::string to_text(const PortName& port);

struct NetworkLink {
  PortName a, b;
  c40::LinkParameters parameters;
};
/// "0.3:1.0". \throws NetworkError
NetworkLink parse_link(std::string_view text, const std::vector<std::string>& chips);
std::string to_text(const NetworkLink& link);

struct NetworkChip {
  std::string name;  ///< empty: the chip's number
  std::shared_ptr<const toolchain::Image> program;
  BoardDescription board{.board = c40::Board::default_board()};
  std::optional<double> clock_mhz;           ///< overrides the board's
  std::optional<c40::Address> entry, until;  ///< `until`: the chip has ended before the instruction at this address
  /// The chip starts as after its RESET pin. If the board has no [pins], or they select the ports, it starts in the
  /// boot ROM, which takes its program from the first port that gives one; `program` then only describes the expected
  /// program (symbols, lines, ends) and may be null.
  bool boot = false;
  /// Writes further words to its memory, after its program and before its start; null: none.
  std::function<void(c40::Chip&)> add_words{};
  bool is_in_rom = false;  ///< it boots what the board's ROMs hold: `program` only lends its symbols, lines and ends
  /// Behind windows of its board, besides the board's own.
  std::vector<BoardDevices::Place> devices{};
  bool is_alone = false;                   ///< no network: R0 to R3 are those of a reset
  std::vector<c40::Address> other_ends{};  ///< as `until`
};

/// A memory that several chips access through windows of their boards. It does one access at a time; after an
/// interlocked load of a chip, all other chips wait until the same chip's interlocked store.
///
/// A dual-port memory has two sides with a bus each: the later access waits (BUSY) only if both sides access the same
/// word. It has no locks. Its two last words are mailboxes: a write of the first side to the last word pulls the pin of
/// the second side low, until that side reads the word; the last but one is for the other direction (IDT7016 data
/// sheet, "Interrupts"; the same in IDT7130 and CY7C13x).
struct SharedMemory {
  std::string name;
  c40::Address words = 0;
  int waits = 0;  ///< cycles of an access beyond one, in cycles of the accessing chip
  std::vector<std::pair<std::size_t, c40::Address>> places;  ///< chip and address of word 0
  bool dual_port = false;
  std::vector<std::optional<c40::Pin>> pins{};  ///< by place, in a dual-port memory; may be fewer
};

struct NetworkAction {
  enum class Kind : std::uint8_t {
    cut,
    restore,  ///< a link
    reset,    ///< a chip starts again at its entry; memory stays, the contents of its ports are lost
    hold,
    release,   ///< a chip leaves reset and continues where it was
    pull_out,  ///< a chip is held in reset and its links are cut
    low,
    high,
    open,  ///< a net loses its driver
    pulse  ///< a net leaves its level at rest for `width`: `count` times, every `period`; without end if `count` is 0
  } kind = Kind::cut;
  Time time{};
  std::size_t target = 0;  ///< number of the link, chip or net
  Time width{0}, period{0};
  std::uint64_t count = 1;
};
std::string_view name(NetworkAction::Kind kind);
/// The object of an action.
enum class ActionTarget : std::uint8_t { link, chip, net };
ActionTarget target_of(NetworkAction::Kind kind);
std::string_view name(ActionTarget target);
/// \throws NetworkError
NetworkAction::Kind action_named(std::string_view text);
/// The number of the link between these ends, in either order. \throws NetworkError
std::size_t link_named(std::string_view text, const std::vector<std::string>& chips,
                       const std::vector<NetworkLink>& links);
/// By its name or number. \throws NetworkError
std::size_t chip_named(std::string_view text, const std::vector<std::string>& chips);

struct NetworkDescription {
  std::vector<NetworkChip> chips;
  std::vector<NetworkLink> links;
  std::vector<SharedMemory> memories;
  std::vector<NetDescription> nets;
  std::vector<NetworkAction> actions;
  /// The initial values of R2 and R3 in all chips: columns and rows of a grid or torus, else number of chips and 1.
  std::array<c40::Word, 2> shape{};
};

/// The number of the link, chip or net of this name. \throws NetworkError
std::size_t action_target_named(NetworkAction::Kind kind, std::string_view text, const NetworkDescription& network);
/// Each end exists, and a port has at most one link. \throws NetworkError
void check(const std::vector<NetworkLink>& links, std::size_t chips);
/// \param count none: one pulse, or with a period pulses without end
void set_pulses(NetworkAction& action, double width_us, std::optional<double> period_us,
                std::optional<std::uint64_t> count);
/// "12.5,cut,0.3:1.0", "20,reset,1", "5,low,sync", "5,pulse,index,WIDTH_US[,PERIOD_US[,COUNT]]". \throws NetworkError
NetworkAction parse_action(std::string_view text, const NetworkDescription& network);

/// Sets links and shape of "ring:4", "line:4", "grid:4x4", "torus:4x4x2", "hypercube:16"; returns the number of chips.
/// \throws NetworkError
std::size_t set_topology(NetworkDescription& network, std::string_view text);

/// Links of generated topologies, over the ports given in docs/networks.md.
/// \param size of each of one to three dimensions
std::vector<NetworkLink> grid_links(const std::vector<std::size_t>& size, bool closed);
std::vector<NetworkLink> hypercube_links(unsigned dimensions);

/// An event of a link, net or chip. Losses, cuts, actions and missed pulses are always recorded; words, tokens and
/// edges on request.
struct NetworkEvent {
  enum class Kind : std::uint8_t {
    word,
    token,
    lost,
    dead,
    cut,
    restored,
    rise,
    fall,
    missed,
    discarded,
    reset,
    hold,
    release,
    pull_out
  };
  Kind kind = Kind::word;
  Time time{};
  std::size_t place = 0;  ///< number of the link; for kinds from `rise` on of the net, from `discarded` on of the chip
  int side =
      0;  ///< the link's side that sends, or gets the token; the port of `discarded`; the chip that missed a pulse
  c40::Word word = 0;
  int count =
      0;  ///< bytes of a lost word that had crossed; for `discarded` 1: it was in the input FIFO, 0: in the output FIFO
};
std::string_view name(NetworkEvent::Kind kind);
/// Recorded only on request.
constexpr bool is_common(NetworkEvent::Kind kind) {
  using enum NetworkEvent::Kind;
  return kind == word || kind == token || kind == rise || kind == fall;
}

/// An event of a chip's peripherals, recorded on request.
struct ChipEvent {
  std::size_t chip = 0;
  Time time{};  ///< the beginning of the cycle
  c40::PeripheralEvent event;
};

/// The properties that must be equal for a chip's state to fit, as text.
std::string configuration_of(const c40::Board& board);
std::string configuration_of(const toolchain::Image& image);

/// The status of a chip.
enum class ChipStatus : std::uint8_t {
  running,
  waiting,   ///< before an access to a port or a shared memory; or its DMA waits for an event or a FIFO, and the
             ///< processor waits for nothing else
  looping,   ///< repeats a loop forever, unless something that the loop reads changes
  sleeping,  ///< IDLE; a port could wake it
  halt,      ///< branch to itself, and no interrupt will come
  idle,      ///< IDLE, and no interrupt will come
  until,     ///< reached its `until`
  fault,
  external_access,  ///< an access to a window without a device
  held,
  pulled_out
};
std::string_view name(ChipStatus status);

struct NetworkStop {
  enum class Reason : std::uint8_t {
    ended,     ///< every processor has ended or sleeps, and nothing can wake one; a DMA may be armed
    deadlock,  ///< no event is left except exchanges of tokens, and a processor waits, polls, or sleeps for a DMA that
               ///< waits
    limit,
    interrupted,  ///< io::stop_asked(); run_until may be called again
  } reason = Reason::limit;
  Time time{};
};
std::string_view name(NetworkStop::Reason reason);

class Network {
 public:
  /// \throws NetworkError for an impossible network, before anything runs.
  explicit Network(NetworkDescription description, std::uint64_t turn_order = 0);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Executes everything before `limit`, unless io::stop_asked(). \throws std::logic_error if words do not add up.
  NetworkStop run_until(Time limit);
  Time now() const { return now_; }
  /// The complete state: chips, links, memories, future actions, and the events so far. Only between runs.
  void list_state(state::Visitor& list);
  /// The properties that must be equal in a network that loads such a state.
  state::Key configuration() const;

  const NetworkDescription& description() const { return description_; }
  std::size_t chip_count() const { return nodes_.size(); }
  /// If a chip `waits`, its cycle() is the cycle in which the access began to wait.
  c40::Chip& chip(std::size_t n);
  const c40::Chip& chip(std::size_t n) const;
  /// The chip's accesses to addresses without memory, if its board ignores them.
  const IgnoredAccesses& ignored(std::size_t n) const;
  const std::string& chip_name(std::size_t n) const;
  const toolchain::Image& program(std::size_t n) const;
  const Clock& clock(std::size_t n) const;
  ChipStatus status(std::size_t n) const;
  /// One sentence: why the chip stopped; or for what it waits, where and since when.
  std::string describe(std::size_t n) const;
  /// The chip stands before SWI: a fault, but in a debugger.
  bool calls_debugger(std::size_t n) const;
  /// The devices behind the windows of a chip's board; null: none.
  BoardDevices* devices(std::size_t n);
  /// The first cycle in which what its user types now can reach the devices of a chip.
  c40::Cycles present_cycle(std::size_t n) const;
  /// The chip at the other end of the link for which `n` waits.
  std::optional<std::size_t> waits_for(std::size_t n) const;

  std::size_t link_count() const { return links_.size(); }
  const c40::Link& link(std::size_t n) const { return *links_[n]; }
  const NetworkLink& ends(std::size_t n) const { return description_.links[n]; }
  std::size_t net_count() const { return nets_.size(); }
  const Net& net(std::size_t n) const { return *nets_[n]; }
  std::size_t memory_count() const { return description_.memories.size(); }
  std::span<c40::Word> memory(std::size_t n);
  /// A word of a shared memory, by the chip's address.
  struct MemoryPlace {
    std::size_t memory = 0;
    c40::Address word = 0;
  };
  std::optional<MemoryPlace> memory_place(std::size_t chip, c40::Address address) const;
  /// Called after every access to shared memories: the chip, the place, the word before; null: none. Changes nothing.
  using MemoryListener = std::function<void(std::size_t chip, MemoryPlace place, c40::Word before,
                                            const c40::ExternalAccess& access, Time time)>;
  void watch_memory(MemoryListener listener) { memory_listener_ = std::move(listener); }
  /// Changes a word of a chip between two runs; a register of a peripheral at the present instant, also of a chip that
  /// has ended before.
  void poke(std::size_t n, c40::Address address, c40::Word value);
  /// To be called after registers or words were changed: what had come to rest is looked at again. From inside a run,
  /// whose devices may change something, it does nothing.
  /// \param moved the chip whose PC was set: it does not wait for its access any more
  void changed_by_hand(std::optional<std::size_t> moved = {});
  /// Sets the sink of a chip's instructions; null: none. Changes nothing. Use this, not Chip::set_trace: the network
  /// listens too.
  void set_trace(std::size_t n, c40::TraceSink* sink);

  /// \throws NetworkError if the target does not exist or has been pulled out by then, or the time is past.
  void schedule(const NetworkAction& action);
  void record_words(bool on) { records_words_ = on; }
  /// By time; at one instant those of nets come last, by their numbers.
  std::vector<NetworkEvent> events() const;
  /// A line of an event trace (docs/networks.md): "123400000 word 0.0>1.3 0000002A"
  std::string text(const NetworkEvent& event) const;
  /// Records words, DMA transfers, timers and interrupts as the chips' peripherals see them, by time and then by chip.
  void record_peripherals(bool on);
  std::vector<ChipEvent> peripheral_events() const;
  /// "123400000 chip 0: port_write 3 = 0000002A (DMA 1)"
  std::string text(const ChipEvent& event) const;
  /// One line for each event of the links and of the chips, by time.
  std::vector<std::string> event_trace() const;

  /// For every direction of every link: words written = read + in FIFOs + under way + lost + discarded. \throws
  /// std::logic_error
  void check_words() const;

 private:
  struct Node;
  struct Memory;
  struct LinkTap;
  struct LinkTurn;
  struct ActionTurn;
  struct NetTap;
  struct DeviceTurn;

  NetworkStop run_slice(Time limit);
  std::optional<NetworkStop> stop_at_rest(Time limit);
  void join_links();
  void add_memories();
  void add_devices();
  void settle_devices();
  void add_pin_nets();
  void join_nets();
  void join_pin_nets();
  void take_part();
  void start(Node& node);
  void load(Node& node);
  void load_stream(Node& node, const toolchain::Image& image, const c40::Board& board);
  void ready_to_start(Node& node);
  void check_not_pulled_out(const NetworkAction& action) const;
  void add(const NetworkAction& action);
  Time effective(const NetworkAction& action) const;
  Time next_action() const;
  c40::Cycles next_action_on(const Node& node) const {
    return actions_.empty() ? never_cycle : find_next_action_on(node);
  }
  c40::Cycles find_next_action_on(const Node& node) const;
  bool quiet();
  bool waits_forever() const;
  bool polls(const Node& node) const;
  std::string describe_loop(const Node& node) const;
  std::string describe_dma(const Node& node) const;
  std::string whom(const Node& node, int port, bool write) const;
  std::optional<std::size_t> neighbour(const Node& node, int port) const;
  void link_happens(std::size_t number, Time time);
  void actions_happen(Time time);
  void perform(const NetworkAction& action);
  void perform_port(Node& node, c40::Cycles cycle);
  void perform_memory(Node& node);
  void perform_device(Node& node);
  void devices_acted();
  void tell_mailboxes(Memory& memory, std::size_t side, c40::Address word, bool write);
  void reset_chip(Node& node);
  void freeze(Node& node, ChipStatus status);
  void free_locks(const Node& node);
  std::string describe_wait(const Node& node) const;
  Time at_rest_since(Time at_least = Time{0}) const;
  NetworkStop finish(NetworkStop::Reason reason, Time end);
  Memory* memory_of(const Node& node, c40::Address address) const;
  std::string where(const Node& node) const;
  bool boots(const Node& node) const;
  std::string memories_of(const Node& node) const;

  NetworkDescription description_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<std::unique_ptr<c40::Link>> links_;
  std::vector<std::unique_ptr<LinkTap>> taps_;
  std::vector<std::unique_ptr<LinkTurn>> link_turns_;
  std::unique_ptr<ActionTurn> action_turn_;
  std::vector<std::unique_ptr<DeviceTurn>> device_turns_;
  std::vector<Node*> acting_;  ///< chips with devices that act on other chips
  std::vector<std::unique_ptr<Memory>> memories_;
  std::unique_ptr<NetTap> net_tap_;
  std::vector<std::unique_ptr<Net>> nets_;
  std::deque<NetworkAction> actions_;  ///< future ones, by time
  std::vector<NetworkEvent> events_, net_events_;
  Scheduler scheduler_;
  Time now_{0};
  void something_happened() { something_happened(now_); }
  /// \param at later than now, if it is an access of a chip that runs ahead
  void something_happened(Time at) { ++news_, happened_ = std::max(happened_, at); }
  std::uint64_t news_ = 0;  ///< on links, in shared memories, to chips: what could end a loop that polls
  Time happened_{0};        ///< the last of them
  /// The last thing on a link that was no mere exchange of the token, change of a pin, action, or event of a timer that
  /// came to a chip that did nothing.
  Time changed_{0};
  std::size_t moving_ = 0;  ///< a chip that was not at rest when last looked at
  Time ends_at_ = never;    ///< of a network that is quiet: when all have come to rest
  bool made_ = false;       ///< The constructor has ended: its chips may run.
  bool runs_ = false;       ///< inside run_until
  bool records_words_ = false;
  MemoryListener memory_listener_;
};

}  // namespace machine
