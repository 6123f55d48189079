#pragma once
// How long the wind's mean over 3 s is above a limit. Measured independently of the controller, which may read the wind
// too late.
#include <cmath>
#include <cstdint>

#include "plant/dock/dock.hpp"
#include "plant/scene/wind.hpp"
#include "state/visitor.hpp"

namespace cmrc {

class WindWatch {
 public:
  WindWatch(const plant::WindParameters& wind, double limit_m_s) : wind_(wind), limit_(limit_m_s) {}

  /// Time has advanced to `now`; it never goes back.
  void at(plant::Time now) {
    for (; next_ <= now; next_ += period) {
      const double t = static_cast<double>(next_.count()) * 1e-12;
      if (std::abs(wind_.mean(t - window, t)) > limit_) ++samples_above_;
      ++samples_;
    }
  }
  /// The watched time until now, to within a period.
  plant::Time watched() const { return samples_ * period; }
  plant::Time above() const { return samples_above_ * period; }
  void list_state(state::Visitor& list) {
    list("next", next_);
    list("samples_above", samples_above_);
    list("samples", samples_);
  }

 private:
  static constexpr plant::Time period{10'000'000'000};  // 10 ms
  static constexpr double window = 3.0;                 // s
  plant::Wind wind_;
  double limit_;
  plant::Time next_ = period;
  std::int64_t samples_ = 0, samples_above_ = 0;
};

}  // namespace cmrc
