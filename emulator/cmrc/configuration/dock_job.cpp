#include "cmrc/configuration/dock_job.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cmrc/programs/servo_law.hpp"
#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

using std::numbers::pi;
constexpr double degrees = 180.0 / pi;
constexpr int tiers = 4;  // that identify looks for (c40_programs/kernels/identify.asm)
// A place that is measured may be a little apart from where it is said to be.
constexpr double most_turn = 179.0 / degrees;

struct Place {
  std::string name;
  double x, y, yaw;
};

/// The part of the line y = `row` within a container's plan; `from` > `to`: none.
struct Chord {
  double from, to;
};

Chord chord_of(const plant::ContainerPlace& p, double row) {
  const auto [s, c] = plant::sin_cos(p.yaw);
  const double across = row - p.y;
  Chord chord{-1e9, 1e9};
  // |slope (x - p.x) + offset| <= half
  const auto clip = [&](double slope, double offset, double half) {
    if (std::abs(slope) < 1e-12) {
      if (std::abs(offset) > half) chord.to = -1e9, chord.from = 1e9;
      return;
    }
    const double one = (-half - offset) / slope, other = (half - offset) / slope;
    chord.from = std::max(chord.from, p.x + std::min(one, other));
    chord.to = std::min(chord.to, p.x + std::max(one, other));
  };
  clip(c, across * s, 0.5 * plant::container_length);
  clip(-s, across * c, 0.5 * plant::container_width);
  return chord;
}

void check_scanner(const plant::Layout& layout) {
  const double first = layout.scan_x0 - 0.5 * layout.scan_dx;
  const double last = first + plant::scan_count * layout.scan_dx;
  for (std::size_t i = 0; i < layout.containers.size(); ++i) {
    const plant::ContainerPlace& p = layout.containers[i];
    if (p.z > layout.deck + (tiers - 0.5) * plant::container_height)
      throw std::invalid_argument(
          fmt::format("container {} at ({:g}, {:g}) m stands in tier {:.0f}, but the crane looks for containers in "
                      "tiers 0 to {}",
                      i, p.x, p.y, (p.z - layout.deck) / plant::container_height, tiers - 1));
    // Its whole length must lie on a row, but for the cells of the scanner that its ends cut.
    const auto seen = [&](double row) {
      const Chord chord = chord_of(p, row);
      return chord.to - chord.from >= plant::container_length - 0.5 * layout.scan_dx && chord.from >= first &&
             chord.to <= last;
    };
    if (std::ranges::any_of(layout.rows, seen)) continue;
    const double half = 0.5 * plant::container_length;
    throw std::invalid_argument(
        fmt::format("container {} at ({:g}, {:g}) m is out of the bay scanner's sight, so the crane would leave it on "
                    "the ship; expected are a y_m of rows_m ({:g}), an x_m from {:.2f} to {:.2f} and a yaw_deg near 0",
                    i, p.x, p.y, fmt::join(layout.rows, ", "), first + half, last - half));
  }
}

double psi_at(const plant::DockConfig& dock, double x, double y) {
  return dock.crane.machine == plant::CraneKind::gantry ? 0.5 * pi : plant::atan2(y, x);
}

/// How often an angle has passed 180 degrees upwards.
double turns(double angle) { return std::ceil((angle - pi) / (2.0 * pi)); }

