#include "plant/vehicles/agv.hpp"

#include <algorithm>
#include <cmath>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

constexpr double drive_tick_seconds = 0.01;
constexpr double settle_time = 0.05;  // s, time constant of slip in the kinematic model at walking speed

std::array<double, agv_size> tolerances(double relative) {
  std::array<double, agv_size> absolute{};
  absolute.fill(relative);
  absolute[A_FORCE] = relative * 1e5;
  return absolute;
}

double saturate(double force, double limit) { return std::clamp(force, -limit, limit); }

// 0 up to half of the blending speed, 1 from the blending speed on, smooth in between.
double blend(double speed, double edge) {
  const double u = std::clamp((std::fabs(speed) - 0.5 * edge) / (0.5 * edge), 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

void change_load(AgvState& s, const AgvParameters& p, double mass, double inertia,
                 const std::array<double, 3>& motion) {
  const auto share = [&s](AgvCoordinate rate, double old_inertia, double more, double with) {
    if (more > 0.0 && !s.standing) s.y[rate] = (old_inertia * s.y[rate] + more * with) / (old_inertia + more);
  };
  share(A_SPEED, p.mass + s.load_mass, mass - s.load_mass, motion[0]);
  share(A_SIDE, p.mass + s.load_mass, mass - s.load_mass, motion[1]);
  share(A_YAW_RATE, p.yaw_inertia + s.load_inertia, inertia - s.load_inertia, motion[2]);
  s.load_mass = mass;
  s.load_inertia = inertia;
}

AgvMotion::AgvMotion(const AgvParameters& parameters, double tolerance)
    : p_(parameters), integrator_({.order = 3, .relative = tolerance}, tolerances(tolerance), &AgvMotion::derivative) {}

void AgvMotion::derivative(void* data, double, const double* y, double* yd) {
  const auto& self = *static_cast<const AgvMotion*>(data);
  const AgvParameters& p = self.p_;
  const AgvState& s = *self.state_;
  if (p.drive == AgvDrive::differential) return self.differential(y, yd);
  const auto rate = [&](double command, double angle) {
    return std::clamp((command - angle) / p.steer_lag, -p.steer_rate, p.steer_rate);
  };
  yd[A_FRONT] = rate(s.current.front, y[A_FRONT]);
  yd[A_REAR] = rate(s.current.rear, y[A_REAR]);
  yd[A_FORCE] = (s.command - y[A_FORCE]) / p.drive_lag;
  if (s.standing) {
    std::fill(yd, yd + A_FRONT, 0.0);
    return;
  }

  const double m = self.mass(s);
  const double inertia = p.yaw_inertia + s.load_inertia;
  const double base = p.front + p.rear;
  const double v = y[A_SPEED];
  const double side = y[A_SIDE];
  const double r = y[A_YAW_RATE];
  const auto [sh, ch] = sin_cos(y[A_HEADING]);
  const auto [sf, cf] = sin_cos(y[A_FRONT]);
  const auto [sr, cr] = sin_cos(y[A_REAR]);
  yd[A_X] = v * ch - side * sh;
  yd[A_Y] = v * sh + side * ch;
  yd[A_HEADING] = r;

  const double resistance = p.rolling * m * gravity * tanh(v / 0.02) + p.drag * v * std::fabs(v);
  double along = y[A_FORCE] - resistance;
  // Kinematic bicycle: no slip at either axle.
  const double tf = sf / cf;
  const double tr = sr / cr;
  double side_rate = (v * (p.rear * tf + p.front * tr) / base - side) / settle_time;
  double turn_rate = (v * (tf - tr) / base - r) / settle_time;
  const double weight = blend(v, p.blend_speed);
  if (weight > 0.0) {
    // In reverse, a wheel turned to the left rolls to the right.
    const double way = v < 0.0 ? -1.0 : 1.0;
    const double slip_front = atan2(side + p.front * r, std::fabs(v)) - way * y[A_FRONT];
    const double slip_rear = atan2(side - p.rear * r, std::fabs(v)) - way * y[A_REAR];
    const double front = -saturate(p.cornering * slip_front, p.adhesion * m * gravity * p.rear / base);
    const double rear = -saturate(p.cornering * slip_rear, p.adhesion * m * gravity * p.front / base);
    along -= weight * (front * sf + rear * sr);
    side_rate = weight * ((front * cf + rear * cr) / m - v * r) + (1.0 - weight) * side_rate;
    turn_rate = weight * ((p.front * front * cf - p.rear * rear * cr) / inertia) + (1.0 - weight) * turn_rate;
  }
  yd[A_SPEED] = along / m + weight * side * r;
  yd[A_SIDE] = side_rate;
  yd[A_YAW_RATE] = turn_rate;
}

// The rate at which a vehicle with differential drive is to turn now. Without set-points it keeps its curve while it
// brakes, and a turn on the spot ends.
double AgvMotion::turn_of(const AgvState& s) {
  if (!s.dry) return s.current.turn;
  return s.current.speed == 0.0 ? 0.0 : s.current.turn * std::clamp(s.reference / s.current.speed, 0.0, 1.0);
}

// Two wheels beside the middle follow their commanded speeds with the drive's lag and push by their slip; castors carry
// the rest.
void AgvMotion::differential(const double* y, double* yd) const {
  const AgvState& s = *state_;
  const double half_track = 0.5 * p_.track;
  const double turn = turn_of(s);
  yd[A_LEFT] = (s.reference - turn * half_track - y[A_LEFT]) / p_.drive_lag;
  yd[A_RIGHT] = (s.reference + turn * half_track - y[A_RIGHT]) / p_.drive_lag;
  yd[A_FORCE] = 0.0;
  if (s.standing) {
    std::fill(yd, yd + A_FRONT, 0.0);
    return;
  }
  const double m = mass(s);
  const double v = y[A_SPEED], side = y[A_SIDE], r = y[A_YAW_RATE];
  const auto [sh, ch] = sin_cos(y[A_HEADING]);
  yd[A_X] = v * ch - side * sh;
  yd[A_Y] = v * sh + side * ch;
  yd[A_HEADING] = r;
  const double grip = 0.5 * p_.adhesion * m * gravity;
  const double left = saturate(p_.wheel_slip * (y[A_LEFT] - (v - r * half_track)), grip);
  const double right = saturate(p_.wheel_slip * (y[A_RIGHT] - (v + r * half_track)), grip);
  // Both tyres' cornering force. Their slip angle is computed at blend_speed or faster, so that it is defined at rest.
  const double across = -saturate(2.0 * p_.cornering * side / std::max(std::fabs(v), p_.blend_speed), 2.0 * grip);
  const double resistance = p_.rolling * m * gravity * tanh(v / 0.02) + p_.drag * v * std::fabs(v);
  yd[A_SPEED] = (left + right - resistance) / m + side * r;
  yd[A_SIDE] = across / m - v * r;
  yd[A_YAW_RATE] = (right - left) * half_track / (p_.yaw_inertia + s.load_inertia);
}

void AgvMotion::advance(AgvState& state, double seconds) {
  state_ = &state;
  std::array<double, agv_size> y = state.y;
  integrator_.advance(this, y, seconds, state.step);
  state.y = y;
}

void AgvMotion::drive_tick(AgvState& s, double allowed) const {
  const double target = s.dry || s.bumped ? 0.0 : std::min(s.current.speed, allowed);
  const double speed = s.y[A_SPEED];
  const bool at_rest = std::fabs(speed) < 0.02 && std::fabs(s.y[A_YAW_RATE]) < 0.02;
  const auto stop = [&s, this] {
    s.standing = true;
    s.reference = s.integral = s.command = 0.0;
    s.y[A_SPEED] = s.y[A_SIDE] = s.y[A_YAW_RATE] = s.y[A_FORCE] = 0.0;
    if (p_.drive == AgvDrive::differential) s.y[A_LEFT] = s.y[A_RIGHT] = 0.0;
  };
  if (s.bumped) {  // the bumper switches the drive off, and the brakes act fully
    s.reference = s.integral = 0.0;
    s.command = -p_.emergency * mass(s) * tanh(speed / 0.05);
    if (at_rest) stop();
    return;
  }
  if (p_.drive == AgvDrive::differential && s.current.turn != 0.0 && !s.dry)
    s.standing = false;
  else if (target == 0.0 && (s.standing || (std::fabs(s.reference) < 1e-9 && at_rest)))
    return stop();
  s.standing = false;

  const double before = s.reference;
  const bool slower = std::fabs(target) < std::fabs(before) || target * before < 0.0;
  const double change = (slower ? p_.braking : p_.acceleration) * drive_tick_seconds;
  s.reference += std::clamp(target - before, -change, change);

  const double m = mass(s);
  const double error = s.reference - speed;
  const double limit = p_.emergency * m;
  const double ahead = m * (s.reference - before) / drive_tick_seconds +
                       p_.rolling * m * gravity * tanh(s.reference / 0.02) +
                       p_.drag * s.reference * std::fabs(s.reference);
  const double wanted = ahead + p_.speed_gain * m * error + s.integral;
  s.command = std::clamp(wanted, -limit, limit);
  if (s.command == wanted) s.integral += p_.speed_integral * p_.speed_gain * m * error * drive_tick_seconds;
}

bool AgvMotion::take_set_point(AgvState& s, Time now) {
  if (s.running && now < s.due) return false;
  if (s.waiting == 0) {
    const bool was_driving = s.running && (s.current.speed != 0.0 || s.current.turn != 0.0);
    s.running = false;
    s.dry = s.dry || was_driving;
    return was_driving;
  }
  s.current = s.fifo[0];
  std::shift_left(s.fifo.begin(), s.fifo.end(), 1);
  --s.waiting;
  s.dry = false;
  s.due = (s.running ? s.due : now) + s.period;
  s.running = true;
  return false;
}

bool AgvMotion::push(AgvState& s, const AgvSetPoint& point) {
  if (s.waiting == static_cast<int>(s.fifo.size())) return false;
  s.fifo[static_cast<std::size_t>(s.waiting++)] = point;
  return true;
}

}  // namespace plant
