// The twist locks take what the spreader stands on, and let go of what hangs below it.
#include <cmath>

#include "plant/landing/landing_parts.hpp"

namespace plant {

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

Vector3 Landing::carried_at(const DockState& s) const {
  const Vector3 at = payload_position(s);
  const auto [sy, cy] = sin_cos(payload_yaw(s));
  return {at[0] + cy * s.grip.x - sy * s.grip.y, at[1] + sy * s.grip.x + cy * s.grip.y,
          at[2] + s.grip.top - container_height};
}

bool Landing::may_release(const DockState& s) {
  if (s.carried < 0) return true;
  find_near(s);
  const Vector3 at = carried_at(s);
  const Solid* below = support(at[0], at[1], at[2]);
  if (below == nullptr) return true;
  if (below->kind == Solid::Kind::container) return s.containers[static_cast<std::size_t>(below->index)].agv < 0;
  return below->kind != Solid::Kind::mover && below->kind != Solid::Kind::crane;
}

int Landing::release(DockState& s) {
  if (s.carried < 0) return -1;
  find_near(s);
  const Frame frame(s.landing.body.turn);
  const Vector3 at = payload_position(s);
  const double yaw = yaw_of(frame);
  const int number = s.carried;
  ContainerData& c = s.containers[static_cast<std::size_t>(number)];
  const Vector3 standing = carried_at(s);
  c.x = standing[0], c.y = standing[1], c.z = standing[2];
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
                {below->cos_yaw * v[0] + below->sin_yaw * v[1], -below->sin_yaw * v[0] + below->cos_yaw * v[1],
                 s.landing.body.spin[2]});
  } else if (below != nullptr &&
             (below->kind == Solid::Kind::ship ||
              (below->kind == Solid::Kind::container &&
               s.containers[static_cast<std::size_t>(below->index)].state == ContainerState::on_ship))) {
    c.state = ContainerState::on_ship;
    if (const ShipPose ship = ship_at(config_, s.containers, s.seconds());
        ship.moves) {  // kept as it stands in calm water
      const Vector3 calm = ship.calm(at + frame({s.grip.x, s.grip.y, s.grip.top - container_height}));
      const Vector3 ahead = ship.turn.inverse(frame.axis(0));
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
