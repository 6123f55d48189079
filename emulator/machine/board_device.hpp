#pragma once
/// One device behind a window of a board (docs/boards.md): what a [[device]] table makes, or a class of Python's.
///
/// A device knows cycles of its chip's clock, and no chip. It does something when the program touches it, or at a cycle
/// that it can say beforehand: so a run with devices is the same however it is cut.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "c40/peripherals/pins.hpp"
#include "c40/types.hpp"
#include "machine/host_script.hpp"
#include "state/visitor.hpp"

namespace machine {

enum class DeviceKind : std::uint8_t {
  console,    ///< a serial line
  registers,  ///< words that hold what was written last
  led,        ///< the same, and each change is told
  fifo,       ///< words to and from a host
  mailbox,    ///< a FIFO that holds one word each way
  timer,      ///< counts down
  vic068a,    ///< the registers of a VIC068A; of what they do, only the bus error status
  vme,        ///< the space that such a bridge leads to, with no module in it
  own         ///< a class of the user's
};

/// Where a device's input comes from, and what it is.
struct DeviceInput {
  std::string source;  ///< the file's name, or "standard input"
  std::string sha256;  ///< of its bytes
  std::vector<HostStep> steps;
  friend bool operator==(const DeviceInput&, const DeviceInput&) = default;
};

struct DeviceDescription {
  DeviceKind kind = DeviceKind::registers;
  std::string name;
  c40::Address base = 0;
  c40::Address words = 1;
  int waits = 0;                  ///< cycles beyond the first that an access takes
  c40::Word value = 0;            ///< of its words at the start; of a VIC068A its revision
  std::optional<c40::Pin> pin;    ///< that it pulls low
  std::size_t depth = 512;        ///< of a FIFO, in words each way
  c40::Cycles input_cycles = 0;   ///< between two words from the host
  c40::Cycles output_cycles = 0;  ///< that the host takes to take a word
  c40::Cycles count_cycles = 1;   ///< of a timer's count
  c40::Address stride = 1;        ///< words from one register of a VIC068A to the next
  unsigned shift = 0;             ///< the bit of a word in which such a register's bit 0 stands
  bool bus_error = true;          ///< the VME space answers so; else accesses are ignored
  std::string vic;                ///< the device that notes it
  std::optional<DeviceInput> input;
  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};

/// What is common to all devices of a kind: one row each (board_device_kinds.cpp).
class BoardDevice;
struct DeviceKindRow {
  DeviceKind kind;
  std::string_view name;
  c40::Address words;     ///< that it has; 0: as the board file says
  bool needs_words;       ///< the board file has to
  std::string_view keys;  ///< of a [[device]] table, besides name, kind, base and waits; blanks between them
  std::unique_ptr<BoardDevice> (*make)(const DeviceDescription&);
};
/// All that a board file can name.
std::span<const DeviceKindRow> device_kinds();
const DeviceKindRow& row_of(DeviceKind kind);
std::string_view name(DeviceKind kind);
/// What has to be the same for a state to fit, as text.
std::string configuration_of(const DeviceDescription& device);
/// "IIOF0" to "IIOF3" and "NMI".
std::optional<c40::Pin> interrupt_pin_named(std::string_view text);

class BoardDevice {
 public:
  BoardDevice() = default;
  BoardDevice(const BoardDevice&) = delete;
  BoardDevice& operator=(const BoardDevice&) = delete;
  virtual ~BoardDevice() = default;

  /// \param now the access's cycle; everything before has happened
  virtual c40::Word read(c40::Address offset, c40::Cycles now) = 0;
  virtual void write(c40::Address offset, c40::Word value, c40::Cycles now) = 0;
  /// What it does by itself up to and with this cycle.
  virtual void advance_to(c40::Cycles /*now*/) {}
  /// The next cycle in which its pin could change by itself.
  virtual c40::Cycles next_event() const { return never_cycle; }
  /// Something that a program reads here could become another value by itself.
  virtual bool goes_on() const { return false; }
  /// It pulls its pin low.
  virtual bool interrupts() const { return false; }
  /// What it does may act on other chips, or follow from what they do: its accesses come in the order of the network.
  virtual bool acts_on_others() const { return false; }
  /// Words that it has sent to the other side; none: it has no other side.
  virtual const std::vector<c40::Word>* sent() const { return nullptr; }
  /// What the other side sends; null: it has none.
  virtual HostScript* host() { return nullptr; }
  /// What a program has asked of it that it does not do, for the report.
  struct NotModelled {
    std::string_view what;
    c40::Cycles cycle = 0;  ///< of the first time
  };
  virtual std::vector<NotModelled> not_modelled() const { return {}; }
  /// Whether its state can be listed; else why not, as the end of a sentence.
  virtual std::optional<std::string> stateless() const { return std::nullopt; }
  virtual void list_state(state::Visitor& list) = 0;
};

/// The registers of a VIC068A as far as another device writes them.
class BusErrorStatus {
 public:
  virtual ~BusErrorStatus() = default;
  virtual void note_timeout(bool write) = 0;
};

}  // namespace machine
