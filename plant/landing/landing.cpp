// The payload as a body: its shape, the solids near it, and the hand-overs to and from the crane's own equations.
#include "plant/landing/landing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "plant/landing/landing_parts.hpp"

namespace plant {
namespace {

constexpr double hull_lift = 0.015;  // m, the body's underside above its corner castings
constexpr double fine_gap = 0.05;    // m, below which the step is 0.25 ms

}  // namespace

Landing::Landing(const DockConfig& config) : config_(config), p_(config.landing), engine_(config.landing) {
  near_.reserve(64);
}

Payload Landing::payload(const DockState& s) const {
  const double mc = container_mass(s);
  return {config_.crane.spreader_mass + mc,
          config_.crane.spreader_inertia + box_inertia(mc, container_length, container_width)};
}

BodyShape Landing::shape(const DockState& s) const {
  const double ms = config_.crane.spreader_mass;
  const double mc = container_mass(s);
  const Vector3 under = underside(s, ms);
  BodyShape body{};
  body.mass = ms + mc;
  const double spreader_above = under[2] + spreader_centre;
  const double container_above = under[2] + s.grip.top - 0.5 * container_height;
  const double lever = ms * spreader_above * spreader_above + mc * container_above * container_above;
  body.inertia = {
      box_inertia(ms, container_width, spreader_height) + box_inertia(mc, container_width, container_height) + lever,
      config_.crane.spreader_inertia + box_inertia(mc, container_length, container_height) + lever, payload(s).inertia};
  const double half_x = 0.5 * container_length;
  const double half_y = 0.5 * container_width;
  body.hulls[0] = {{0.0, 0.0, under[2] + 0.5 * (spreader_height + hull_lift)},
                   {half_x, half_y, 0.5 * (spreader_height - hull_lift)},
                   0.0};
  body.hull_count = 1;
  if (s.carried >= 0) {
    body.hulls[1] = {{s.grip.x, s.grip.y, container_above + 0.5 * hull_lift},
                     {half_x, half_y, 0.5 * (container_height - hull_lift)},
                     s.grip.yaw};
    body.hull_count = 2;
  }
  const auto [sy, cy] = sin_cos(s.grip.yaw);
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = corner_sign[i][0] * casting_x;
    const double y = corner_sign[i][1] * casting_y;
    body.corners[i] = s.carried < 0 ? Vector3{x, y, under[2]}
                                    : Vector3{s.grip.x + cy * x - sy * y, s.grip.y + sy * x + cy * y,
                                              under[2] + s.grip.top - container_height};
  }
  return body;
}

std::array<double, 3> Landing::payload_position(const DockState& s) const {
  return s.landing.body.position + Frame(s.landing.body.turn)(underside(s, config_.crane.spreader_mass));
}

double Landing::payload_yaw(const DockState& s) const { return yaw_of(Frame(s.landing.body.turn)); }

// ---- solids nearby

Solid Landing::footprint(const DockState& s, double x, double y, double z, double yaw) const {
  const double bottom = s.carried < 0 ? z : z + s.grip.top - container_height;
  return make_solid(Solid::Kind::fixed, -1, x, y, yaw, 0.5 * container_length, 0.5 * container_width, bottom,
                    z + spreader_height);
}

// The highest point of the solid's top below a footprint.
double Landing::highest_under(const Solid& foot, const Solid& solid) {
  if (!solid.tilted) return solid.top;
  double most = -1e9;
  for (const auto& [u, v] : corner_sign) {
    const double dx = u * foot.half_x, dy = v * foot.half_y;
    most = std::max(most, solid.top_at(foot.x + foot.cos_yaw * dx - foot.sin_yaw * dy,
                                       foot.y + foot.sin_yaw * dx + foot.cos_yaw * dy));
  }
  return most;
}

double Landing::clearance_of(const DockState& s, const Solid& foot) {
  double least = 1e9;
  const auto look = [&](const Solid& solid) {
    if (foot.top >= solid.bottom && overlaps(foot, solid, p_.near))
      least = std::min(least, foot.bottom - highest_under(foot, solid));
  };
  each_solid(config_, s, s.carried, std::cref(look));  // by reference: std::function would allocate a copy
  return least;
}

