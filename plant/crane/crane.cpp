#include "plant/crane/crane.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "plant/numerics/frame.hpp"
#include "plant/numerics/math.hpp"

namespace plant {
namespace {

struct Angles {
  SinCos psi, phi, alpha, beta;
  double trolley;  // m, the gantry's value of phi
  explicit Angles(const CraneVector& q) : trolley(q[Q_PHI]) {
    const auto jib = sin_cos(q[Q_PSI], q[Q_PHI]), sway = sin_cos(q[Q_ALPHA], q[Q_BETA]);
    psi = jib[0], phi = jib[1], alpha = sway[0], beta = sway[1];
  }
};

// Calls visit(i) for each i below `count`; a constant count gives constants, so that nothing is left of the loop.
template <class Visit>
[[gnu::always_inline]] inline void each_below(std::size_t count, const Visit& visit) {
  for (std::size_t i = 0; i < count; ++i) visit(i);
}
template <std::size_t count, class Visit>
[[gnu::always_inline]] inline void each_below(std::integral_constant<std::size_t, count>, const Visit& visit) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (visit(std::integral_constant<std::size_t, i>{}), ...);
  }(std::make_index_sequence<count>{});
}

constexpr std::integral_constant<std::size_t, crane_size> all_rows{};

// Symmetric, so the order of rows and columns does not matter.
using CraneColumn = Eigen::Matrix<double, crane_size, 1>;
using CraneSquare = Eigen::Matrix<double, crane_size, crane_size>;

bool is_gantry(const CraneParameters& p) { return p.machine == CraneKind::gantry; }

// A mass point's partial velocities in the slewing frame (radial, tangential, up) and its acceleration when all qdd are
// 0.
struct Point {
  std::array<Vector3, crane_size> partial{};
  Vector3 bias{};
  // Metres per unit of each coordinate: 3 rows, a column per coordinate.
  Eigen::Map<const Eigen::Matrix<double, 3, crane_size>> jacobian() const {
    static_assert(sizeof partial == sizeof(double) * 3 * crane_size);
    return Eigen::Map<const Eigen::Matrix<double, 3, crane_size>>(partial[0].data());
  }
};

// Acceleration in the slewing frame of a point at `at` with relative velocity `u` and relative acceleration `w`.
Vector3 turning(const Vector3& at, const Vector3& u, const Vector3& w, double psid) {
  return {w[0] - 2.0 * psid * u[1] - psid * psid * at[0], w[1] + 2.0 * psid * u[0] - psid * psid * at[1], w[2]};
}

Point jib_point(const CraneParameters& p, const Angles& a, const CraneVector& qd, double along) {
  Point point;
  if (is_gantry(p)) {
    const Vector3 at{a.trolley, 0.0, p.pivot_height};
    point.partial[Q_S] = {a.psi.cos, -a.psi.sin, 0.0};
    point.partial[Q_PSI] = {0.0, at[0], 0.0};
    point.partial[Q_PHI] = {1.0, 0.0, 0.0};
    point.bias = turning(at, qd[Q_PHI] * point.partial[Q_PHI], {}, qd[Q_PSI]);
    return point;
  }
  const double c = along * a.phi.cos;
  const double s = along * a.phi.sin;
  const Vector3 at{p.a0 + c, 0.0, p.pivot_height + s};
  point.partial[Q_S] = {a.psi.cos, -a.psi.sin, 0.0};
  point.partial[Q_PSI] = {0.0, at[0], 0.0};
  point.partial[Q_PHI] = {-s, 0.0, c};
  const double rate = qd[Q_PHI];
  point.bias = turning(at, rate * point.partial[Q_PHI], {-c * rate * rate, 0.0, -s * rate * rate}, qd[Q_PSI]);
  return point;
}

