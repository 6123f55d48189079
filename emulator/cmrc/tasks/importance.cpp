#include "cmrc/tasks/importance.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace cmrc {
namespace {

std::uint32_t saturated(std::int64_t value) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(value, 0, 0xFFFF));
}

std::uint32_t planning_restored(const ImportanceParameters& n, std::uint32_t x, std::uint32_t y, std::int64_t t) {
  if (y == robot_class::crane) {
    if (x == task::trajectory) return saturated(t >= n.n_crane - n.alpha ? 0xFFDF : n.p);
    return saturated(t >= n.n_crane - n.beta ? 0xFFBF : n.p + n.b);
  }
  if (x == task::trajectory) return saturated(t >= n.n_agv - n.alpha ? 0xFF7F : n.q + n.a * t);
  return saturated(t >= n.n_agv - n.beta ? 0xFEFF : n.q + n.b + n.a * t);
}

// The values of the paper as printed: only the crane's trajectory planning differs from the restored rows.
std::uint32_t planning_as_printed(const ImportanceParameters& n, std::uint32_t x, std::uint32_t y, std::int64_t t) {
  if (x == task::trajectory && y == robot_class::crane)
    return saturated(t >= n.n_crane - n.alpha ? n.p : n.q + n.a * t);
  return planning_restored(n, x, y, t);
}

}  // namespace

ImportanceParameters importance_parameters(const Config& config) {
  const Intervals n = intervals(config);
  const auto& s = config.scheduling;
  return {s.equation, n.servo, n.crane_point, n.agv_slowed, s.gamma_refreshes, s.alpha_refreshes, s.beta_refreshes,
          s.p,        s.q,     s.b,           s.a};
}

std::uint32_t importance(const ImportanceParameters& n, std::uint32_t x, std::uint32_t y, std::int64_t t) {
  t = std::min<std::int64_t>(t, 0xFFFF);
  const bool printed = n.equation == Equation7::as_printed;
  switch (x) {
    case task::error: return 0xFFFE;
    case task::recompute: return printed ? 0xFFFC : 0xFFFD;
    case task::avoidance: return printed ? 0xFFFC : 0xFFFB;
    case task::torque: return t >= n.n_servo - n.gamma ? 0xFFF7 : 0;
    case task::pid: return t < n.n_servo - n.gamma ? 0 : printed ? 0xFFEC : 0xFFEF;
    case task::trajectory:
    case task::inverse:
      if (y != robot_class::crane && y != robot_class::agv) break;
      return printed ? planning_as_printed(n, x, y, t) : planning_restored(n, x, y, t);
    case task::identify: return 0xFDFF;
    case task::grab_path: return 0xFBFF;
    case task::home_crane: return 0xF7FF;
    case task::home_agv: return 0xEFFF;
    default: break;
  }
  throw std::invalid_argument(fmt::format("equation (7) does not rank task kind x = {}, robot class y = {}", x, y));
}

}  // namespace cmrc
