#include "cmrc/configuration/dock_job.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cmrc/programs/program_constants.hpp"
#include "cmrc/programs/segment_duration.hpp"
#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

using std::numbers::pi;
constexpr double degrees = 180.0 / pi;
// A place that is measured may be a little apart from where it is said to be.
constexpr double most_turn = 179.0 / degrees;

struct Place {
  std::string name;
  double x, y, yaw;
  double z = 0;                     // of the spreader's underside at the end of a way
  std::optional<double> carried{};  // the same at the end of a way with a container; none: no such way ends here
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

/// The heights of the ways' ends (docs/kernels_job.md, Grab path), where no box is in the way.
void set_heights(std::vector<Place>& places, const plant::DockConfig& dock, double clearance, double margin) {
  places.front().z = dock.home.z;
  std::size_t i = 1;
  if (dock.agv_count > 0) {
    places[i].z = dock.agv.deck_height + plant::container_height + clearance;
    places[i].carried = places[i].z;
    ++i;
  }
  for (const plant::ContainerPlace& container : dock.layout.containers) {
    // The crane takes the highest container, so what hangs clears the bay when it clears the place where it stood.
    const double top = container.z + plant::container_height;
    places[i].z = top + clearance;
    places[i].carried = top + std::max(clearance, plant::container_height + margin);
    ++i;
  }
}

/// Calls `check` with both ends of each way of the job. No way leads from container to container.
template <class Check>
void each_way(const std::vector<Place>& places, const plant::DockConfig& dock, Check check) {
  const std::size_t ends = std::min<std::size_t>(places.size(), dock.agv_count > 0 ? 2 : 1);
  for (std::size_t from = 0; from < ends; ++from)
    for (std::size_t to = from + 1; to < places.size(); ++to) check(places[from], places[to]);
}

// ---- speeds on the straight ways ----

/// A set-point: where the suspension is and how fast it moves.
struct Motion {
  double x, y, x_rate, y_rate, z_rate, yaw_rate;
};

/// A blend from 0 to 1, and its derivatives at `u`.
struct Blend {
  double way, first, second = 0, third = 0;
};

Blend ninth_order(double u) {
  const double w = u * (1 - u), d = 1 - 2 * u, u2 = u * u;
  return {u2 * u2 * u * (126 + u * (-420 + u * (540 + u * (-315 + u * 70)))), 630 * w * w * w * w, 2520 * w * w * w * d,
          2520 * w * w * (3 * d * d - 2 * w)};
}

Blend quintic(double u) {
  const double w = u * (1 - u);
  return {u * u * u * (10 + u * (-15 + u * 6)), 30 * w * w};
}

/// Speed of a joint, in what the joint moves in: rad/s, the hoist m/s.
struct JointSpeed {
  const char *name, *key;
  plant::Joint joint;
  double speed;
};
using JointSpeeds = std::array<JointSpeed, 4>;

/// The straight ways of a slewing crane as the trajectory kernel plans them (docs/kernels.md, Trajectory).
class StraightWays {
 public:
  StraightWays(const plant::DockConfig& dock, const Config& config, const toolchain::Image& image)
      : crane_(dock.crane),
        control_(config.control),
        shaped_(config.kernels.trajectory == TrajectoryBuild::quintic_shaper),
        duration_(image, config),
        look_points_(static_cast<int>(image.symbol("TJ_LOOK_POINTS"))) {}

  /// \throws std::invalid_argument if the way leaves the jib's reach
  void drive(const Place& a, const Place& b) {
    constexpr int samples = 250;
    for (int i = 0; i <= samples; ++i) check_reach(a, b, i / static_cast<double>(samples));
    double duration =
        duration_.seconds(plant::hypot(b.x - a.x, b.y - a.y), std::abs(b.z - a.z), std::abs(b.yaw - a.yaw));
    if (!(duration > 0)) return;
    if (shaped_) duration *= stretch(a, b, duration);
    const double delay = shaped_ ? half_swing(a, b) : 0;
    for (int i = 0; i <= samples; ++i) {
      const double time = i / static_cast<double>(samples) * (duration + 2 * delay);
      const Motion at = shaped_ ? shaped(a, b, duration, delay, time) : hanging(a, b, duration, time);
      for (const JointSpeed& one : speeds(at)) {
        // The hoist is fastest where the rise at a way's beginning, another segment, is not over yet.
        if (one.joint == plant::Joint::hoist) continue;
        const double share = std::abs(one.speed) / trip(one.joint);
        if (share > worst_.share) worst_ = {share, plant::hypot(at.x, at.y), one, a.name, b.name};
      }
    }
  }

  /// \throws std::invalid_argument if a joint has been faster than its drive allows
  void check_speeds() const {
    if (worst_.share <= 1) return;
    throw std::invalid_argument(fmt::format(
        "on the straight way from {} to {}, {:.1f} m from the crane's column, {} needs {:.4g} rad/s, and its drive "
        "trips "
        "above {:.4g} rad/s, which is slewing.{}.overspeed times its rated speed; expected are ways farther from the "
        "column, lower speed limits in [control]{} (docs/control.md, Speed limits)",
        worst_.from, worst_.to, worst_.distance, worst_.joint.name, std::abs(worst_.joint.speed),
        trip(worst_.joint.joint), worst_.joint.key, shaped_ ? "" : ", or kernels.trajectory = \"quintic_shaper\""));
  }

 private:
  /// The fastest joint of all ways, by its drive's trip.
  struct Worst {
    double share = 0, distance = 0;
    JointSpeed joint{};
    std::string from, to;
  };