Point payload_point(const CraneParameters& p, const Angles& a, const CraneVector& q, const CraneVector& qd) {
  Point point;
  const double l = q[Q_L];
  const auto [sa, ca] = a.alpha;
  const auto [sb, cb] = a.beta;
  const bool gantry = is_gantry(p);
  const double c = gantry ? a.trolley - p.a0 : p.jib * a.phi.cos;
  const double s = gantry ? 0.0 : p.jib * a.phi.sin;
  const Vector3 along{sa * cb, sb, -ca * cb};
  const Vector3 at{p.a0 + c + l * along[0], l * along[1], p.pivot_height + s + l * along[2]};
  point.partial[Q_S] = {a.psi.cos, -a.psi.sin, 0.0};
  point.partial[Q_PSI] = {-at[1], at[0], 0.0};
  point.partial[Q_PHI] = gantry ? Vector3{1.0, 0.0, 0.0} : Vector3{-s, 0.0, c};
  point.partial[Q_L] = along;
  point.partial[Q_ALPHA] = {l * ca * cb, 0.0, l * sa * cb};
  point.partial[Q_BETA] = {-l * sa * sb, l * cb, l * ca * sb};

  const double ad = qd[Q_ALPHA];
  const double bd = qd[Q_BETA];
  const double pd = qd[Q_PHI];
  const double ld = qd[Q_L];
  const Vector3 along_rate{ad * ca * cb - bd * sa * sb, bd * cb, ad * sa * cb + bd * ca * sb};
  const double square = ad * ad + bd * bd;
  const Vector3 along_second{-square * sa * cb - 2.0 * ad * bd * ca * sb, -bd * bd * sb,
                             square * ca * cb - 2.0 * ad * bd * sa * sb};
  const Vector3 u = pd * point.partial[Q_PHI] + ld * along + l * along_rate;
  const Vector3 luffing = gantry ? Vector3{} : Vector3{-c * pd * pd, 0.0, -s * pd * pd};
  const Vector3 w = luffing + (2.0 * ld) * along_rate + l * along_second;
  point.bias = turning(at, u, w, qd[Q_PSI]);
  return point;
}

void add_force(CraneVector& sum, const Point& point, const Vector3& force) {
  Eigen::Map<CraneColumn>(sum.data()) += point.jacobian().transpose() * eigen(force);
}

// h + g: the force for the inertia of each mass, with `motion` times the velocity terms and `weight` times gravity.
CraneVector bias_and_gravity(const CraneParameters& p, const Angles& a, const CraneVector& q, const CraneVector& qd,
                             const Payload& payload, double motion, double weight) {
  CraneVector sum{};
  const Vector3 up{0.0, 0.0, weight * gravity};
  const Point jib = jib_point(p, a, qd, p.jib_centre);
  add_force(sum, jib, p.jib_mass * (motion * jib.bias + up));
  const Point load = payload_point(p, a, q, qd);
  add_force(sum, load, payload.mass * (motion * load.bias + up));
  // The counterweight moves on a circle; its force acts only on the gantry.
  sum[Q_S] += motion * p.counterweight * p.counterweight_radius * qd[Q_PSI] * qd[Q_PSI] * a.psi.cos;
  if (is_gantry(p)) return sum;
  // The slender jib turns about its centre: T = I_j (phid^2 + cos^2 phi psid^2) / 2.
  const double slender = motion * p.jib_inertia * a.phi.sin * a.phi.cos;
  sum[Q_PSI] -= 2.0 * slender * qd[Q_PHI] * qd[Q_PSI];
  sum[Q_PHI] += slender * qd[Q_PSI] * qd[Q_PSI];
  return sum;
}

double square(double x) { return x * x; }

void add_rotors(const CraneParameters& p, CraneMatrix& m) {
  for (std::size_t j = 0; j < joint_count; ++j) {
    const auto& drive = p.drives[j];
    const auto k = coordinate_of(j);
    m[k][k] += drive.rotor_inertia * square(drive.gear);
  }
}