void check_way(const plant::DockConfig& dock, const Place& a, const Place& b) {
  constexpr int samples = 2000;
  double psi = psi_at(dock, a.x, a.y);
  const double psi_turns = turns(psi), kappa_turns = turns(a.yaw - psi);
  for (int i = 0; i <= samples; ++i) {
    const double share = i / static_cast<double>(samples), x = a.x + share * (b.x - a.x), y = a.y + share * (b.y - a.y);
    psi += plant::wrap_angle(psi_at(dock, x, y) - psi);
    const double kappa = a.yaw + share * (b.yaw - a.yaw) - psi;
    if (turns(psi) != psi_turns)
      throw std::invalid_argument(
          fmt::format("on the straight way from {} to {} the crane would slew through 180 degrees, at ({:.1f}, {:.1f}) "
                      "m, where the set-point of psi jumps by a whole turn; expected are [home], [spot] and containers "
                      "whose straight ways do not cross y = 0 at x < 0",
                      a.name, b.name, x, y));
    if (turns(kappa) != kappa_turns)
      throw std::invalid_argument(
          fmt::format("on the straight way from {} (yaw {:.0f} degrees) to {} (yaw {:.0f} degrees) the rotator would "
                      "turn through 180 degrees, at ({:.1f}, {:.1f}) m, where the set-point of kappa jumps by a whole "
                      "turn; expected is a yaw_deg of [home] or a heading_deg of [spot] with which yaw - psi stays "
                      "within 180 degrees",
                      a.name, a.yaw * degrees, b.name, b.yaw * degrees, x, y));
  }
}

void check_place(const plant::DockConfig& dock, const Place& place) {
  const double psi = psi_at(dock, place.x, place.y);
  for (const auto& [name, angle] : {std::pair{"psi", psi}, std::pair{"kappa", plant::wrap_angle(place.yaw - psi)}}) {
    if (std::abs(angle) <= most_turn) continue;
    throw std::invalid_argument(fmt::format(
        "{} at ({:g}, {:g}) m with yaw {:.0f} degrees needs {} = {:.1f} degrees, where its set-point jumps "
        "by a whole turn; expected is a place or a yaw with {} within {:.0f} degrees",
        place.name, place.x, place.y, place.yaw * degrees, name, angle * degrees, name, most_turn * degrees));
  }
}

/// A heading or its opposite, whichever is nearer to 0: a box fits both ways.
double half_turn(double heading) { return heading - pi * std::floor(heading / pi + 0.5); }

std::vector<Place> places_of(const plant::DockConfig& dock) {
  const plant::Layout& layout = dock.layout;
  std::vector<Place> places{{"home", dock.home.x, dock.home.y, dock.home.yaw}};
  if (dock.agv_count > 0)
    places.push_back({"the loading spot", layout.spot.x, layout.spot.y, half_turn(layout.spot.heading)});
  for (std::size_t i = 0; i < layout.containers.size(); ++i)
    places.push_back({fmt::format("container {}", i), layout.containers[i].x, layout.containers[i].y, 0.0});
  return places;
}

/// Calls `check` with both ends of each way of the job. No way leads from container to container.
template <class Check>
void each_way(const plant::DockConfig& dock, Check check) {
  const std::vector<Place> places = places_of(dock);
  const std::size_t ends = std::min<std::size_t>(places.size(), dock.agv_count > 0 ? 2 : 1);
  for (std::size_t from = 0; from < ends; ++from)
    for (std::size_t to = from + 1; to < places.size(); ++to) check(places[from], places[to]);
}

/// Derivatives of the blend of ninth order (docs/kernels.md) at `s` of 0 to 1.
struct Blend {
  double way, first, third;
};

Blend blend_at(double s) {
  const double s2 = s * s, s4 = s2 * s2;
  return {s4 * s * (126 + s * (-420 + s * (540 + s * (-315 + s * 70)))),
          s4 * (630 + s * (-2520 + s * (3780 + s * (-2520 + s * 630)))),
          s2 * (7560 + s * (-50400 + s * (113400 + s * (-105840 + s * 35280))))};
}

