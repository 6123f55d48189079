#pragma once
/// All devices around one chip: they answer accesses, act by themselves, and pull pins.
///
/// A pin is low while one of its devices pulls it. It changes in the cycle in which the access begins, or in which the
/// device acts by itself; the synchroniser adds one cycle, as for a net (machine/networks/net.hpp). Inaccuracy: an
/// access of the DMA may be behind the processor, so the pin may change one instruction late.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip/chip.hpp"
#include "machine/boards/board_device.hpp"

namespace machine {

/// A window of the board holds all these addresses: only there an access reaches a device.
bool behind_window(const c40::Board& board, c40::Address base, std::uint64_t words);

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

  /// Adds a user's device. \throws std::invalid_argument if another device has these addresses, or no window of the
  /// board does
  void add(const c40::Board& board, DeviceDescription described, std::shared_ptr<BoardDevice> device);
  const std::vector<Place>& places() const { return places_; }
  bool empty() const { return places_.empty(); }
  bool has(c40::Address address) const { return at(address) != nullptr; }
  /// \throws std::out_of_range if no device is at the address
  const Place& at_address(c40::Address address) const;
  /// The device at this address acts on other chips.
  bool acts_on_others(c40::Address address) const;
  /// \throws std::invalid_argument with the known names
  const Place& named(std::string_view name) const;

  struct Answer {
    c40::Word value = 0;
    int waits = 0;
  };
  /// Does the access; none: no device is at the address.
  std::optional<Answer> access(const c40::ExternalAccess& access);
  /// Executes what the devices do by themselves up to and with this cycle. \throws std::invalid_argument for a device
  /// whose next event is not later than the cycle up to which it has been executed
  void advance_to(c40::Cycles now);
  /// The same; also reports to the pins what other chips have done to the devices by this cycle.
  void look(c40::Cycles now);
  /// The same between two runs; also executes what only the other side sees, as words on the way to it. \param now
  /// every access before this cycle has been made, and by the DMA also those in it
  void settle(c40::Cycles now);
  c40::Cycles next_event() const;
  /// A device acts on other chips; a device that acts on other chips also acts by itself.
  bool act_on_others() const;
  bool will_act_on_others() const;
  /// A value that a program reads there could change by itself.
  bool continues() const;

  /// The pins that devices may pull, each once.
  std::vector<c40::Pin> pins() const;
  /// Called at each change of a pin. \param cycle in which it changes
  std::function<void(c40::Pin, bool level, c40::Cycles cycle)> on_pin;

  /// The first console; null: there is none.
  const Place* console_at() const;
  /// Characters for the first console, after those that still wait. \param now the cycle in which they are typed
  void type(const std::vector<HostStep>& steps, c40::Cycles now);
  /// The same, of a user who types while the program runs. Returns a step with which a host script repeats it: the
  /// characters come behind every access until now.
  HostStep type(std::string_view text, c40::Cycles now);
  /// Everything that consoles have sent; the first changes of LEDs, and how many there were.
  const std::string& console() const { return console_; }
  const std::vector<Change>& changes() const { return changes_; }
  std::uint64_t change_count() const { return change_count_; }
  /// Called for each character that a console sends.
  std::function<void(char)> on_output;

  /// Why the devices' state cannot be listed; none: it can.
  std::optional<std::string> stateless() const;
  /// \throws state::StateError if the state cannot be listed
  void list_state(state::Visitor& list);

 private:
  Place* at(c40::Address address);
  const Place* at(c40::Address address) const { return const_cast<BoardDevices*>(this)->at(address); }
  void note(const Place& place, const c40::ExternalAccess& access, c40::Word before);
  void tell_pins(c40::Cycles cycle);
  void join_vme();

  std::vector<Place> places_;
  c40::Cycles now_ = 0;  ///< of the last event or access; where a run has been cut does not count
  unsigned low_ = 0;     ///< bit n: pin n was last reported low
  std::string console_;
  std::vector<Change> changes_;
  std::uint64_t change_count_ = 0;
};

/// Devices around a chip without another driver: the caller asks how far the chip may run, and lets the pins follow.
class LoneDevices {
 public:
  /// Both must outlive this object.
  LoneDevices(BoardDevices& devices, c40::Chip& chip);
  ~LoneDevices();
  LoneDevices(const LoneDevices&) = delete;
  LoneDevices& operator=(const LoneDevices&) = delete;

  /// Executes what is due at the chip's cycle. Returns how far the chip may run, at most to `wanted`.
  c40::Cycles limit(c40::Cycles wanted);
  /// To be called after each run: executes what is due, so that the state does not depend on how the run was cut.
  void run_ended();
  /// Answers the access at which the chip stopped; false: no device is at the address.
  bool serve(const c40::ExternalAccess& access);
  /// A device could interrupt the chip by itself, or has just done so.
  bool could_wake();
  /// A character that somebody types could do so.
  bool typing_could_wake() const;
  void list_state(state::Visitor& list) { list("pins", pins_); }

 private:
  struct PinChange {
    c40::Pin pin = c40::Pin::iiof0;
    bool level = true;
    c40::Cycles due = 0;
  };
  bool reached(c40::Cycles due) const;
  bool could_wake(c40::Pin pin) const;
  c40::Cycles present() const;
  void catch_up();

  BoardDevices& devices_;
  c40::Chip& chip_;
  std::deque<PinChange> pins_;  ///< future ones, by time; a pin changes once in a cycle
};

/// Answers the access at which a chip stopped; false: no device is at the address.
bool serve(BoardDevices& devices, c40::Chip& chip, const c40::ExternalAccess& access);

}  // namespace machine
