#include "plant/landing.hpp"

#include <algorithm>
#include <cmath>

#include "plant/math.hpp"
#include "plant/wind.hpp"

namespace plant {
namespace {

constexpr double spreader_height = 1.0;      // m
constexpr double spreader_centre = 0.75;     // m, its centre of mass above its underside, with the headblock
constexpr double head_height = 1.5;          // m, the falls' lower ends above the underside (their upper ends as much above the tip)
constexpr double casting_x = 5.9925, casting_y = 1.1295;  // m, corner castings of a 40-ft container from its middle
constexpr double hull_lift = 0.015;          // m, the body's underside above its corner castings
constexpr double fine_gap = 0.05;            // m, below which the step is 0.25 ms
constexpr std::array<std::array<double, 2>, 4> corner_sign = {{{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}};

double yaw_of(const Frame& frame) { return atan2(frame.column[0][1], frame.column[0][0]); }

double box_inertia(double mass, double a, double b) { return mass * (a * a + b * b) / 12.0; }

double container_mass(const DockState& s) {
  return s.carried < 0 ? 0.0 : s.containers[static_cast<std::size_t>(s.carried)].mass;
}

// The middle of the spreader's underside, in the body's frame.
Vector3 underside(const DockState& s, double spreader_mass) {
  const double mc = container_mass(s);
  const double middle = s.grip.top - 0.5 * container_height;  // the container's centre above the underside
  return {0.0, 0.0, -(spreader_mass * spreader_centre + mc * middle) / (spreader_mass + mc)};
}

// Where the castings of a container or of an AGV's deck are, in the order of our corners: the nearer of the two ways round.
Vector3 casting(const Solid& solid, double yaw, std::size_t corner, double z) {
  const bool turned = std::fabs(wrap_angle(yaw - solid.yaw)) > 0.5 * std::numbers::pi;
  const double flip = turned ? -1.0 : 1.0;
  const double dx = flip * corner_sign[corner][0] * casting_x;
  const double dy = flip * corner_sign[corner][1] * casting_y;
  if (solid.tilted) {
    const Vector3 from_middle = solid.frame()({dx, dy, 0.0});
    return {solid.x + from_middle[0], solid.y + from_middle[1], z};
  }
  return {solid.x + solid.cos_yaw * dx - solid.sin_yaw * dy, solid.y + solid.sin_yaw * dx + solid.cos_yaw * dy, z};
}

bool has_castings(const Solid& solid) { return solid.kind == Solid::Kind::container || solid.kind == Solid::Kind::agv; }

double horizontal_distance(const Vector3& a, const Vector3& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]));
}

// Velocity of a body's point given in world axes from the centre of mass.
Vector3 point_velocity(const BodyState& b, const Vector3& arm) { return b.velocity + cross(b.spin, arm); }

}  // namespace

Landing::Landing(const DockConfig& config) : config_(config), p_(config.landing), engine_(config.landing) {
  solids_.reserve(64);
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
  body.inertia = {box_inertia(ms, container_width, spreader_height) + box_inertia(mc, container_width, container_height) + lever,
                  config_.crane.spreader_inertia + box_inertia(mc, container_length, container_height) + lever,
                  payload(s).inertia};
  const double half_x = 0.5 * container_length;
  const double half_y = 0.5 * container_width;
  body.hulls[0] = {{0.0, 0.0, under[2] + 0.5 * (spreader_height + hull_lift)}, {half_x, half_y, 0.5 * (spreader_height - hull_lift)}, 0.0};
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

// ---- what is near

Solid Landing::footprint(const DockState& s, double x, double y, double z, double yaw) const {
  const double bottom = s.carried < 0 ? z : z + s.grip.top - container_height;
  return make_solid(Solid::Kind::fixed, -1, x, y, yaw, 0.5 * container_length, 0.5 * container_width, bottom, z + spreader_height);
}

// The highest point of the solid's top below a footprint.
double Landing::highest_under(const Solid& foot, const Solid& solid) {
  if (!solid.tilted) return solid.top;
  double most = -1e9;
  for (const auto& [u, v] : corner_sign) {
    const double dx = u * foot.half_x, dy = v * foot.half_y;
    most = std::max(most, solid.top_at(foot.x + foot.cos_yaw * dx - foot.sin_yaw * dy, foot.y + foot.sin_yaw * dx + foot.cos_yaw * dy));
  }
  return most;
}

double Landing::clearance_of(const DockState& s, const Solid& foot) {
  collect_solids(config_, s, s.carried, solids_);
  double least = 1e9;
  for (const Solid& solid : solids_)
    if (foot.top >= solid.bottom && overlaps(foot, solid, p_.near)) least = std::min(least, foot.bottom - highest_under(foot, solid));
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

void Landing::find_near(const DockState& s) {
  const Vector3 at = payload_position(s);
  const Solid foot = footprint(s, at[0], at[1], at[2], payload_yaw(s));
  collect_solids(config_, s, s.carried, solids_);
  near_.clear();
  for (const Solid& solid : solids_)
    if (foot.bottom - 0.5 < solid.top_at(foot.x, foot.y) && overlaps(foot, solid, 0.5)) near_.push_back(solid);
}

// What would carry a foot at (x, y, z): the highest top that is not clearly above it.
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
  landing.slack = each * l / (p_.fall_stiffness + each);  // the falls pull as the ideal rope did
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
    const double rate = dot(frame.column[k], b.spin);
    turning += 0.5 * body.inertia[k] * rate * rate;
  }
  const double rest = s.crane.q[Q_L] - s.landing.slack;
  const double elastic = 0.5 * s.landing.tension * s.landing.tension * rest / (4.0 * p_.fall_stiffness);
  return crane.kinetic_energy(s.crane.q, s.crane.qd, {}) + crane.potential_energy(s.crane.q, {}) +
         0.5 * load.mass * dot(b.velocity, b.velocity) + turning + load.mass * gravity * payload_position(s)[2] + elastic;
}