// M up to the diagonal, plant-and-bus.md 1.3; above it are zeros.
CraneMatrix closed_form(const CraneParameters& p, const Angles& angles, const CraneVector& q, const Payload& payload) {
  const double mp = payload.mass;
  const double l = q[Q_L];
  const double sp = angles.psi.sin, cp = angles.psi.cos, sf = angles.phi.sin, cf = angles.phi.cos;
  const double sa = angles.alpha.sin, ca = angles.alpha.cos, sb = angles.beta.sin, cb = angles.beta.cos;
  const double r = p.a0 + p.jib * cf;
  const double a = mp * p.jib + p.jib_mass * p.jib_centre;
  const double mu = p.jib_mass * (p.a0 + p.jib_centre * cf) + mp * r - p.counterweight * p.counterweight_radius;
  const double cos_am = ca * cf + sa * sf;  // cos(alpha - phi)
  const double sin_am = sa * cf - ca * sf;

  CraneMatrix m{};
  m[Q_S][Q_S] = p.gantry_mass + p.jib_mass + p.counterweight + mp;
  m[Q_PSI][Q_S] = -(mu + mp * l * sa * cb) * sp - mp * l * sb * cp;
  m[Q_PHI][Q_S] = -a * sf * cp;
  m[Q_L][Q_S] = mp * (sa * cb * cp - sb * sp);
  m[Q_ALPHA][Q_S] = mp * l * ca * cb * cp;
  m[Q_BETA][Q_S] = -mp * l * (sa * sb * cp + cb * sp);
  m[Q_PSI][Q_PSI] = p.slew_inertia + p.jib_inertia * square(cf) + p.counterweight * square(p.counterweight_radius) +
                    p.jib_mass * square(p.a0 + p.jib_centre * cf) + mp * (square(r + l * sa * cb) + square(l * sb)) +
                    payload.inertia;
  m[Q_PHI][Q_PSI] = mp * p.jib * l * sf * sb;
  m[Q_L][Q_PSI] = mp * r * sb;
  m[Q_ALPHA][Q_PSI] = -mp * l * l * ca * sb * cb;
  m[Q_BETA][Q_PSI] = mp * l * (r * cb + l * sa);
  m[Q_KAPPA][Q_PSI] = payload.inertia;
  m[Q_PHI][Q_PHI] = p.jib_inertia + p.jib_mass * square(p.jib_centre) + mp * square(p.jib);
  m[Q_L][Q_PHI] = -mp * p.jib * cb * cos_am;
  m[Q_ALPHA][Q_PHI] = mp * p.jib * l * cb * sin_am;
  m[Q_BETA][Q_PHI] = mp * p.jib * l * sb * cos_am;
  m[Q_L][Q_L] = mp;
  m[Q_ALPHA][Q_ALPHA] = mp * square(l * cb);
  m[Q_BETA][Q_BETA] = mp * square(l);
  m[Q_KAPPA][Q_KAPPA] = payload.inertia;
  add_rotors(p, m);
  return m;
}

// The gantry's mass matrix: the sum over its masses of the products of their partial velocities.
CraneMatrix from_points(const CraneParameters& p, const Angles& a, const CraneVector& q, const Payload& payload) {
  CraneMatrix m{};
  const auto add = [&m](double mass, const Point& point) {
    const auto partial = point.jacobian();
    Eigen::Map<CraneSquare>(m[0].data()).noalias() += mass * (partial.transpose() * partial);
  };
  add(p.jib_mass, jib_point(p, a, {}, 0.0));
  add(payload.mass, payload_point(p, a, q, {}));
  m[Q_S][Q_S] += p.gantry_mass + p.counterweight;
  m[Q_PSI][Q_PSI] += p.slew_inertia + p.counterweight * square(p.counterweight_radius) + payload.inertia;
  m[Q_S][Q_PSI] += p.counterweight * p.counterweight_radius * a.psi.sin;
  m[Q_PSI][Q_S] += p.counterweight * p.counterweight_radius * a.psi.sin;
  m[Q_PSI][Q_KAPPA] += payload.inertia;
  m[Q_KAPPA][Q_PSI] += payload.inertia;
  m[Q_KAPPA][Q_KAPPA] += payload.inertia;
  add_rotors(p, m);
  return m;
}

// Factors need no more than M up to the diagonal.
CraneMatrix lower_mass_matrix(const CraneParameters& p, const Angles& a, const CraneVector& q, const Payload& payload) {
  return is_gantry(p) ? from_points(p, a, q, payload) : closed_form(p, a, q, payload);
}

