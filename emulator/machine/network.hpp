#pragma once
/// Networks of chips: up to 64, each with its own program, board and clock, joined by links between communication
/// ports, by memories that several of them reach, and by nets between their pins (docs/networks.md).
///
/// Order: machine/scheduler.hpp. A chip runs ahead on what is its own and stops before it touches a linked port or a
/// shared memory. One whose ports can interrupt it, or move its DMA, or to whose pins a net leads, runs no further than
/// anything could reach it. Ties: links, nets, actions, chips by their numbers.
///
/// Inaccuracies: a wait that a reset, a hold or the end of the run cuts short is not among the chip's cycles by cause
/// as a wait for the port: up to the reset or hold the chip counts as halted, at the end its count stops where the wait
/// began. An access of the DMA to a shared memory lets its processor's access wait, whatever that is to. That a program
/// polls what nobody will ever change is found only if no timer of its chip runs, and some ten thousand cycles after
/// the last thing that happened.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "c40/chip.hpp"
#include "c40/peripherals/events.hpp"
#include "c40/peripherals/link.hpp"
#include "machine/board_devices.hpp"
#include "machine/board_file.hpp"
#include "machine/board_reserved.hpp"
#include "machine/net.hpp"
#include "machine/scheduler.hpp"
#include "machine/time.hpp"
#include "state/file.hpp"
#include "toolchain/objects/image.hpp"

namespace state {
class Visitor;
}

namespace machine {

/// A network that cannot be. The message names chip, port or link, and what would be right.
class NetworkError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

inline constexpr std::size_t most_chips = 64;
inline constexpr double default_clock_mhz = 40;  ///< CLKIN, of a board that does not say

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
  std::string name;  ///< empty: its number
  std::shared_ptr<const toolchain::Image> program;
  BoardDescription board{.board = c40::Board::default_board()};
  std::optional<double> clock_mhz;           ///< before the board's
  std::optional<c40::Address> entry, until;  ///< `until`: it has ended before the instruction there
  /// It starts as its RESET pin starts it. If the board says nothing of its pins, or they choose the ports: in the boot
  /// ROM, which takes its program from whichever port brings it one; `program` says only what is expected to come
  /// (symbols, lines, ends) and may be null.
  bool boot = false;
  bool is_in_rom = false;  ///< it boots what the board's ROMs hold: `program` only lends its symbols, lines and ends
  /// Behind windows of its board, besides the board's own.
  std::vector<BoardDevices::Place> devices{};
};

/// A memory that several chips reach through windows of their boards. One access at a time; an interlocked load keeps
/// all other chips out until the same chip's interlocked store.
///
/// A dual-port memory has two sides, each with a bus of its own: only when both meet the same word, the later one waits
/// (BUSY). It knows no locks. Its two last words are mailboxes: a write of the first side to the last word pulls the
/// pin of the second side low, until that side reads it; the last but one is that of the other direction (IDT7016 data
/// sheet, "Interrupts"; the same in IDT7130 and CY7C13x).
struct SharedMemory {
  std::string name;
  c40::Address words = 0;
  int waits = 0;  ///< cycles that an access takes beyond one, of the chip that makes it
  std::vector<std::pair<std::size_t, c40::Address>> places;  ///< chip and address of word 0
  bool dual_port = false;
  std::vector<std::optional<c40::Pin>> pins{};  ///< of the places, in a dual-port memory; may be fewer
};

struct NetworkAction {
  enum class Kind : std::uint8_t {
    cut,
    restore,  ///< a link
    reset,    ///< a chip starts anew at its entry; memory stays, what its ports hold is lost
    hold,
    release,   ///< a chip is held in reset, and goes on where it was
    pull_out,  ///< a chip is held and its links are cut
    low,
    high,
    open,  ///< a net is driven, and driven no more
    pulse  ///< a net leaves its level at rest for `width`; `count` times, or without end if that is 0, every `period`
  } kind = Kind::cut;
  Time time{};
  std::size_t target = 0;  ///< of links, chips or nets
  Time width{0}, period{0};
  std::uint64_t count = 1;
};
std::string_view name(NetworkAction::Kind kind);
/// What an action concerns.
enum class ActionTarget : std::uint8_t { link, chip, net };
ActionTarget target_of(NetworkAction::Kind kind);
std::string_view name(ActionTarget target);
/// \throws NetworkError
NetworkAction::Kind action_named(std::string_view text);
/// The number of the link that joins these ends, in either order. \throws NetworkError
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
  /// What chips find in R2 and R3 at their start: columns and rows of a grid or torus, else chips and 1.
  std::array<c40::Word, 2> shape{};
};