double Landing::clearance(const DockState& s, const Crane& crane) {
  if (s.landing.active) {
    const Vector3 at = payload_position(s);
    return clearance_of(s, footprint(s, at[0], at[1], at[2], payload_yaw(s)));
  }
  const Vector3 at = crane.payload_position(s.crane.q);
  return clearance_of(s, footprint(s, at[0], at[1], at[2], s.crane.q[Q_PSI] + s.crane.q[Q_KAPPA]));
}

// The upright box around the body, along its heading.
Solid Landing::around(const DockState& s) const {
  const Frame frame(s.landing.body.turn);
  const BodyShape body = shape(s);
  const double yaw = yaw_of(frame);
  const auto [sy, cy] = sin_cos(yaw);
  Vector3 least{1e9, 1e9, 1e9}, most{-1e9, -1e9, -1e9};
  for (std::size_t i = 0; i < static_cast<std::size_t>(body.hull_count); ++i) {
    const auto& hull = body.hulls[i];
    const auto [sh, ch] = sin_cos(hull.yaw);
    for (const auto& [u, v] : corner_sign)
      for (const double w : {-1.0, 1.0}) {
        const double dx = u * hull.half[0], dy = v * hull.half[1];
        const Vector3 corner = frame(Vector3{hull.centre[0] + ch * dx - sh * dy, hull.centre[1] + sh * dx + ch * dy,
                                             hull.centre[2] + w * hull.half[2]});
        const Vector3 seen{cy * corner[0] + sy * corner[1], -sy * corner[0] + cy * corner[1], corner[2]};
        for (std::size_t k = 0; k < 3; ++k) {
          least[k] = std::min(least[k], seen[k]);
          most[k] = std::max(most[k], seen[k]);
        }
      }
  }
  const double along = 0.5 * (least[0] + most[0]), across = 0.5 * (least[1] + most[1]);
  const Vector3 at = s.landing.body.position;
  return make_solid(Solid::Kind::fixed, -1, at[0] + cy * along - sy * across, at[1] + sy * along + cy * across, yaw,
                    0.5 * (most[0] - least[0]), 0.5 * (most[1] - least[1]), at[2] + least[2], at[2] + most[2]);
}

void Landing::find_near(const DockState& s) {
  const Solid body = around(s);
  near_.clear();
  const auto look = [&](const Solid& solid) {
    if (body.bottom - 0.5 < solid.top_at(body.x, body.y) && overlaps(body, solid, 0.5)) near_.push_back(solid);
  };
  each_solid(config_, s, s.carried, std::cref(look));
}

// The surface that would carry a foot at (x, y, z): the highest top that is not clearly above the foot.
const Solid* Landing::support(double x, double y, double z) const {
  const Solid* best = nullptr;
  for (const Solid& solid : near_) {
    const double top = solid.top_at(x, y);
    if (top <= z + 0.1 && covers(solid, x, y) && (best == nullptr || top > best->top_at(x, y))) best = &solid;
  }
  return best;
}

int Landing::latches_per_step(const DockState& s, const Crane& crane) {
  const bool fine = s.landing.contacts > 0 || clearance(s, crane) < fine_gap;
  return fine || s.latch % 4 != 0 ? 2 : 4;
}

std::array<double, 2> Landing::landing_error(const DockState& s) {
  find_near(s);
  const Frame frame(s.landing.body.turn);
  const BodyShape body = shape(s);
  const Vector3 at = s.landing.body.position + frame(Vector3{s.grip.x, s.grip.y, body.corners[0][2]});
  const Solid* below = support(at[0], at[1], at[2]);
  if (below == nullptr || !has_castings(*below)) return {0.0, 0.0};
  const double turned = wrap_angle(yaw_of(frame) + s.grip.yaw - below->yaw);
  const double yaw = std::fabs(turned) > 0.5 * std::numbers::pi ? wrap_angle(turned + std::numbers::pi) : turned;
  return {horizontal_distance(at, {below->x, below->y, 0.0}), yaw};
}

// ---- hand-over

