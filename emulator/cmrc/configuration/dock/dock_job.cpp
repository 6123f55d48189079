#include "cmrc/configuration/dock/dock_job.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "cmrc/configuration/dock/job_places.hpp"
#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

using std::numbers::pi;
constexpr double degrees = 180.0 / pi;
using Place = JobPlace;
// A place that is measured may be a little apart from where it is said to be.
constexpr double most_turn = 179.0 / degrees;

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

/// The scanner shows a container's whole length on a row, but for the cells that its ends cut.
bool seen_on(const plant::Layout& layout, const Chord& chord) {
  const double first = layout.scan_x0 - 0.5 * layout.scan_dx;
  return chord.to - chord.from >= plant::container_length - 0.5 * layout.scan_dx && chord.from >= first &&
         chord.to <= first + plant::scan_count * layout.scan_dx;
}

/// Between two containers end to end at least one cell of the scanner must not fit their tier: else the kernel identify
/// searches for the edges over both. A gap may lie half in one cell and half in the next.
void check_gaps(const plant::Layout& layout) {
  constexpr double fits = 0.25;  // m from the tier's height: K_ID_TOLERANCE of identify_constants.asm
  const double least = 2 * fits / plant::container_height * layout.scan_dx;
  const auto& all = layout.containers;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      if (std::abs(all[i].z - all[j].z) > fits) continue;
      for (const double row : layout.rows) {
        const Chord a = chord_of(all[i], row), b = chord_of(all[j], row);
        const double gap = std::max(a.from - b.to, b.from - a.to);
        if (!seen_on(layout, a) || !seen_on(layout, b) || gap >= least) continue;
        throw std::invalid_argument(
            fmt::format("containers {} and {} stand end to end on the row y = {:g} m, {:.0f} mm apart; the bay "
                        "scanner's cells are {:g} m long, so the crane can take the two for one and aim between them; "
                        "expected is a gap of at least {:.0f} mm",
                        i, j, row, 1e3 * std::max(gap, 0.0), layout.scan_dx, std::ceil(1e3 * least)));
      }
    }
  }
}

void check_scanner(const plant::Layout& layout, int tiers) {
  const double first = layout.scan_x0 - 0.5 * layout.scan_dx;
  const double last = first + plant::scan_count * layout.scan_dx;
  for (std::size_t i = 0; i < layout.containers.size(); ++i) {
    const plant::ContainerPlace& p = layout.containers[i];
    if (p.z > layout.deck + (tiers - 0.5) * plant::container_height)
      throw std::invalid_argument(
          fmt::format("container {} at ({:g}, {:g}) m stands in tier {:.0f}, but the crane looks for containers in "
                      "tiers 0 to {}",
                      i, p.x, p.y, (p.z - layout.deck) / plant::container_height, tiers - 1));
    if (std::ranges::any_of(layout.rows, [&](double row) { return seen_on(layout, chord_of(p, row)); })) continue;
    const double half = 0.5 * plant::container_length;
    throw std::invalid_argument(
        fmt::format("container {} at ({:g}, {:g}) m is out of the bay scanner's sight, so the crane would leave it on "
                    "the ship; expected are a y_m of rows_m ({:g}), an x_m from {:.2f} to {:.2f} and a yaw_deg near 0",
                    i, p.x, p.y, fmt::join(layout.rows, ", "), first + half, last - half));
  }
  check_gaps(layout);
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

/// What the steering can do beyond the bends of the lanes, to lead the vehicle back onto its lane.
constexpr double steering_reserve = 1.1;

void check_bends(const plant::DockConfig& dock) {
  const plant::AgvParameters& p = dock.agv;
  if (p.drive != plant::AgvDrive::steered) return;  // wheels on the left and right turn on the spot
  const double half_base = 0.5 * (p.front + p.rear);
  const auto [s, c] = plant::sin_cos(p.steer_limit);
  const double most = s / c / half_base / steering_reserve;  // 1/m
  for (const auto& [name, leg] : {std::pair{"to_warehouse", 0}, std::pair{"to_spot", 1}}) {
    const std::vector<plant::LaneSegment>& pieces = dock.layout.legs.at(static_cast<std::size_t>(leg));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double bend = std::abs(pieces[i].curvature);
      if (bend <= most) continue;
      throw std::invalid_argument(fmt::format(
          "[lanes] {}: piece {}, from ({:.2f}, {:.2f}) m, has a curvature of {:.4g} 1/m (a radius of {:.2f} m), but "
          "with agv.steer_limit_deg = {:g} and {:g} m between its axles an AGV follows at most {:.4g} 1/m ({:.2f} m; "
          "a tenth of its steering is kept to lead it back onto its lane); expected are a wider bend, or an "
          "agv.steer_limit_deg of {:.1f} or more",
          name, i, pieces[i].x, pieces[i].y, pieces[i].curvature, 1 / bend, p.steer_limit * degrees, 2 * half_base,
          most, 1 / most, std::ceil(plant::atan2(bend * half_base * steering_reserve, 1.0) * degrees * 10) / 10));
    }
  }
}

