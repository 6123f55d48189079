#include "cmrc/tasks/importance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "cmrc/tasks/job_kinds.hpp"

namespace cmrc {
namespace {

std::uint32_t saturated(std::int64_t value) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(value, 0, 0xFFFF));
}

/// The row of a kind of table 1. The planning kinds have a row per robot class; the class of the others does not count.
const KindRow* row_of(std::uint32_t x, std::uint32_t y) {
  const auto* row = std::ranges::find_if(
      kind_rows, [&](const KindRow& one) { return one.x == x && (one.run != LongestRun::planning || one.y == y); });
  return row == kind_rows.end() ? nullptr : row;
}

}  // namespace

std::uint32_t importance(const ImportanceParameters& n, std::uint32_t x, std::uint32_t y, std::int64_t t) {
  t = std::min<std::int64_t>(t, 0xFFFF);
  const bool printed = n.equation == Equation7::as_printed;
  const KindRow* row = row_of(x, y);
  if (row != nullptr && row->importance.restored != 0)
    return printed ? row->importance.as_printed : row->importance.restored;
  switch (row != nullptr ? row->kind : JobKind::user) {
    case JobKind::torque_compensation: return t >= n.n_servo - n.gamma ? 0xFFF7 : 0;
    case JobKind::pid: return t < n.n_servo - n.gamma ? 0 : printed ? 0xFFEC : 0xFFEF;
    case JobKind::trajectory_crane:
      if (printed) return saturated(t >= n.n_crane - n.alpha ? n.p : n.q + n.a * t);
      return saturated(t >= n.n_crane - n.alpha ? 0xFFDF : n.p);
    case JobKind::inverse_crane: return saturated(t >= n.n_crane - n.beta ? 0xFFBF : n.p + n.b);
    case JobKind::trajectory_agv: return saturated(t >= n.n_agv - n.alpha ? 0xFF7F : n.q + n.a * t);
    case JobKind::inverse_agv: return saturated(t >= n.n_agv - n.beta ? 0xFEFF : n.q + n.b + n.a * t);
    default: break;
  }
  throw std::invalid_argument(fmt::format("equation (7) does not rank task kind x = {}, robot class y = {}", x, y));
}

}  // namespace cmrc