  double trip(plant::Joint joint) const {
    const plant::DriveParameters& drive = crane_.drives[static_cast<std::size_t>(joint)];
    return drive.overspeed * drive.rated_joint_speed();
  }
  double cosine(double x, double y) const { return (plant::hypot(x, y) - crane_.a0) / crane_.jib; }
  double rope(double x, double y, double z) const {
    const double c = cosine(x, y);
    return crane_.pivot_height + crane_.jib * std::sqrt(1 - c * c) - z;
  }

  void check_reach(const Place& a, const Place& b, double share) const {
    constexpr auto luff = static_cast<std::size_t>(plant::Joint::luff);
    const double x = a.x + share * (b.x - a.x), y = a.y + share * (b.y - a.y), c = cosine(x, y);
    const double least = plant::cos(crane_.upper[luff]), most = plant::cos(crane_.lower[luff]);
    if (c >= least && c <= most) return;
    throw std::invalid_argument(fmt::format(
        "the straight way from {} to {} passes ({:.1f}, {:.1f}) m, {:.1f} m from the crane's column, out "
        "of the jib's reach of {:.1f} to {:.1f} m; expected are [home], [spot] and containers between "
        "which it stays in reach",
        a.name, b.name, x, y, plant::hypot(x, y), crane_.a0 + crane_.jib * least, crane_.a0 + crane_.jib * most));
  }

  /// The place at a share of the way, moving at `rate` shares per second.
  static Motion moving(const Place& a, const Place& b, double share, double rate) {
    const double dx = b.x - a.x, dy = b.y - a.y;
    return {a.x + share * dx, a.y + share * dy, rate * dx, rate * dy, rate * (b.z - a.z), rate * (b.yaw - a.yaw)};
  }

  /// blend9: X = p + (l/g) p'', above which the load hangs without sway.
  Motion hanging(const Place& a, const Place& b, double duration, double time) const {
    const Blend blend = ninth_order(time / duration);
    const Motion load = moving(a, b, blend.way, blend.first / duration);
    const double lead = rope(load.x, load.y, a.z + blend.way * (b.z - a.z)) / plant::gravity / (duration * duration);
    Motion at = moving(a, b, blend.way + lead * blend.second, (blend.first + lead * blend.third) / duration);
    at.z_rate = load.z_rate, at.yaw_rate = load.yaw_rate;
    return at;
  }

  /// quintic_shaper: the path, half of it late by T/2, a quarter by T of the load's swing.
  static Motion shaped(const Place& a, const Place& b, double duration, double delay, double time) {
    double share = 0, rate = 0;
    for (const auto& [part, late] : {std::pair{0.25, 0.0}, std::pair{0.5, delay}, std::pair{0.25, 2 * delay}}) {
      const Blend blend = quintic(std::clamp((time - late) / duration, 0.0, 1.0));
      share += part * blend.way;
      rate += part * blend.first / duration;
    }
    return moving(a, b, share, rate);
  }
  double half_swing(const Place& a, const Place& b) const {
    return pi * std::sqrt(0.5 * (rope(a.x, a.y, a.z) + rope(b.x, b.y, b.z)) / plant::gravity);
  }
  /// The look-ahead: by what factor the segment is stretched, so that slew, luff and hoist keep to their limits.
  double stretch(const Place& a, const Place& b, double duration) const {
    double most = 1;
    for (int i = 1; i <= look_points_; ++i) {
      const Blend blend = quintic(i / (look_points_ + 1.0));
      const JointSpeeds at = speeds(moving(a, b, blend.way, blend.first / duration));
      const std::array limits = {control_.slew.speed_limit, control_.luff.speed_limit, control_.hoist.speed_limit};
      for (std::size_t j = 0; j < limits.size(); ++j) most = std::max(most, std::abs(at[j].speed) / limits[j]);
    }
    return most;
  }

  JointSpeeds speeds(const Motion& at) const {
    const double r = plant::hypot(at.x, at.y), c = cosine(at.x, at.y);
    const double slew = (at.x * at.y_rate - at.y * at.x_rate) / (r * r);
    const double luff = -(at.x * at.x_rate + at.y * at.y_rate) / (r * crane_.jib * std::sqrt(1 - c * c));
    return {{{"slewing", "slew", plant::Joint::slew, slew},
             {"luffing", "luff", plant::Joint::luff, luff},
             {"the hoist", "hoist", plant::Joint::hoist, crane_.jib * c * luff - at.z_rate},
             {"the rotator", "rotate", plant::Joint::rotator, at.yaw_rate - slew}}};
  }

  const plant::CraneParameters& crane_;
  const Config::Control& control_;
  bool shaped_;
  SegmentDuration duration_;
  int look_points_;
  Worst worst_;
};

// ---- what the job areas hold ----

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
        "is "
        "straight over its last {:g} m only; expected are a straight end of {:g} m or more, at most {:.0f} AGVs, or a "
        "slot_spacing_m of at most {:.4g}",
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
  for (const Place& place : places_of(dock)) check_place(dock, place);
  each_way(places_of(dock), dock, [&](const Place& a, const Place& b) { check_way(dock, a, b); });
}

void check_speeds(const plant::DockConfig& dock, const Config& config, const toolchain::Image& image) {
  if (dock.crane.machine != plant::CraneKind::slewing) return;
  StraightWays ways(dock, config, image);
  std::vector<Place> places = places_of(dock);
  set_heights(places, dock, config.dock.clearance_m, program_constants(image, "K_GP_MARGIN").front());
  each_way(places, dock, [&](Place a, Place b) {
    ways.drive(a, b);
    if (!a.carried || !b.carried) return;
    a.z = *a.carried, b.z = *b.carried;
    ways.drive(a, b);
  });
  ways.check_speeds();
}

}  // namespace cmrc