// ---- forces

void Landing::add_falls(const DockState& s, const Crane& crane, double seconds, Forces& sum) const {
  const CraneVector& q = s.crane.q;
  const CraneVector& qd = s.crane.qd;
  const BodyState& b = s.landing.body;
  const Frame frame(b.turn);
  const auto [sp, cp] = sin_cos(q[Q_PSI]);
  const auto [sk, ck] = sin_cos(q[Q_KAPPA]);
  const Vector3 tip = crane.tip(q);
  const Vector3 tip_velocity = crane.tip_velocity(q, qd);
  const Vector3 luffing = crane.tip_by_luff(q);
  const Vector3 under = underside(s, config_.crane.spreader_mass);
  const double rest = q[Q_L] - s.landing.slack;
  const double stiffness = p_.fall_stiffness / rest;

  for (const auto& sign : corner_sign) {
    const double ax = sign[0] * p_.fall_spread_x;
    const double ay = sign[1] * p_.fall_spread_y;
    const Vector3 offset{cp * ax - sp * ay, sp * ax + cp * ay, head_height};
    const Vector3 top = tip + offset;
    const Vector3 top_velocity = tip_velocity + qd[Q_PSI] * Vector3{-offset[1], offset[0], 0.0};
    // The headblock keeps the slewing frame's heading: it is turned back by kappa in the spreader's frame.
    const double hx = ck * ax + sk * ay;
    const double hy = -sk * ax + ck * ay;
    const Vector3 arm = frame({hx, hy, under[2] + head_height});
    const Vector3 by_kappa = frame({hy, -hx, 0.0});
    const Vector3 bottom = b.position + arm;
    const Vector3 bottom_velocity = point_velocity(b, arm) + qd[Q_KAPPA] * by_kappa;

    const Vector3 span = top - bottom;
    const double distance = length(span);
    const Vector3 up = (1.0 / distance) * span;
    const double rate = dot(up, top_velocity - bottom_velocity) - qd[Q_L];
    const double stretch = distance - rest + 0.5 * seconds * rate;  // in the middle of the step
    const double pull = stretch > 0.0 ? std::max(0.0, stiffness * stretch + p_.fall_damping * rate) : 0.0;
    if (pull <= 0.0) sum.taut = false;

    sum.tension += pull;
    sum.force = sum.force + pull * up;
    sum.torque = sum.torque + cross(arm, pull * up);
    sum.crane[Q_S] -= pull * up[0];
    sum.crane[Q_PSI] -= pull * (up[1] * (top[0] - q[Q_S]) - up[0] * top[1]);
    sum.crane[Q_PHI] -= pull * dot(up, luffing);
    sum.crane[Q_L] += pull;
    sum.crane[Q_KAPPA] += pull * dot(up, by_kappa);
  }
  const double twist = wrap_angle(q[Q_PSI] + q[Q_KAPPA] - yaw_of(frame));
  const double moment = p_.yaw_stiffness * twist + p_.yaw_damping * (qd[Q_PSI] + qd[Q_KAPPA] - b.spin[2]);
  sum.torque[2] += moment;
  sum.crane[Q_PSI] -= moment;
  sum.crane[Q_KAPPA] -= moment;
}

