#pragma once
/// What stands behind the windows of a board for a program alone: [[device]] tables of a board file (docs/cli.md, Board
/// files).
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip.hpp"
#include "state/visitor.hpp"

namespace machine {

enum class DeviceKind : std::uint8_t {
  console,    ///< a serial line: +0 a character read or written, +1 status: bit 0 one has come, bit 1 one can be sent
  registers,  ///< words that hold what was written last: the stub of a controller that a program only sets up
  led         ///< the same, and each change is told
};
/// "console"
std::string_view name(DeviceKind kind);
std::optional<DeviceKind> device_kind_named(std::string_view text);

struct DeviceDescription {
  DeviceKind kind = DeviceKind::registers;
  std::string name;
  c40::Address base = 0;
  c40::Address words = 1;
  int waits = 0;        ///< cycles beyond the first that an access takes
  c40::Word value = 0;  ///< of its words at the start
  friend bool operator==(const DeviceDescription&, const DeviceDescription&) = default;
};

class BoardDevices {
 public:
  struct Change {
    std::string device;
    c40::Cycles cycle = 0;
    c40::Word value = 0;
  };

  explicit BoardDevices(const std::vector<DeviceDescription>& described);

  /// Characters that the consoles are sent, in the order in which they are read.
  void type(std::string_view text) { input_.append(text); }
  /// Hears each character that a console sends.
  std::function<void(char)> on_output;
  /// Hears each change of an LED.
  std::function<void(const Change&)> on_change;

  struct Answer {
    c40::Word value = 0;
    int waits = 0;
  };
  /// Does the access; none: no device is there.
  std::optional<Answer> access(const c40::ExternalAccess& access);
  bool empty() const { return devices_.empty(); }

  /// What the devices hold, and what has not been read yet.
  void list_state(state::Visitor& list);

 private:
  struct Device {
    DeviceDescription described;
    std::vector<c40::Word> words;
    void list_state(state::Visitor& list) { list("words", words); }
  };
  c40::Word read(Device& device, c40::Address offset);
  void write(Device& device, c40::Address offset, c40::Word value, c40::Cycles cycle);

  std::vector<Device> devices_;
  std::string input_;
  std::uint64_t taken_ = 0;  ///< of the input
};

/// Answers the access at which a chip has stopped; false: no device is there.
bool serve(BoardDevices& devices, c40::Chip& chip, const c40::ExternalAccess& access);

}  // namespace machine