Vector3 to_world(const Angles& a, const Vector3& v) {
  return {a.psi.cos * v[0] - a.psi.sin * v[1], a.psi.sin * v[0] + a.psi.cos * v[1], v[2]};
}

Vector3 velocity(const Angles& a, const Point& point, const CraneVector& qd) {
  return to_world(a, vector_of(point.jacobian() * Eigen::Map<const CraneColumn>(qd.data())));
}

}  // namespace

Crane::Crane(const CraneParameters& parameters) : p_(parameters) {
  for (std::size_t j = 0; j < joint_count; ++j) {
    const DriveParameters& d = p_.drives[j];
    const double rated = d.rated_force(), speed = d.rated_joint_speed(), coulomb = d.coulomb * rated;
    joints_[j] = {.smooth = d.smooth_speed * speed,
                  .coulomb = coulomb,
                  .bump = (d.stribeck - 1.0) * coulomb,
                  .bump_speed = d.stribeck_speed * speed,
                  .viscous = d.viscous * rated / speed,
                  .gear = d.gear * d.efficiency,
                  .half_gear = 0.5 * d.gear,
                  .either_way = 1.0 / d.efficiency + d.efficiency,
                  .loss = 1.0 / d.efficiency - d.efficiency};
  }
}

CraneMatrix Crane::mass_matrix(const CraneVector& q, const Payload& payload) const {
  CraneMatrix m = lower_mass_matrix(p_, Angles(q), q, payload);
  if (!is_gantry(p_)) each_below(all_rows, [&](auto i) { each_below(i, [&](auto j) { m[j][i] = m[i][j]; }); });
  return m;
}

CraneVector Crane::bias(const CraneVector& q, const CraneVector& qd, const Payload& payload) const {
  return bias_and_gravity(p_, Angles(q), q, qd, payload, 1.0, 0.0);
}

CraneVector Crane::gravity_force(const CraneVector& q, const Payload& payload) const {
  return bias_and_gravity(p_, Angles(q), q, {}, payload, 0.0, 1.0);
}

double Crane::kinetic_energy(const CraneVector& q, const CraneVector& qd, const Payload& payload) const {
  const CraneMatrix m = mass_matrix(q, payload);
  const Eigen::Map<const CraneColumn> rate(qd.data());
  return 0.5 * rate.dot(Eigen::Map<const CraneSquare>(m[0].data()) * rate);
}

double Crane::potential_energy(const CraneVector& q, const Payload& payload) const {
  const double jib = p_.pivot_height + (is_gantry(p_) ? 0.0 : p_.jib_centre * sin(q[Q_PHI]));
  return gravity * (p_.jib_mass * jib + payload.mass * payload_position(q)[2]);
}

namespace {

// The free coordinates in their order.
struct FreeCoordinates {
  std::array<std::size_t, crane_size> at{};
  std::size_t count = 0;
  explicit FreeCoordinates(unsigned locked) {
    for (std::size_t k = 0; k < crane_size; ++k)
      if ((locked >> k & 1U) == 0) at[count++] = k;
  }
};

// With all seven coordinates free, factors and solution take 544 host instructions (callgrind, -O2). On average over
// 20,000 random matrices, a quarter of them with two locked coordinates, Eigen 3.4's LLT in place took 2,650 and its
// LDLT 3,630.
template <class Count>
[[gnu::always_inline]] inline void factor_rows(const CraneMatrix& m, Factors& f, Count n) {
  each_below(n, [&](auto i) {
    double diagonal = m[i][i];
    each_below(i, [&](auto j) {
      double scaled = m[i][j];
      each_below(j, [&](auto k) { scaled -= f.lower[i][k] * f.lower[j][k] * f.inverse[k]; });
      f.lower[i][j] = scaled;
    });
    each_below(i, [&](auto j) { diagonal -= f.lower[i][j] * f.lower[i][j] * f.inverse[j]; });
    f.inverse[i] = 1.0 / diagonal;
  });
}

template <class Count>
[[gnu::always_inline]] inline void solve_rows(const Factors& f, CraneVector& x, Count n) {
  each_below(n, [&](auto i) { each_below(i, [&](auto j) { x[i] -= f.lower[i][j] * f.inverse[j] * x[j]; }); });
  each_below(n, [&](auto done) {
    const std::size_t i = n - 1 - done;
    each_below(done, [&](auto back) {
      const std::size_t j = n - done + back;
      x[i] -= f.lower[j][i] * x[j];
    });
    x[i] *= f.inverse[i];
  });
}

void factor(const CraneMatrix& m, unsigned locked, Factors& f) {
  f.locked = locked;
  if (locked == 0) {
    factor_rows(m, f, all_rows);
    return;
  }
  const FreeCoordinates free(locked);
  CraneMatrix some;
  for (std::size_t i = 0; i < free.count; ++i)
    for (std::size_t j = 0; j <= i; ++j) some[i][j] = m[free.at[i]][free.at[j]];
  factor_rows(some, f, free.count);
}

}  // namespace