/// A leg may end 0.1 m beside the warehouse, and an AGV stops within 2 cm of the leg's end.
constexpr double least_warehouse_radius = 0.15;  // m

void check_warehouse(const plant::Layout& layout) {
  if (layout.warehouse_radius >= least_warehouse_radius) return;
  throw std::invalid_argument(
      fmt::format("[warehouse] radius_m is {:g} m, so an AGV may stop outside of it, and the warehouse takes nothing; "
                  "expected is {:g} m or more",
                  layout.warehouse_radius, least_warehouse_radius));
}

void check_lanes(const plant::DockConfig& dock, const Words& words) {
  const plant::Layout& layout = dock.layout;
  for (const auto& [name, leg] : {std::pair{"to_warehouse", 0}, std::pair{"to_spot", 1}}) {
    const std::size_t pieces = layout.legs.at(static_cast<std::size_t>(leg)).size();
    if (pieces > words.segments_max)
      throw std::invalid_argument(
          fmt::format("[lanes] {} has {} pieces, but a leg of an AGV has at most {}; expected "
                      "are fewer pieces: one after the other on the same line or arc are one",
                      name, pieces, words.segments_max));
  }
  // The AGVs wait on the line through the loading spot, and move up along it.
  double straight = 0;
  for (auto piece = layout.legs[1].rbegin(); piece != layout.legs[1].rend() && piece->curvature == 0; ++piece)
    straight += piece->length;
  const int waiting = dock.agv_count - 1;
  const double queue = waiting * layout.slot_spacing;
  if (waiting > 0 && queue > straight + 1e-6)
    throw std::invalid_argument(fmt::format(
        "dock.agvs = {} needs a queue of {:g} m behind the loading spot (slot_spacing_m = {:g}), but [lanes] to_spot "
        "is straight over its last {:g} m only; expected are a straight end of {:g} m or more, at most {:.0f} AGVs, "
        "or a slot_spacing_m of at most {:.4g}",
        dock.agv_count, queue, layout.slot_spacing, straight, queue, std::floor(straight / layout.slot_spacing) + 1,
        straight / waiting));
}

}  // namespace

void check_job(const plant::DockConfig& dock, const Words& words) {
  if (dock.crane.machine == plant::CraneKind::slewing && dock.home.s != 0.0)
    throw std::invalid_argument(
        fmt::format("[home] gantry_m is {:g} m, but a slewing crane works at 0 m of its rails: inverse kinematics "
                    "leaves the travel at 0; expected is gantry_m = 0",
                    dock.home.s));
  if (const std::size_t boxes = dock.layout.no_go.size(); boxes > words.boxes_max)
    throw std::invalid_argument(
        fmt::format("there are {} [[boxes]], but the grab path goes round at most {}; expected are fewer: a box may "
                    "stand for several that are side by side",
                    boxes, words.boxes_max));
  check_scanner(dock.layout, static_cast<int>(words.bay_tiers));
  check_lanes(dock, words);
  check_bends(dock);
  check_warehouse(dock.layout);
  for (const Place& place : places_of(dock)) check_place(dock, place);
  each_way(places_of(dock), dock, [&](const Place& a, const Place& b) { check_way(dock, a, b); });
}

}  // namespace cmrc
