#include "cmrc/programs/straight_ways.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cmrc/configuration/dock/job_places.hpp"
#include "cmrc/programs/program_constants.hpp"
#include "cmrc/programs/segment_duration.hpp"
#include "plant/dock/dock.hpp"
#include "plant/numerics/math.hpp"

namespace cmrc {
namespace {

using std::numbers::pi;
using Place = JobPlace;

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
    const double step = (duration + 2 * delay) / samples;
    std::array<Overspeed, std::tuple_size_v<JointSpeeds>> over{};
    for (int i = 0; i <= samples; ++i) {
      const double time = i * step;
      const Motion at = shaped_ ? shaped(a, b, duration, delay, time) : hanging(a, b, duration, time);
      const JointSpeeds joints = speeds(at);
      for (std::size_t j = 0; j < joints.size(); ++j) {
        // The hoist is fastest where the rise at a way's beginning, another segment, is not over yet.
        if (joints[j].joint == plant::Joint::hoist) continue;
        const double share = std::abs(joints[j].speed) / trip(joints[j].joint);
        if (share > std::max(1.0, over[j].fastest.share))
          over[j].fastest = {share, plant::hypot(at.x, at.y), joints[j], a.name, b.name};
        over[j].add(share, step);
        if (over[j].seconds >= drive_of(joints[j].joint).overspeed_time && over[j].fastest.share > worst_.share)
          worst_ = over[j].fastest;
        if (share <= 1) over[j] = {.share = share};
      }
    }
  }

  /// \throws std::invalid_argument if a joint has been faster than its drive allows, for as long as trips it
  void check_speeds() const {
    if (worst_.share <= 1) return;
    const char* const key = worst_.joint.key;
    throw std::invalid_argument(fmt::format(
        "on the straight way from {} to {}, {:.1f} m from the crane's column, {} needs {:.4g} rad/s, and its drive "
        "trips above {:.4g} rad/s, which is slewing.{}.overspeed times its rated speed, after {:g} s "
        "(slewing.{}.overspeed_time_s); expected are ways farther from the column, lower speed limits in [control]{} "
        "(docs/control.md, Speed limits)",
        worst_.from, worst_.to, worst_.distance, worst_.joint.name, std::abs(worst_.joint.speed),
        trip(worst_.joint.joint), key, drive_of(worst_.joint.joint).overspeed_time, key,
        shaped_ ? "" : ", or kernels.trajectory = \"quintic_shaper\""));
  }

 private:
  /// A joint's speed as a share of its drive's trip, where it is fastest.
  struct Worst {
    double share = 0, distance = 0;
    JointSpeed joint{};
    std::string from, to;
  };
  /// The time in which a joint is faster than its drive's trip without a break, so far.
  struct Overspeed {
    double share = 0;  // at the sample before
    double seconds = 0;
    Worst fastest{};
    /// The speed is linear between two samples.
    void add(double next, double step) {
      const auto [slow, fast] = std::minmax({share, next});
      if (fast > 1) seconds += step * (slow >= 1 ? 1 : (fast - 1) / (fast - slow));
      share = next;
    }
  };

  const plant::DriveParameters& drive_of(plant::Joint joint) const {
    return crane_.drives[static_cast<std::size_t>(joint)];
  }
  double trip(plant::Joint joint) const { return drive_of(joint).overspeed * drive_of(joint).rated_joint_speed(); }
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
  Worst worst_;  // of all drives that trip
};

}  // namespace

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