double Landing::begin(DockState& s, const CraneMotion& motion) {
  const Crane& crane = motion.crane();
  CraneState& c = s.crane;
  const Payload load = payload(s);
  const CraneVector qdd = motion.acceleration(c, s.inputs);
  const double each = 0.25 * std::max(0.0, crane.tension(c.q, c.qd, qdd, load.mass));
  const double l = c.q[Q_L];

  LandingState& landing = s.landing;
  landing = {};
  landing.active = true;
  landing.next = s.latch;
  landing.slack = each * l / (p_.fall_stiffness + each);  // the falls pull with the force of the ideal rope
  landing.tension = 4.0 * each;
  const auto [sy, cy] = sin_cos(0.5 * (c.q[Q_PSI] + c.q[Q_KAPPA]));
  const Vector3 under = underside(s, config_.crane.spreader_mass);
  landing.body.turn = {cy, 0.0, 0.0, sy};
  landing.body.position = crane.payload_position(c.q) - under;
  landing.body.velocity = crane.payload_velocity(c.q, c.qd);
  landing.body.spin = {0.0, 0.0, c.qd[Q_PSI] + c.qd[Q_KAPPA]};

  c.q[Q_ALPHA] = c.q[Q_BETA] = c.qd[Q_ALPHA] = c.qd[Q_BETA] = 0.0;
  s.inputs.payload = {};
  s.inputs.locked |= sway_coordinates;
  s.inputs.external = {};
  return 0.5 * 4.0 * each * landing.slack;
}

double Landing::end(DockState& s, const Crane& crane) {
  const double before = energy(s, crane);
  CraneState& c = s.crane;
  const Payload load = payload(s);
  const Vector3 at = payload_position(s);
  const Vector3 hang = at - crane.tip(c.q);
  const auto [sp, cp] = sin_cos(c.q[Q_PSI]);
  const double radial = cp * hang[0] + sp * hang[1];
  const double tangential = -sp * hang[0] + cp * hang[1];

  const CraneMatrix bare = crane.mass_matrix(c.q, {});
  CraneVector momentum{};
  for (std::size_t i = 0; i < crane_size; ++i)
    for (std::size_t j = 0; j < crane_size; ++j) momentum[i] += bare[i][j] * c.qd[j];

  const double l = length(hang);
  s.stretch += l - c.q[Q_L];
  c.q[Q_L] = l;
  if (!config_.rigid) {
    c.q[Q_ALPHA] = atan2(radial, -hang[2]);
    c.q[Q_BETA] = atan2(tangential, std::sqrt(radial * radial + hang[2] * hang[2]));
  }
  const CraneVector carried = crane.at_payload(c.q, load.mass * s.landing.body.velocity);
  for (std::size_t k = 0; k < crane_size; ++k) momentum[k] += carried[k];
  momentum[Q_PSI] += load.inertia * s.landing.body.spin[2];
  momentum[Q_KAPPA] += load.inertia * s.landing.body.spin[2];

  if (!config_.rigid) s.inputs.locked &= ~sway_coordinates;
  s.inputs.external = {};
  s.inputs.payload = load;
  c.qd = Crane::solve(crane.mass_matrix(c.q, load), momentum, s.inputs.locked);
  s.landing = {};
  return crane.kinetic_energy(c.q, c.qd, load) + crane.potential_energy(c.q, load) - before;
}

double Landing::energy(const DockState& s, const Crane& crane) const {
  const BodyState& b = s.landing.body;
  const Payload load = payload(s);
  const BodyShape body = shape(s);
  const Frame frame(b.turn);
  double turning = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double rate = dot(frame.axis(static_cast<int>(k)), b.spin);
    turning += 0.5 * body.inertia[k] * rate * rate;
  }
  const double rest = s.crane.q[Q_L] - s.landing.slack;
  const double elastic = 0.5 * s.landing.tension * s.landing.tension * rest / (4.0 * p_.fall_stiffness);
  return crane.kinetic_energy(s.crane.q, s.crane.qd, {}) + crane.potential_energy(s.crane.q, {}) +
         0.5 * load.mass * dot(b.velocity, b.velocity) + turning + load.mass * gravity * payload_position(s)[2] +
         elastic;
}

}  // namespace plant