void Factors::solve(CraneVector& b) const {
  if (locked == 0) {
    solve_rows(*this, b, all_rows);
    return;
  }
  const FreeCoordinates free(locked);
  CraneVector x;
  for (std::size_t i = 0; i < free.count; ++i) x[i] = b[free.at[i]];
  solve_rows(*this, x, free.count);
  b = {};
  for (std::size_t i = 0; i < free.count; ++i) b[free.at[i]] = x[i];
}

CraneVector Crane::solve(const CraneMatrix& m, const CraneVector& b, unsigned locked) {
  Factors f;
  factor(m, locked, f);
  CraneVector x = b;
  f.solve(x);
  return x;
}

Crane::Dynamics Crane::dynamics(const CraneVector& q, const CraneVector& qd, const Payload& payload,
                                unsigned locked) const {
  const Angles a(q);
  Dynamics d;
  factor(lower_mass_matrix(p_, a, q, payload), locked, d.mass);
  d.resisting = bias_and_gravity(p_, a, q, qd, payload, 1.0, 1.0);
  std::array<std::size_t, joint_count + 1> moving;
  std::size_t count = 0;
  for (std::size_t j = 0; j < joint_count; ++j) {
    const double v = qd[coordinate_of(j)];
    if ((locked >> coordinate_of(j) & 1U) != 0) continue;
    d.direction[j] = v / joints_[j].smooth;
    d.stribeck[j] = bump_exponent(joints_[j], v);
    moving[count++] = j;
  }
  if (count % 2 != 0) moving[count] = moving[count - 1];  // the last one goes with itself
  for (std::size_t i = 0; i < count; i += 2) {
    tanh_both(d.direction[moving[i]], d.direction[moving[i + 1]]);
    small_exp_both(d.stribeck[moving[i]], d.stribeck[moving[i + 1]]);
  }
  return d;
}

CraneVector Crane::acceleration(const Dynamics& d, const CraneVector& force) {
  CraneVector rest;
  for (std::size_t k = 0; k < crane_size; ++k) rest[k] = force[k] - d.resisting[k];
  d.mass.solve(rest);
  return rest;
}

// The sign of a joint's speed, smooth around rest.
double Crane::direction(const JointForces& joint, double v) const { return tanh(v / joint.smooth); }

double Crane::behind_gear(std::size_t j, double torque, double direction) const {
  const JointForces& joint = joints_[j];
  const double toward = std::copysign(1.0, torque) * direction;
  return joint.half_gear * torque * (joint.either_way - joint.loss * toward);
}

double Crane::friction_towards(const JointForces& joint, double v, double direction, double bump) const {
  return (joint.coulomb + joint.bump * bump) * direction + joint.viscous * v;
}

// The exponent of the Stribeck curve's share of its value at rest; 0 where no double could show the share.
double Crane::bump_exponent(const JointForces& joint, double v) const {
  const double x = v / joint.bump_speed;
  return -x * x;
}

double Crane::gear_force(std::size_t joint, double torque, double v) const {
  if (!p_.gear_losses) return joints_[joint].gear * torque;
  return behind_gear(joint, torque, direction(joints_[joint], v));
}

