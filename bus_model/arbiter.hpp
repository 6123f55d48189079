#pragma once
// Who gets the bus next (plant-and-bus.md 3.1, 3.6). Masters are numbered as on their bus; master 0 is the host bridge
// where there is one.
#include <cstdint>
#include <span>
#include <vector>

#include "bus_model/config.hpp"
#include "state/visitor.hpp"

namespace pci {

class Arbiter {
 public:
  static constexpr unsigned nobody = ~0u;

  explicit Arbiter(const BusConfig& config) : config_{config} {}

  /// The next master; `first_level` counts with Arbitration::two_level only.
  void add_master(bool first_level);
  /// The choice among those whose request stands at clock `latest`; nobody, when none does. `requests` holds the clock
  /// of each master's REQ#, or never.
  unsigned pick(std::span<const Clocks> requests, Clocks latest) const;
  /// The bus is the master's from FRAME# at clock `frame` on.
  void granted(unsigned master, Clocks frame) {
    if (master != last_owner_ || frame >= kept_until()) tenure_ = frame;
    last_owner_ = master;
    if (on_first_level(master)) {
      last_place_ = master;
    } else {
      last_place_ = static_cast<unsigned>(first_level_.size());
      last_of_second_ = master;
    }
  }

  unsigned last_owner() const { return last_owner_; }
  /// Where GNT# stays when nobody asks, or nobody.
  unsigned parked() const {
    if (first_level_.empty() || config_.parking == Parking::none) return nobody;
    return config_.parking == Parking::first ? 0 : last_owner_;
  }
  /// The last owner keeps GNT# before this clock, whoever asks (the multi-transaction timer).
  Clocks kept_until() const { return tenure_ + config_.multi_transaction_timer; }

  void list_state(state::Visitor& list) {
    list("last owner", last_owner_);
    list("last place", last_place_);
    list("last of second level", last_of_second_);
    list("tenure", tenure_);
  }

 private:
  bool on_first_level(unsigned master) const {
    return config_.arbitration == Arbitration::host_fair ? master == 0 : first_level_[master];
  }
  unsigned pick_of_two_levels(std::span<const Clocks> requests, Clocks latest) const;

  BusConfig config_;
  std::vector<bool> first_level_;
  unsigned last_owner_ = 0;
  unsigned last_place_ = 0;  // of the first level's ring, in which the second level as a whole has the last place
  unsigned last_of_second_ = 0;
  Clocks tenure_ = 0;  // when the last owner came to the bus
};

}  // namespace pci