// Flipper guides around a container's top, or cones around an AGV's deck: a funnel that narrows downwards, frictionless, from an
// elastic potential in (lateral error less the funnel's half width).
void Landing::add_guides(const DockState& s, Forces& sum) const {
  if (!p_.guides) return;
  const BodyState& b = s.landing.body;
  const Frame frame(b.turn);
  const BodyShape body = shape(s);
  const auto wanted = s.carried < 0 ? Solid::Kind::container : Solid::Kind::agv;
  const Vector3 middle = b.position + frame(Vector3{0.0, 0.0, body.corners[0][2]});
  const Solid* below = support(middle[0], middle[1], middle[2]);
  if (below == nullptr || below->kind != wanted) return;
  const double narrow = 0.2 * p_.seat_error;
  const double slope = (p_.guide_window - narrow) / p_.guide_height;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 arm = frame(body.corners[i]);
    const Vector3 foot = b.position + arm;
    const double height = foot[2] - below->top_at(foot[0], foot[1]);
    if (height > p_.guide_height) continue;
    const Vector3 goal = casting(*below, yaw_of(frame) + s.grip.yaw, i, foot[2]);
    const double error = horizontal_distance(foot, goal);
    const double excess = error - (narrow + slope * std::max(0.0, height));
    if (excess <= 0.0 || error > p_.guide_window) continue;
    const Vector3 outward = (1.0 / error) * (foot - goal);
    const double speed = dot(outward, point_velocity(b, arm) - below->velocity_at(foot));
    const double push = std::max(0.0, p_.guide_stiffness * excess + p_.guide_damping * speed);
    const Vector3 force = -push * outward + Vector3{0.0, 0.0, height > 0.0 ? push * slope : 0.0};
    sum.force = sum.force + force;
    sum.torque = sum.torque + cross(arm, force);
  }
}

void Landing::read_corners(DockState& s) const {
  const Frame frame(s.landing.body.turn);
  const BodyShape body = shape(s);
  unsigned closed = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 foot = s.landing.body.position + frame(body.corners[i]);
    const Solid* below = support(foot[0], foot[1], foot[2]);
    if (below == nullptr || foot[2] - below->top_at(foot[0], foot[1]) > p_.seat_gap) continue;
    if (has_castings(*below) &&
        horizontal_distance(foot, casting(*below, yaw_of(frame) + s.grip.yaw, i, foot[2])) > p_.seat_error)
      continue;
    closed |= 1U << i;
  }
  s.landing.corners = closed;
}

Landing::Outcome Landing::step(DockState& s, const Crane& crane, double seconds) {
  find_near(s);
  read_corners(s);
  Forces forces;
  add_falls(s, crane, seconds, forces);
  add_guides(s, forces);
  if (config_.wind.blows()) forces.force = forces.force + wind_force(config_.wind, s.seconds());
  s.landing.tension = forces.tension;

  Outcome outcome;
  const Vector3 velocity = s.landing.body.velocity;
  const ContactResult result = engine_.step(s.landing.body, shape(s), forces.force, forces.torque, near_, seconds);
  forces.crane[Q_S] -= result.by_crane[0];  // the rails take what pushes a leg across
  s.inputs.external = forces.crane;
  s.landing.contacts = result.contacts;
  if (result.contacts > 0 && !s.landing.touched) {
    s.landing.touched = outcome.touched = true;
    Vector3 against = velocity;  // what lies below may ride on a ship
    const Vector3 middle = s.landing.body.position + Frame(s.landing.body.turn)(Vector3{0.0, 0.0, shape(s).corners[0][2]});
    if (const Solid* below = support(middle[0], middle[1], middle[2])) against = against - below->velocity_at(middle);
    outcome.vertical = -against[2];
    outcome.horizontal = std::sqrt(against[0] * against[0] + against[1] * against[1]);
  }
  outcome.clear = result.contacts == 0 && forces.taut;
  return outcome;
}

// ---- twist locks

