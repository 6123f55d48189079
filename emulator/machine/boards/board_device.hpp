#pragma once
/// One device behind a window of a board (docs/boards.md), from a [[device]] table or a Python class.
///
/// A device knows the cycles of its chip's clock, but no chip. It acts when the program accesses it, or at a cycle that
/// it announces before: so a run with devices is the same however it is divided.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "c40/peripherals/pins.hpp"
#include "c40/values/types.hpp"
#include "machine/boards/host_script.hpp"
#include "state/visitor.hpp"

namespace machine {

enum class DeviceKind : std::uint8_t {
  console,    ///< a serial line
  registers,  ///< words that hold the value written last
  led,        ///< the same; each change is reported
  fifo,       ///< words to and from a host
  mailbox,    ///< a FIFO of one word in each direction
  timer,      ///< counts down
  vic068a,    ///< the registers of a VIC068A; of their effects only the bus error status
  vme,        ///< the address space behind such a bridge, without any module
  own         ///< a class of the user
};

/// The source of a device's input, and its fingerprint.
struct DeviceInput {
  std::string source;  ///< the file's name, or "standard input"
  std::string sha256;  ///< of the input's bytes
  std::vector<HostStep> steps;
  friend bool operator==(const DeviceInput&, const DeviceInput&) = default;
};

struct DeviceDescription {
  DeviceKind kind = DeviceKind::registers;
  std::string name;
  c40::Address base = 0;
  c40::Address words = 1;
  int waits = 0;                  ///< cycles of an access beyond the first
  c40::Word value = 0;            ///< initial value of its words; for a VIC068A its revision
  std::optional<c40::Pin> pin;    ///< the pin that it pulls low
  std::size_t depth = 512;        ///< for a FIFO: words in each direction
  c40::Cycles input_cycles = 0;   ///< between two words from the host
  c40::Cycles output_cycles = 0;  ///< cycles that the host needs to take a word
  c40::Cycles count_cycles = 1;   ///< cycles of one count of a timer
  c40::Address stride = 1;        ///< for a VIC068A: words from one register to the next
  unsigned shift = 0;             ///< the bit of a word that holds bit 0 of such a register
  bool bus_error = true;          ///< the VME space answers with a bus error; else accesses are ignored
  std::string vic;                ///< the device that records the bus error
  std::optional<DeviceInput> input;
  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};

/// Properties of all devices of a kind: one row each (board_device_kinds.cpp).
class BoardDevice;
struct DeviceKindRow {
  DeviceKind kind;
  std::string_view name;
  c40::Address words;  ///< number of its words; 0: given in the board file
  bool needs_words;    ///< the board file must give the number of words
  std::string_view
      keys;  ///< allowed keys of its [[device]] table, besides name, kind, base and waits, separated by blanks
  std::unique_ptr<BoardDevice> (*make)(const DeviceDescription&);
};
/// All kinds that a board file can name.
std::span<const DeviceKindRow> device_kinds();
const DeviceKindRow& row_of(DeviceKind kind);
std::string_view name(DeviceKind kind);
/// The properties that must be equal for a state to fit, as text.
std::string configuration_of(const DeviceDescription& device);
/// "IIOF0" to "IIOF3" and "NMI".
std::optional<c40::Pin> interrupt_pin_named(std::string_view text);

class BoardDevice {
 public:
  BoardDevice() = default;
  BoardDevice(const BoardDevice&) = delete;
  BoardDevice& operator=(const BoardDevice&) = delete;
  virtual ~BoardDevice() = default;

  /// \param now the access's cycle; all events before have been executed
  virtual c40::Word read(c40::Address offset, c40::Cycles now) = 0;
  virtual void write(c40::Address offset, c40::Word value, c40::Cycles now) = 0;
  /// Executes what the device does by itself up to and with this cycle.
  virtual void advance_to(c40::Cycles /*now*/) {}
  /// The next cycle in which the device could change its pin by itself.
  virtual c40::Cycles next_event() const { return never_cycle; }
  /// A value that a program reads here could change by itself.
  virtual bool continues() const { return false; }
  /// The device pulls its pin low.
  virtual bool interrupts() const { return false; }
  /// The device may act on other chips, or depend on what they do: its accesses take place in the order of the network.
  virtual bool acts_on_others() const { return false; }
  /// Words sent to the other side; null: the device has no other side.
  virtual const std::vector<c40::Word>* sent() const { return nullptr; }
  /// The other side's script; null: there is none.
  virtual HostScript* host() { return nullptr; }
  /// What a program has asked of it that it does not do, for the report.
  struct NotModelled {
    std::string_view what;
    c40::Cycles cycle = 0;  ///< of the first time
  };
  virtual std::vector<NotModelled> not_modelled() const { return {}; }
  /// Nothing if the device's state can be listed; else the reason, as the end of a sentence.
  virtual std::optional<std::string> stateless() const { return std::nullopt; }
  virtual void list_state(state::Visitor& list) = 0;
};

/// The registers of a VIC068A that another device writes.
class BusErrorStatus {
 public:
  virtual ~BusErrorStatus() = default;
  virtual void note_timeout(bool write) = 0;
};

}  // namespace machine