/// The number of the link, chip or net of this name. \throws NetworkError
std::size_t action_target_named(NetworkAction::Kind kind, std::string_view text, const NetworkDescription& network);
/// \param count none: one pulse, or with a period pulses without end
void set_pulses(NetworkAction& action, double width_us, std::optional<double> period_us,
                std::optional<std::uint64_t> count);
/// "12.5,cut,0.3:1.0", "20,reset,1", "5,low,sync", "5,pulse,index,WIDTH_US[,PERIOD_US[,COUNT]]". \throws NetworkError
NetworkAction parse_action(std::string_view text, const NetworkDescription& network);

/// Sets links and shape of "ring:4", "line:4", "grid:4x4", "torus:4x4x2", "hypercube:16"; returns the number of chips.
/// \throws NetworkError
std::size_t set_topology(NetworkDescription& network, std::string_view text);

/// Links of generated topologies, over the ports that docs/networks.md says.
/// \param size of each of one to three dimensions
std::vector<NetworkLink> grid_links(const std::vector<std::size_t>& size, bool closed);
std::vector<NetworkLink> hypercube_links(unsigned dimensions);

/// Something on a link or net, or to a chip. Always kept are losses, cuts, actions and edges that were missed; words,
/// tokens and edges if asked for.
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
  std::size_t place = 0;  ///< number of the link; of the net from `rise` on, of the chip from `discarded` on
  int side = 0;  ///< of the link: who sends, or gets the token; the port of `discarded`; the chip that missed an edge
  c40::Word word = 0;
  int count =
      0;  ///< bytes of a lost word that had crossed; of `discarded` 1 if it lay in the input FIFO, 0 in the output FIFO
};
std::string_view name(NetworkEvent::Kind kind);
/// Kept only if asked for.
constexpr bool is_common(NetworkEvent::Kind kind) {
  using enum NetworkEvent::Kind;
  return kind == word || kind == token || kind == rise || kind == fall;
}

/// What the peripherals of a chip did, kept if asked for.
struct ChipEvent {
  std::size_t chip = 0;
  Time time{};  ///< of the cycle's beginning
  c40::PeripheralEvent event;
};

/// What must be the same for a chip's state to fit: as text.
std::string configuration_of(const c40::Board& board);
std::string configuration_of(const toolchain::Image& image);

/// How a chip stands.
enum class ChipStatus : std::uint8_t {
  running,
  waiting,   ///< before an access to a port or a shared memory; or its DMA waits for an event or a FIFO, and it for
             ///< nothing else
  looping,   ///< goes round a loop for ever, unless something that it reads there changes
  sleeping,  ///< IDLE; a port could wake it
  halt,      ///< branch to itself with no interrupt to come
  idle,      ///< IDLE with no interrupt to come
  until,     ///< reached its `until`
  fault,
  external_access,  ///< an access to a window with nothing behind it
  held,
  pulled_out
};
std::string_view name(ChipStatus status);

struct NetworkStop {
  enum class Reason : std::uint8_t {
    ended,     ///< every processor has ended or sleeps, and nothing can wake one; a DMA may be armed
    deadlock,  ///< nothing but tokens to and fro can happen any more, and a processor waits, polls, or sleeps for a DMA
               ///< that waits
    limit,
    interrupted,  ///< io::stop_asked(); run_until goes on
  } reason = Reason::limit;
  Time time{};
};
std::string_view name(NetworkStop::Reason reason);

class Network {
 public:
  /// \throws NetworkError for what cannot be, before anything runs.
  explicit Network(NetworkDescription description, std::uint64_t turn_order = 0);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Lets everything before `limit` happen, unless io::stop_asked(). \throws std::logic_error if words do not add up.
  NetworkStop run_until(Time limit);
  Time now() const { return now_; }
  /// Everything that lasts: chips, links, memories, actions to come, and the events so far. Only between runs.
  void list_state(state::Visitor& list);
  /// What must be the same in a network that such a state is loaded into.
  state::Key configuration() const;

  const NetworkDescription& description() const { return description_; }
  std::size_t chip_count() const { return nodes_.size(); }
  /// Of a chip that `waits`, cycle() is where the access begins to wait.
  c40::Chip& chip(std::size_t n);
  const c40::Chip& chip(std::size_t n) const;
  /// The chip's accesses to addresses without memory, of a board that ignores them.
  const IgnoredAccesses& ignored(std::size_t n) const;
  const std::string& chip_name(std::size_t n) const;
  const toolchain::Image& program(std::size_t n) const;
  const Clock& clock(std::size_t n) const;
  ChipStatus status(std::size_t n) const;
  /// One sentence: why the chip stopped, or for whom it waits, where and since when.
  std::string describe(std::size_t n) const;
  /// What stands behind the windows of a chip's board; null: nothing.
  BoardDevices* devices(std::size_t n);
  /// The chip at the other end of what `n` waits for.
  std::optional<std::size_t> waits_for(std::size_t n) const;