int Landing::take(DockState& s) {
  find_near(s);
  const Frame frame(s.landing.body.turn);
  const Vector3 at = payload_position(s);
  const Solid* below = support(at[0], at[1], at[2]);
  if (s.carried >= 0 || below == nullptr || below->kind != Solid::Kind::container) return -1;
  const int number = below->index;
  const double yaw = yaw_of(frame);
  const auto [sy, cy] = sin_cos(yaw);
  const double dx = below->x - at[0];
  const double dy = below->y - at[1];
  double turn = wrap_angle(below->yaw - yaw);
  if (std::fabs(turn) > 0.5 * std::numbers::pi) turn = wrap_angle(turn + std::numbers::pi);
  const double top = below->top - at[2];

  // The container moves as what carries it does, a ship or a vehicle: the momentum of both is shared, seen from there.
  BodyState& b = s.landing.body;
  const Vector3 middle = b.position;
  const double ms = config_.crane.spreader_mass;
  const double alone = config_.crane.spreader_inertia;
  auto& container = s.containers[static_cast<std::size_t>(number)];
  if (container.agv >= 0) {
    AgvState& agv = s.agvs[static_cast<std::size_t>(container.agv)];
    agv.container = -1;
    change_load(agv, config_.agv, 0.0, 0.0, {});
  }
  container.state = ContainerState::carried;
  container.agv = -1;
  s.carried = number;
  s.grip = {cy * dx + sy * dy, -sy * dx + cy * dy, turn, top};
  const Payload whole = payload(s);
  b.position = at - frame(underside(s, ms));
  b.velocity = below->velocity_at(b.position) + (ms / whole.mass) * (b.velocity - below->velocity_at(middle));
  b.spin = below->spin + (alone / whole.inertia) * (b.spin - below->spin);
  return number;
}

int Landing::release(DockState& s) {
  if (s.carried < 0) return -1;
  find_near(s);
  const Frame frame(s.landing.body.turn);
  const Vector3 at = payload_position(s);
  const double yaw = yaw_of(frame);
  const auto [sy, cy] = sin_cos(yaw);
  const int number = s.carried;
  ContainerData& c = s.containers[static_cast<std::size_t>(number)];
  c.x = at[0] + cy * s.grip.x - sy * s.grip.y;
  c.y = at[1] + sy * s.grip.x + cy * s.grip.y;
  c.z = at[2] + s.grip.top - container_height;
  c.yaw = wrap_angle(yaw + s.grip.yaw);
  c.state = ContainerState::on_ground;
  c.agv = -1;
  const Solid* below = support(c.x, c.y, c.z);
  if (below != nullptr && below->kind == Solid::Kind::agv) {
    AgvState& agv = s.agvs[static_cast<std::size_t>(below->index)];
    const Vector3 v = point_velocity(s.landing.body, Vector3{c.x, c.y, at[2]} - s.landing.body.position);
    const double dx = c.x - agv.y[A_X];
    const double dy = c.y - agv.y[A_Y];
    c.x = below->cos_yaw * dx + below->sin_yaw * dy;
    c.y = -below->sin_yaw * dx + below->cos_yaw * dy;
    c.yaw = wrap_angle(c.yaw - below->yaw);
    c.state = ContainerState::on_agv;
    c.agv = below->index;
    agv.container = number;
    change_load(agv, config_.agv, c.mass, box_inertia(c.mass, container_length, container_width),
                {below->cos_yaw * v[0] + below->sin_yaw * v[1], -below->sin_yaw * v[0] + below->cos_yaw * v[1], s.landing.body.spin[2]});
  } else if (below != nullptr && (below->kind == Solid::Kind::ship ||
                                  (below->kind == Solid::Kind::container &&
                                   s.containers[static_cast<std::size_t>(below->index)].state == ContainerState::on_ship))) {
    c.state = ContainerState::on_ship;
    if (const ShipPose ship = ship_at(config_, s.containers, s.seconds()); ship.moves) {  // kept as it stands in calm water
      const Vector3 calm = ship.calm(at + frame({s.grip.x, s.grip.y, s.grip.top - container_height}));
      const Vector3 ahead = ship.turn.inverse(frame.column[0]);
      c.x = calm[0], c.y = calm[1], c.z = calm[2];
      c.yaw = wrap_angle(atan2(ahead[1], ahead[0]) + s.grip.yaw);
    }
  }
  // The spreader keeps its own velocity; what the container had, its support takes.
  BodyState& b = s.landing.body;
  s.carried = -1;
  s.grip = {};
  const Vector3 arm = frame(Vector3{0.0, 0.0, 0.0} - underside(s, config_.crane.spreader_mass));
  const Vector3 middle = at + arm;
  b.velocity = point_velocity(b, middle - b.position);
  b.position = middle;
  return number;
}

}  // namespace plant
