// One exchange of the landing: falls, guides, corner switches, and the body's step.
#include <algorithm>
#include <cmath>

#include "plant/landing/landing_parts.hpp"

namespace plant {
namespace {

constexpr double head_height =
    1.5;  // m, the falls' lower ends above the underside (their upper ends as much above the tip)

}  // namespace

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

// Flipper guides around a container's top, or cones around an AGV's deck: a funnel that narrows downwards,
// frictionless, from an elastic potential in (lateral error less the funnel's half width).
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

Landing::Outcome Landing::step(DockState& s, const Crane& crane, const Vector3& wind, double seconds) {
  find_near(s);
  read_corners(s);
  Forces forces;
  add_falls(s, crane, seconds, forces);
  add_guides(s, forces);
  forces.force = forces.force + wind;
  s.landing.tension = forces.tension;

  Outcome outcome;
  const Vector3 velocity = s.landing.body.velocity;
  const ContactResult result = engine_.step(s.landing.body, shape(s), forces.force, forces.torque, near_, seconds);
  forces.crane[Q_S] -= result.by_crane[0];  // the rails take what pushes a leg across
  s.inputs.external = forces.crane;
  s.landing.contacts = result.contacts;
  if (result.contacts > 0 && !s.landing.touched) {
    s.landing.touched = outcome.touched = true;
    // What is touched may move: a container on a ship, a vehicle, a mover, a leg of the travelling crane.
    const Vector3 middle =
        s.landing.body.position + Frame(s.landing.body.turn)(Vector3{0.0, 0.0, shape(s).corners[0][2]});
    const Vector3 against = velocity - result.deepest->velocity_at(middle);
    outcome.vertical = -against[2];
    outcome.horizontal = std::sqrt(against[0] * against[0] + against[1] * against[1]);
  }
  outcome.clear = result.contacts == 0 && forces.taut;
  return outcome;
}

}  // namespace plant