// The suspension's way, X = p + (l/g) p'', with the duration that the kernel gives it (docs/kernels.md, Durations).
void check_speeds_of(const plant::DockConfig& dock, const Config::Control& control, const Place& a, const Place& b) {
  constexpr int samples = 1000;
  constexpr double peak = 630.0 / 256.0;
  const plant::CraneParameters& p = dock.crane;
  const double dx = b.x - a.x, dy = b.y - a.y, h = plant::hypot(dx, dy), turn = b.yaw - a.yaw;
  const double duration = std::max({peak * (h / plan_speed(control) + std::abs(turn) / control.rotator.speed_limit),
                                    std::sqrt(9.37 * h / 0.4), std::sqrt(std::sqrt(623 * h / 0.081)),
                                    std::sqrt(9.37 * std::abs(turn) / 0.03)});
  if (!(duration > 0)) return;
  struct Worst {
    double share = 1, speed = 0, trip = 0, at = 0;
    const char* joint = nullptr;
  } worst;
  for (int i = 0; i <= samples; ++i) {
    const Blend blend = blend_at(i / static_cast<double>(samples));
    const double x = a.x + blend.way * dx, y = a.y + blend.way * dy, r = plant::hypot(x, y), c = (r - p.a0) / p.jib;
    const auto luff = static_cast<std::size_t>(plant::Joint::luff);
    if (!(c >= plant::cos(p.upper[luff]) && c <= plant::cos(p.lower[luff])))
      throw std::invalid_argument(fmt::format(
          "the straight way from {} to {} passes ({:.1f}, {:.1f}) m, {:.1f} m from the crane's column, out "
          "of the jib's reach of {:.1f} to {:.1f} m; expected are [home], [spot] and containers between "
          "which it stays in reach",
          a.name, b.name, x, y, r, p.a0 + p.jib * plant::cos(p.upper[luff]), p.a0 + p.jib * plant::cos(p.lower[luff])));
    const double sine = std::sqrt(1 - c * c), rope = p.pivot_height + p.jib * sine - dock.home.z;
    const double rate = blend.first / duration + rope / plant::gravity * blend.third / (duration * duration * duration);
    const double psi = (x * dy - y * dx) * rate / (r * r), phi = -(x * dx + y * dy) * rate / (r * p.jib * sine);
    const double kappa = turn * blend.first / duration - psi;
    for (const auto& [name, joint, speed] :
         {std::tuple{"slewing", plant::Joint::slew, psi}, std::tuple{"luffing", plant::Joint::luff, phi},
          std::tuple{"the rotator", plant::Joint::rotator, kappa}}) {
      const plant::DriveParameters& drive = p.drives[static_cast<std::size_t>(joint)];
      const double trip = drive.overspeed * drive.rated_joint_speed(), share = std::abs(speed) / trip;
      if (share > worst.share) worst = {share, std::abs(speed), trip, r, name};
    }
  }
  if (worst.joint != nullptr)
    throw std::invalid_argument(fmt::format(
        "on the straight way from {} to {}, {:.1f} m from the crane's column, {} needs {:.3f} rad/s, and its "
        "drive trips above {:.3f} rad/s; expected are ways farther from the column, lower speed limits in "
        "[control], or kernels.trajectory = \"quintic_shaper\" (docs/control.md, Speed limits)",
        a.name, b.name, worst.at, worst.joint, worst.speed, worst.trip));
}

}  // namespace

void check_job(const plant::DockConfig& dock) {
  if (dock.crane.machine == plant::CraneKind::slewing && dock.home.s != 0.0)
    throw std::invalid_argument(
        fmt::format("[home] gantry_m is {:g} m, but a slewing crane works at 0 m of its rails: inverse kinematics "
                    "leaves the travel at 0; expected is gantry_m = 0",
                    dock.home.s));
  check_scanner(dock.layout);
  for (const Place& place : places_of(dock)) check_place(dock, place);
  each_way(dock, [&](const Place& a, const Place& b) { check_way(dock, a, b); });
}

void check_speeds(const plant::DockConfig& dock, const Config::Control& control) {
  if (dock.crane.machine != plant::CraneKind::slewing) return;
  each_way(dock, [&](const Place& a, const Place& b) { check_speeds_of(dock, control, a, b); });
}

}  // namespace cmrc
