#include "plant/crane/ode_crane.hpp"

#include <ode/ode.h>

#include <cmath>

#include "plant/numerics/math.hpp"
#include "plant/numerics/ode_start.hpp"

namespace plant {
namespace {

constexpr double speck = 1e-2;  // m, radius of the sphere that is the load
constexpr double thin = 1.0;    // kg m2, where the model has no inertia and ODE needs one

class World {
 public:
  World() : id(dWorldCreate()) { dWorldSetGravity(id, 0.0, 0.0, -gravity); }
  ~World() { dWorldDestroy(id); }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  dBodyID body(double mass, const Vector3& inertia, const Vector3& at, const Vector3& velocity,
               const Vector3& spin) const {
    auto* const b = dBodyCreate(id);
    dMass m;
    dMassSetParameters(&m, mass, 0, 0, 0, inertia[0], inertia[1], inertia[2], 0, 0, 0);
    dBodySetMass(b, &m);
    dBodySetPosition(b, at[0], at[1], at[2]);
    dBodySetLinearVel(b, velocity[0], velocity[1], velocity[2]);
    dBodySetAngularVel(b, spin[0], spin[1], spin[2]);
    dBodySetGyroscopicMode(b, 1);
    return b;
  }

  dWorldID id;
};

void turn(dBodyID body, double psi, double down) {
  dMatrix3 r;
  const auto [sp, cp] = sin_cos(psi);
  const auto [sf, cf] = sin_cos(down);
  const double rows[12] = {cp * cf, -sp, -cp * sf, 0, sp * cf, cp, -sp * sf, 0, sf, 0, cf, 0};
  for (int i = 0; i < 12; ++i) r[i] = rows[i];
  dBodySetRotation(body, r);
}

}  // namespace

CraneVector swing_in_ode(const CraneParameters& p, double payload_mass, const CraneVector& q, const CraneVector& qd,
                         const std::array<double, 3>& force, double step, int steps) {
  start_ode();
  const World world;
  const Crane crane(p);
  const auto [sp, cp] = sin_cos(q[Q_PSI]);
  const auto [sf, cf] = sin_cos(q[Q_PHI]);
  const Vector3 radial{cp, sp, 0.0};
  const Vector3 tangential{-sp, cp, 0.0};
  const Vector3 along = cf * radial + Vector3{0.0, 0.0, sf};
  const Vector3 base{q[Q_S], 0.0, 0.0};
  const Vector3 pivot = base + p.a0 * radial + Vector3{0.0, 0.0, p.pivot_height};
  const Vector3 travel{qd[Q_S], 0.0, 0.0};
  const Vector3 slewing{0.0, 0.0, qd[Q_PSI]};
  const Vector3 luffing = slewing - qd[Q_PHI] * tangential;  // luffing up turns about -e_t

  auto* const gantry = world.body(p.gantry_mass, {thin, thin, thin}, base, travel, {});
  const Vector3 weight = -p.counterweight_radius * radial;
  auto* const platform = world.body(p.counterweight, {p.slew_inertia, p.slew_inertia, p.slew_inertia}, base + weight,
                                    travel + cross(slewing, weight), slewing);
  turn(platform, q[Q_PSI], 0.0);
  auto* const jib = world.body(p.jib_mass, {thin, p.jib_inertia, p.jib_inertia}, pivot + p.jib_centre * along,
                               travel + cross(slewing, p.a0 * radial) + cross(luffing, p.jib_centre * along), luffing);
  turn(jib, q[Q_PSI], q[Q_PHI]);
  const double inertia = 0.4 * payload_mass * speck * speck;
  const Vector3 tip = crane.tip(q);
  const Vector3 at = crane.payload_position(q);
  const Vector3 rope = at - tip;
  const Vector3 relative = crane.payload_velocity(q, qd) - crane.tip_velocity(q, qd);
  const Vector3 swing = (1.0 / dot(rope, rope)) * cross(rope, relative);
  auto* const load = world.body(payload_mass, {inertia, inertia, inertia}, at, crane.payload_velocity(q, qd), swing);

  auto* const slider = dJointCreateSlider(world.id, nullptr);
  dJointAttach(slider, gantry, nullptr);
  dJointSetSliderAxis(slider, 1, 0, 0);
  auto* const slew = dJointCreateHinge(world.id, nullptr);
  dJointAttach(slew, platform, gantry);
  dJointSetHingeAnchor(slew, base[0], base[1], base[2]);
  dJointSetHingeAxis(slew, 0, 0, 1);
  auto* const luff = dJointCreateHinge(world.id, nullptr);
  dJointAttach(luff, jib, platform);
  dJointSetHingeAnchor(luff, pivot[0], pivot[1], pivot[2]);
  dJointSetHingeAxis(luff, -tangential[0], -tangential[1], 0);
  auto* const hook = dJointCreateBall(world.id, nullptr);
  dJointAttach(hook, load, jib);
  dJointSetBallAnchor(hook, tip[0], tip[1], tip[2]);

  for (int i = 0; i < steps; ++i) {
    dJointAddSliderForce(slider, force[0]);
    dJointAddHingeTorque(slew, force[1]);
    dJointAddHingeTorque(luff, force[2]);
    dWorldStep(world.id, step);
  }

  CraneVector end = q;
  end[Q_S] = dBodyGetPosition(gantry)[0];
  const dReal* turned = dBodyGetRotation(platform);
  end[Q_PSI] = atan2(turned[4], turned[0]);
  const dReal* raised = dBodyGetRotation(jib);
  end[Q_PHI] = atan2(raised[8], std::sqrt(raised[0] * raised[0] + raised[4] * raised[4]));
  const dReal* x = dBodyGetPosition(load);
  dVector3 anchor;
  dJointGetBallAnchor2(hook, anchor);
  const Vector3 hang{x[0] - anchor[0], x[1] - anchor[1], x[2] - anchor[2]};
  const auto [s, c] = sin_cos(end[Q_PSI]);
  const double outward = c * hang[0] + s * hang[1];
  end[Q_ALPHA] = atan2(outward, -hang[2]);
  end[Q_BETA] = atan2(-s * hang[0] + c * hang[1], std::sqrt(outward * outward + hang[2] * hang[2]));
  return end;
}

}  // namespace plant