Joints Crane::drive_forces(const Joints& torque, const CraneVector& qd,
                           const std::array<std::int8_t, joint_count>& sliding, const Dynamics& dynamics) const {
  Joints forces{};
#pragma GCC unroll 5
  for (std::size_t j = 0; j < joint_count; ++j) {
    const auto k = coordinate_of(j);
    if ((dynamics.mass.locked >> k & 1U) != 0) continue;
    const double direction = dynamics.direction[j];
    const double gear = p_.gear_losses ? behind_gear(j, torque[j], direction) : joints_[j].gear * torque[j];
    forces[j] =
        gear - friction_towards(joints_[j], qd[k], sliding[j] != 0 ? sliding[j] : direction, dynamics.stribeck[j]);
  }
  return forces;
}

double Crane::static_friction(int joint) const {
  const auto& drive = p_.drives[static_cast<std::size_t>(joint)];
  return std::max(drive.stribeck, 1.0) * drive.coulomb * drive.rated_force();
}

double Crane::friction(int j, double v, int sliding) const {
  const JointForces& joint = joints_[static_cast<std::size_t>(j)];
  return friction_towards(joint, v, sliding != 0 ? sliding : direction(joint, v), small_exp(bump_exponent(joint, v)));
}

double Crane::sway_damping(double l, double mass) const {
  return 2.0 * p_.sway_damping * mass * l * std::sqrt(gravity * l);
}

std::array<double, 3> Crane::tip(const CraneVector& q) const {
  const Angles a(q);
  const Vector3 here = is_gantry(p_) ? Vector3{a.trolley, 0.0, p_.pivot_height}
                                     : Vector3{p_.a0 + p_.jib * a.phi.cos, 0.0, p_.pivot_height + p_.jib * a.phi.sin};
  const Vector3 world = to_world(a, here);
  return {world[0] + q[Q_S], world[1], world[2]};
}

std::array<double, 3> Crane::payload_position(const CraneVector& q) const {
  const Angles a(q);
  const double l = q[Q_L];
  const bool gantry = is_gantry(p_);
  const double out = gantry ? a.trolley : p_.a0 + p_.jib * a.phi.cos;
  const double up = gantry ? p_.pivot_height : p_.pivot_height + p_.jib * a.phi.sin;
  const Vector3 world =
      to_world(a, {out + l * a.alpha.sin * a.beta.cos, l * a.beta.sin, up - l * a.alpha.cos * a.beta.cos});
  return {world[0] + q[Q_S], world[1], world[2]};
}

std::array<double, 3> Crane::tip_by_luff(const CraneVector& q) const {
  const auto [sp, cp] = sin_cos(q[Q_PSI]);
  if (is_gantry(p_)) return {cp, sp, 0.0};
  const auto [sf, cf] = sin_cos(q[Q_PHI]);
  return {-p_.jib * sf * cp, -p_.jib * sf * sp, p_.jib * cf};
}

std::array<double, 3> Crane::tip_velocity(const CraneVector& q, const CraneVector& qd) const {
  const Angles a(q);
  return velocity(a, jib_point(p_, a, qd, p_.jib), qd);
}

std::array<double, 3> Crane::payload_velocity(const CraneVector& q, const CraneVector& qd) const {
  const Angles a(q);
  return velocity(a, payload_point(p_, a, q, qd), qd);
}

CraneVector Crane::at_payload(const CraneVector& q, const std::array<double, 3>& world) const {
  const Angles a(q);
  const Vector3 local{a.psi.cos * world[0] + a.psi.sin * world[1], -a.psi.sin * world[0] + a.psi.cos * world[1],
                      world[2]};
  CraneVector sum{};
  add_force(sum, payload_point(p_, a, q, {}), local);
  return sum;
}

double Crane::tension(const CraneVector& q, const CraneVector& qd, const CraneVector& qdd, double mass) const {
  const Angles a(q);
  const Point load = payload_point(p_, a, q, qd);
  Vector3 acceleration = load.bias + vector_of(load.jacobian() * Eigen::Map<const CraneColumn>(qdd.data()));
  acceleration[2] += gravity;
  return -mass * dot(acceleration, load.partial[Q_L]);
}

}  // namespace plant
