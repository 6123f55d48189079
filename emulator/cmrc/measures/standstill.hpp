#pragma once
// Since when nothing works: the DSP of each slot, and the crane's drives. A run ends by it (run/run_end.hpp).
#include <algorithm>
#include <optional>
#include <vector>

#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"
#include "state/visitor.hpp"

namespace cmrc {

using machine::Time;

class Standstill {
 public:
  /// The slot's DSP is halted or was pulled out, or the host has given up its boot.
  void stops(unsigned slot, Time at) {
    if (!stopped_.at(slot)) stopped_[slot] = at;
  }
  /// It is in reset, is being booted or works.
  void works(unsigned slot) { stopped_.at(slot).reset(); }
  /// A latch of the drives. \param braked no drive is on
  void latch(bool braked, Time at) {
    driven_ = driven_ || !braked;
    if (!braked)
      braked_.reset();
    else if (driven_ && !braked_)
      braked_ = at;
  }

  /// The instant from which on no slot has a DSP that works; none if one does.
  std::optional<Time> of_dsps() const {
    if (std::ranges::any_of(stopped_, [](const auto& since) { return !since.has_value(); })) return std::nullopt;
    return std::ranges::max(stopped_);
  }
  /// The latch from which on no drive has been on; none if one is, or none has ever been.
  std::optional<Time> of_drives() const { return braked_; }
  void list_state(state::Visitor& list) {
    list("stopped", stopped_);
    list("driven", driven_);
    list("braked", braked_);
  }

 private:
  std::vector<std::optional<Time>> stopped_ =
      std::vector<std::optional<Time>>(machine::most_slots, Time{0});  // by slot; an empty slot from the start
  bool driven_ = false;                                                // a drive was on at some time
  std::optional<Time> braked_;
};

}  // namespace cmrc
