#pragma once
// The clock of the crane's set-points (c40_programs/kernels/crane_servo.asm, servo_path). Until the crane is first
// stopped on its path it is the number of the refresh; from then on its rate can be 1, 0, or change linearly from one
// to the other.
#include <array>
#include <cmath>
#include <cstdint>

#include "cmrc/tasks/ti_float.hpp"
#include "state/visitor.hpp"

namespace cmrc {

class PathClock {
 public:
  /// The clock's value at a refresh not before the last change.
  double at(std::int64_t refresh) const {
    if (!used_) return static_cast<double>(refresh);
    const double whole = static_cast<double>(refresh > begin_ ? refresh - begin_ : 0);
    const double during = std::fmin(whole, static_cast<double>(ticks_));
    return base_ + (from_ + 0.5 * change_ * during) * during + to_ * (whole - during);
  }
  double rate(std::int64_t refresh) const {
    if (!used_) return 1;
    return refresh >= begin_ + ticks_ ? to_
                                      : from_ + change_ * static_cast<double>(refresh > begin_ ? refresh - begin_ : 0);
  }
  /// From `refresh` on the rate changes to `to` in `ticks` refreshes.
  void change(std::int64_t refresh, double to, std::int64_t ticks) {
    const double shown = at(refresh), rate_now = rate(refresh);
    base_ = shown, from_ = rate_now, to_ = to, begin_ = refresh, ticks_ = ticks, used_ = true;
    change_ = ticks > 0 ? (to_ - from_) / static_cast<double>(ticks_) : 0;
  }
  void list_state(state::Visitor& list) {
    list("used", used_);
    list("begin", begin_);
    list("ticks", ticks_);
    list("from", from_);
    list("to", to_);
    list("change", change_);
    list("base", base_);
  }
  double target() const { return used_ ? to_ : 1; }
  /// The refresh at which the rate reaches the target.
  std::int64_t reached() const { return begin_ + ticks_; }
  /// The words from CR_PATH on. \param drives bit j: drive j has to be on
  std::array<std::uint32_t, 8> words(std::uint32_t drives) const {
    const double whole = std::floor(base_);
    return {static_cast<std::uint32_t>(begin_),
            static_cast<std::uint32_t>(ticks_),
            ti_float(from_),
            ti_float(to_),
            ti_float(change_),
            static_cast<std::uint32_t>(static_cast<std::int64_t>(whole)),
            ti_float(base_ - whole),
            drives};
  }

 private:
  bool used_ = false;
  std::int64_t begin_ = 0, ticks_ = 0;
  double from_ = 1, to_ = 1, change_ = 0, base_ = 0;
};

}  // namespace cmrc