  std::size_t link_count() const { return links_.size(); }
  const c40::Link& link(std::size_t n) const { return *links_[n]; }
  const NetworkLink& ends(std::size_t n) const { return description_.links[n]; }
  std::size_t net_count() const { return nets_.size(); }
  const Net& net(std::size_t n) const { return *nets_[n]; }
  std::size_t memory_count() const { return description_.memories.size(); }
  std::span<c40::Word> memory(std::size_t n);
  /// A word of a shared memory, as a chip finds it.
  struct MemoryPlace {
    std::size_t memory = 0;
    c40::Address word = 0;
  };
  std::optional<MemoryPlace> memory_place(std::size_t chip, c40::Address address) const;
  /// Hears every access to shared memories, after it: who, where, what the word held; null: nobody. Changes nothing.
  using MemoryListener = std::function<void(std::size_t chip, MemoryPlace place, c40::Word before,
                                            const c40::ExternalAccess& access, Time time)>;
  void watch_memory(MemoryListener listener) { memory_listener_ = std::move(listener); }
  /// Who hears each instruction of a chip; null: nobody. Changes nothing. Use this, not Chip::set_trace: the network
  /// listens too.
  void set_trace(std::size_t n, c40::TraceSink* sink);

  /// \throws NetworkError if the target does not exist or the time is past.
  void schedule(const NetworkAction& action);
  void record_words(bool on) { records_words_ = on; }
  /// By time; at one instant those of nets last, by their numbers.
  std::vector<NetworkEvent> events() const;
  /// A line of an event trace (docs/networks.md): "123400000 word 0.0>1.3 0000002A"
  std::string text(const NetworkEvent& event) const;
  /// Words, DMA transfers, timers and interrupts as the chips' peripherals see them, by time and then by chip.
  void record_peripherals(bool on);
  std::vector<ChipEvent> peripheral_events() const;
  /// "123400000 chip 0: port_write 3 = 0000002A (DMA 1)"
  std::string text(const ChipEvent& event) const;
  /// A line for each event of the links and of the chips, by time.
  std::vector<std::string> event_trace() const;

  /// For every direction of every link: written = read + in FIFOs + under way + lost + discarded. \throws
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
  std::optional<NetworkStop> stop_if_quiet(Time limit);
  void join_links();
  void add_memories();
  void add_devices();
  void add_pin_nets();
  void join_nets();
  void join_pin_nets();
  void take_part();
  void start(Node& node);
  void load(Node& node);
  void load_stream(Node& node, const toolchain::Image& image, const c40::Board& board);
  void ready_to_start(Node& node);
  Time effective(const NetworkAction& action) const;
  Time next_action() const;
  c40::Cycles next_action_on(const Node& node) const;
  bool quiet();
  bool waits_for_ever() const;
  bool polls(const Node& node) const;
  std::string describe_loop(const Node& node) const;
  std::string describe_dma(const Node& node) const;
  std::string whom(const Node& node, int port, bool write) const;
  std::optional<std::size_t> neighbour(const Node& node, int port) const;
  void link_happens(std::size_t number, Time time);
  void actions_happen(Time time);
  void perform(const NetworkAction& action);
  void perform_port(Node& node);
  void perform_memory(Node& node);
  void perform_device(Node& node);
  void devices_acted();
  void tell_mailboxes(Memory& memory, std::size_t side, c40::Address word, bool write);
  void reset_chip(Node& node);
  std::string describe_wait(const Node& node) const;
  Time at_rest_since() const;
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
  std::vector<NetworkAction> actions_;  ///< to come, by time
  std::vector<NetworkEvent> events_, net_events_;
  Scheduler scheduler_;
  Time now_{0};
  void something_happened() { ++happenings_, happened_ = now_; }
  std::uint64_t happenings_ = 0;  ///< on links, in shared memories, to chips: what could end a loop that polls
  Time happened_{0};              ///< the last of them
  Time changed_{0};  ///< the last thing on a link that was no mere exchange of the token, change of a pin, or action
  std::size_t moving_ = 0;  ///< a chip that was not at rest when last looked at
  Time ends_at_ = never;    ///< of a network that is quiet: when all have come to rest
  bool made_ = false;       ///< The constructor is through: its chips may go on.
  bool records_words_ = false;
  MemoryListener memory_listener_;
};

}  // namespace machine
