#pragma once
/// All devices around one chip: who answers an access, what they do by themselves, and the pins that they pull.
///
/// A pin is low while one of its devices pulls it. It changes in the cycle in which the access begins, or in which the
/// device does something by itself; the synchroniser's one cycle comes on top, as for a net (machine/net.hpp).
/// Inaccuracy: an access of the DMA may be behind the processor, so the pin may change later by an instruction.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip.hpp"
#include "machine/board_device.hpp"

namespace machine {

class BoardDevices {
 public:
  struct Change {
    std::string device;
    c40::Cycles cycle = 0;
    c40::Word value = 0;
  };
  struct Place {
    DeviceDescription described;
    std::shared_ptr<BoardDevice> device;
  };

  BoardDevices() = default;
  explicit BoardDevices(const std::vector<DeviceDescription>& described);
  BoardDevices(const BoardDevices&) = delete;
  BoardDevices& operator=(const BoardDevices&) = delete;

  /// One of the user's own. \throws std::invalid_argument if another device is there
  void add(DeviceDescription described, std::shared_ptr<BoardDevice> device);
  const std::vector<Place>& places() const { return places_; }
  bool empty() const { return places_.empty(); }
  bool has(c40::Address address) const { return at(address) != nullptr; }
  /// \throws std::out_of_range if there is none
  const Place& at_address(c40::Address address) const;
  /// One is there that acts on other chips.
  bool acts_on_others(c40::Address address) const;
  /// \throws std::invalid_argument with the names that there are
  const Place& named(std::string_view name) const;

  struct Answer {
    c40::Word value = 0;
    int waits = 0;
  };
  /// Does the access; none: no device is there.
  std::optional<Answer> access(const c40::ExternalAccess& access);
  /// What they do by themselves up to and with this cycle.
  void advance_to(c40::Cycles now);
  /// The same, and what another chip has done to them by this cycle shows at their pins.
  void look(c40::Cycles now);
  c40::Cycles next_event() const;
  /// One acts on other chips; one of these does so by itself.
  bool act_on_others() const;
  bool will_act_on_others() const;
  /// Something that a program reads there could become another value by itself.
  bool goes_on() const;

  /// Pins that they may pull, each once.
  std::vector<c40::Pin> pins() const;
  /// Hears each change of a pin. \param cycle in which it is so
  std::function<void(c40::Pin, bool level, c40::Cycles cycle)> on_pin;

  /// Characters that the first console is sent, behind those that wait.
  void type(std::string_view text);
  void type(const HostStep& step);
  bool has_console() const { return console_at() != nullptr; }
  /// What the consoles have sent, and the changes of LEDs so far.
  const std::string& console() const { return console_; }
  const std::vector<Change>& changes() const { return changes_; }
  /// Hears each character that a console sends.
  std::function<void(char)> on_output;

  /// Why their state cannot be listed; none: it can.
  std::optional<std::string> stateless() const;
  /// \throws state::StateError if it cannot
  void list_state(state::Visitor& list);

 private:
  Place* at(c40::Address address);
  const Place* at(c40::Address address) const { return const_cast<BoardDevices*>(this)->at(address); }
  const Place* console_at() const;
  void note(const Place& place, const c40::ExternalAccess& access, c40::Word before);
  void tell_pins(c40::Cycles cycle);
  void join_vme();

  std::vector<Place> places_;
  c40::Cycles now_ = 0;
  unsigned low_ = 0;  ///< bit n: pin n was last told to be low
  std::string console_;
  std::vector<Change> changes_;
};

/// Devices around a chip that is driven by nobody else: who runs it asks how far it may run, and lets the pins follow.
class LoneDevices {
 public:
  /// Both must outlive it.
  LoneDevices(BoardDevices& devices, c40::Chip& chip);
  ~LoneDevices();
  LoneDevices(const LoneDevices&) = delete;
  LoneDevices& operator=(const LoneDevices&) = delete;

  /// What is due at the chip's cycle happens; the chip may run to so far at most, and `wanted`.
  c40::Cycles limit(c40::Cycles wanted);
  /// Answers the access at which the chip has stopped; false: no device is there.
  bool serve(const c40::ExternalAccess& access);
  /// Something that they do by themselves could interrupt it.
  bool could_wake() const;
  void list_state(state::Visitor& list) { list("pins", pins_); }

 private:
  struct PinChange {
    c40::Pin pin = c40::Pin::iiof0;
    bool level = true;
    c40::Cycles due = 0;
  };
  bool reached(c40::Cycles due) const;

  BoardDevices& devices_;
  c40::Chip& chip_;
  std::deque<PinChange> pins_;  ///< to come, by time
};

/// Answers the access at which a chip has stopped; false: no device is there.
bool serve(BoardDevices& devices, c40::Chip& chip, const c40::ExternalAccess& access);

}  // namespace machine
