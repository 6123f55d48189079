#pragma once
/// Nets: wires between pins of chips (IIOF, NMI, TCLK, RESET), of networks and between the dock's DSPs.
///
/// A net has the level of its driver; without a driver it has its level at rest (a pull-up or pull-down resistor). Only
/// an open-drain net may have several drivers: it is low while one of them drives it low. An edge takes no time. Each
/// receiver looks at the net at the beginning of each of its H1 cycles; a change that it sees there acts one cycle
/// later (the synchroniser). A change and its reverse between two looks are missed, and counted.
///
/// Inaccuracies: the synchroniser's one cycle is a model. A processor in the middle of an instruction takes the
/// interrupt at its end.
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "c40/chip/chip.hpp"
#include "machine/networks/net_description.hpp"
#include "machine/time/scheduler.hpp"
#include "machine/time/time.hpp"

namespace state {
class Visitor;
}

namespace machine {

/// Equal pulses: each leaves the level at rest for `width`.
struct PulseTrain {
  Time first{0}, width{0}, period{0};
  std::uint64_t count = 1;  ///< 0: without end
};

/// The owner of a chip on nets.
class PinOwner {
 public:
  virtual ~PinOwner() = default;
  virtual c40::Chip& owned_chip() = 0;
  virtual Time time_of(c40::Cycles cycle) const = 0;
  virtual c40::Cycles cycle_from(Time time) const = 0;
  /// Everything that the chip has driven before this instant is known, and nothing else can make it drive before.
  virtual Time drives_from() const = 0;
  /// A change of this pin would have an effect.
  virtual bool listens_to(c40::Pin pin) const = 0;
  virtual void pin_changes(c40::Pin pin, bool level, Time now) = 0;
};

class Net final : public Scheduler::Actor {
 public:
  /// \param owners of all chips, by number. They must outlive the net.
  Net(NetDescription description, const std::vector<PinOwner*>& owners);

  /// Reports the initial level to the receivers.
  void start();
  /// A chip changes how it drives one of its pins.
  void driven(const ChipPin& pin, c40::Drive drive, Time at);
  /// A chip whose accesses to a memory make a script drive the net.
  void moved_by(const PinOwner& chip) { movers_.push_back(&chip); }
  /// A script drives the net, from an instant on that is not past.
  void script(c40::Drive drive, Time at);
  void script(const PulseTrain& pulses);

  Time next() const override;
  void act(Time now) override;
  /// The earliest instant at which the net could act on a chip, as far as is known.
  Time reaches(std::size_t chip) const;
  /// A change of the net would have an effect.
  bool has_listener() const;
  /// This pin is a receiver, and low behind its synchroniser.
  bool is_low_at(const ChipPin& pin) const;
  /// The net will change again, as far as is known.
  bool continues() const { return next() != never; }

  const NetDescription& description() const { return description_; }
  bool level() const { return level_; }
  /// Number of changes of the level so far, and how many pulses receivers have missed: two changes each.
  std::uint64_t edges() const { return edges_; }
  std::uint64_t missed() const { return missed_; }
  /// Called for changes of the level, and for pulses that a chip has missed, when they end.
  class Listener {
   public:
    virtual ~Listener() = default;
    virtual void changed(Net& net, bool level, Time at) = 0;
    virtual void missed(Net& net, std::size_t chip, Time at) = 0;
  };
  Listener* listener = nullptr;

  void list_state(state::Visitor& list);

 private:
  struct Change {
    Time time{0};
    std::size_t source = 0;  ///< number of the driver; the script comes after all drivers
    c40::Drive drive = c40::Drive::none;
  };
  /// Seen by a receiver, and not at its pin yet.
  struct Seen {
    Time due{0};
    bool level = true;
  };
  struct Receiver {
    bool level = true;
    std::deque<Seen> seen;
    void list_state(state::Visitor& list);
  };

  std::size_t script() const { return description_.drivers.size(); }
  Time due(std::size_t receiver, Time edge) const;
  std::optional<Change> next_pulse() const;
  void add(const Change& change);
  void settle(Time now);
  bool resulting_level() const;

  NetDescription description_;
  std::vector<PinOwner*> drivers_, owners_;  ///< of the drivers, and of the receivers
  std::vector<const PinOwner*> movers_;
  std::vector<c40::Drive> drives_;  ///< by source
  std::deque<Change> changes_;      ///< future ones, by time
  std::vector<Receiver> receivers_;
  PulseTrain pulses_{};
  std::uint64_t pulse_ = 0;  ///< number of the pulse train's changes so far: two for each pulse
  bool pulsing_ = false;
  bool level_;
  std::uint64_t edges_ = 0, missed_ = 0;
};

}  // namespace machine
