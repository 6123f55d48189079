#pragma once
// Which master gets the bus next (plant-and-bus.md 3.1, 3.6). The numbers of the masters are those of their bus.
#include <cstdint>

#include "bus_model/config.hpp"
#include "state/visitor.hpp"

namespace pci {

class Arbiter {
 public:
  static constexpr unsigned nobody = ~0u;

  explicit Arbiter(const BusConfig& config) : config_{config} {}

  /// The new master gets the next number. `first_level` counts with Arbitration::two_level only.
  void add_master(bool first_level);
  /// Chooses among the masters whose REQ# is asserted at a clock, at least one: bit n of `asking` is master n.
  unsigned pick(std::uint32_t asking, Clocks clock) const;
  /// The master owns the bus from FRAME# at clock `frame` on.
  void granted(unsigned master, Clocks frame) {
    if (master != last_owner_ || frame >= kept_until()) tenure_ = frame;
    last_owner_ = master;
    if ((first_level_ >> master & 1u) != 0) {
      last_place_ = master;
    } else {
      last_place_ = masters_;
      last_of_second_ = master;
    }
  }

  unsigned last_owner() const { return last_owner_; }
  /// The master that has GNT# while no master requests the bus; `nobody` if there is none.
  unsigned parked() const {
    if (masters_ == 0 || config_.parking == Parking::none) return nobody;
    if (config_.parking == Parking::last_owner) return last_owner_;
    return config_.host_bridge ? 0 : nobody;
  }
  /// Before this clock the last owner keeps GNT#, even if another master requests the bus (the multi-transaction
  /// timer).
  Clocks kept_until() const { return tenure_ + config_.multi_transaction_timer; }

  void list_state(state::Visitor& list) {
    list("last owner", last_owner_);
    list("last place", last_place_);
    list("last of second level", last_of_second_);
    list("tenure", tenure_);
  }

 private:
  BusConfig config_;
  unsigned masters_ = 0;
  std::uint32_t first_level_ = 0;  // bit n: master n is on the first level
  unsigned last_owner_ = 0;
  unsigned last_place_ = 0;  // of the first level's ring; the second level as a whole has the last place in this ring
  unsigned last_of_second_ = 0;
  Clocks tenure_ = 0;  // the clock at which the last owner got the bus
};

}  // namespace pci
