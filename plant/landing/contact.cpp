#include "plant/landing/contact.hpp"

#include <ode/ode.h>

#include <algorithm>

#include "plant/numerics/math.hpp"
#include "plant/numerics/ode_start.hpp"

namespace plant {
namespace {

constexpr double foot_radius = 0.05;  // m
constexpr int most_contacts = 8;      // of one pair of shapes

}  // namespace

struct ContactEngine::Implementation {
  LandingParameters p;
  dWorldID world;
  dBodyID body;
  std::vector<dBodyID> carriers;  // the bodies on which moving solids ride
  dJointGroupID joints;
  std::array<dGeomID, 4> feet{};
  std::array<dGeomID, 2> hulls{};
  dGeomID solid;
  struct Felt {
    dJointFeedback force;
    bool by_crane;
  };
  std::vector<Felt> felt;  // the force of each contact

  explicit Implementation(const LandingParameters& parameters) : p(parameters) {
    start_ode();
    world = dWorldCreate();
    dWorldSetGravity(world, 0.0, 0.0, -gravity);
    dWorldSetAutoDisableFlag(world, 0);
    body = dBodyCreate(world);
    dBodySetGyroscopicMode(body, 1);
    joints = dJointGroupCreate(0);
    for (auto& foot : feet) foot = on_body(dCreateSphere(nullptr, foot_radius));
    for (auto& hull : hulls) hull = on_body(dCreateBox(nullptr, 1.0, 1.0, 1.0));
    solid = dCreateBox(nullptr, 1.0, 1.0, 1.0);
    felt.resize(256);
  }
  ~Implementation() {
    for (auto* foot : feet) dGeomDestroy(foot);
    for (auto* hull : hulls) dGeomDestroy(hull);
    dGeomDestroy(solid);
    dJointGroupDestroy(joints);
    dWorldDestroy(world);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  dGeomID on_body(dGeomID geom) const {
    dGeomSetBody(geom, body);
    return geom;
  }

  void place(const BodyState& s, const BodyShape& shape) {
    dMass mass;
    dMassSetParameters(&mass, shape.mass, 0, 0, 0, shape.inertia[0], shape.inertia[1], shape.inertia[2], 0, 0, 0);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, s.position[0], s.position[1], s.position[2]);
    const dQuaternion turn = {s.turn[0], s.turn[1], s.turn[2], s.turn[3]};
    dBodySetQuaternion(body, turn);
    dBodySetLinearVel(body, s.velocity[0], s.velocity[1], s.velocity[2]);
    dBodySetAngularVel(body, s.spin[0], s.spin[1], s.spin[2]);
    for (std::size_t i = 0; i < feet.size(); ++i)
      dGeomSetOffsetPosition(feet[i], shape.corners[i][0], shape.corners[i][1], shape.corners[i][2] + foot_radius);
    for (std::size_t i = 0; i < static_cast<std::size_t>(shape.hull_count); ++i) {
      const auto& hull = shape.hulls[i];
      dGeomBoxSetLengths(hulls[i], 2 * hull.half[0], 2 * hull.half[1], 2 * hull.half[2]);
      dGeomSetOffsetPosition(hulls[i], hull.centre[0], hull.centre[1], hull.centre[2]);
      const auto [sy, cy] = sin_cos(0.5 * hull.yaw);
      const dQuaternion yaw = {cy, 0, 0, sy};
      dGeomSetOffsetQuaternion(hulls[i], yaw);
    }
  }

  void place(const Solid& below) const {
    dGeomBoxSetLengths(solid, 2 * below.half_x, 2 * below.half_y, below.top - below.bottom);
    const Vector3 middle = below.middle();
    dGeomSetPosition(solid, middle[0], middle[1], middle[2]);
    if (below.tilted) {
      const Matrix3 r = below.frame().axes;
      const dMatrix3 turn = {r(0, 0), r(0, 1), r(0, 2), 0, r(1, 0), r(1, 1), r(1, 2), 0, r(2, 0), r(2, 1), r(2, 2), 0};
      dGeomSetRotation(solid, turn);
      return;
    }
    const auto [sy, cy] = sin_cos(0.5 * below.yaw);
    const dQuaternion yaw = {cy, 0, 0, sy};
    dGeomSetQuaternion(solid, yaw);
  }

  // A body that moves like the solid, for contacts on it.
  dBodyID carrier_of(const Solid& moving, std::size_t& used) {
    if (moving.vx == 0.0 && moving.vy == 0.0 && moving.vz == 0.0 && moving.spin == Vector3{}) return nullptr;
    if (used == carriers.size()) {
      carriers.push_back(dBodyCreate(world));
      dBodySetKinematic(carriers.back());
    }
    auto* const carrier = carriers[used++];
    dBodySetPosition(carrier, moving.x, moving.y, moving.top);
    dBodySetLinearVel(carrier, moving.vx, moving.vy, moving.vz);
    dBodySetAngularVel(carrier, moving.spin[0], moving.spin[1], moving.spin[2]);
    return carrier;
  }

  // Contact joints between one shape of the body and the solid. The surface is a spring and damper
  // (plant-and-bus.md 1.7).
  int touch(dGeomID shape, dBodyID below, bool crane, double h, int count, double& depth) {
    std::array<dContact, most_contacts> contacts{};
    const int n = dCollide(shape, solid, most_contacts, &contacts[0].geom, sizeof(dContact));
    for (int i = 0; i < n && count < static_cast<int>(felt.size()); ++i) {
      dContact& c = contacts[static_cast<std::size_t>(i)];
      c.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
      c.surface.mu = p.friction;
      c.surface.soft_erp = h * p.corner_stiffness / (h * p.corner_stiffness + p.corner_damping);
      c.surface.soft_cfm = 1.0 / (h * p.corner_stiffness + p.corner_damping);
      auto* const joint = dJointCreateContact(world, joints, &c);
      dJointAttach(joint, body, below);
      Felt& here = felt[static_cast<std::size_t>(count)];
      here.by_crane = crane;
      depth = std::max(depth, c.geom.depth);
      dJointSetFeedback(joint, &here.force);
      ++count;
    }
    return count;
  }

  BodyState read() const {
    const dReal* x = dBodyGetPosition(body);
    const dReal* q = dBodyGetQuaternion(body);
    const dReal* v = dBodyGetLinearVel(body);
    const dReal* w = dBodyGetAngularVel(body);
    return {{x[0], x[1], x[2]}, {q[0], q[1], q[2], q[3]}, {v[0], v[1], v[2]}, {w[0], w[1], w[2]}};
  }
};

ContactEngine::ContactEngine(const LandingParameters& parameters)
    : self_(std::make_unique<Implementation>(parameters)) {}
ContactEngine::~ContactEngine() = default;

ContactResult ContactEngine::step(BodyState& state, const BodyShape& shape, const std::array<double, 3>& force,
                                  const std::array<double, 3>& torque, std::span<const Solid> solids, double seconds) {
  start_ode();
  auto& s = *self_;
  s.place(state, shape);
  int count = 0;
  std::size_t carriers = 0;
  ContactResult result;
  double most = -1.0;
  for (const Solid& solid : solids) {
    double depth = -1.0;
    s.place(solid);
    auto* const below = s.carrier_of(solid, carriers);
    const bool crane = solid.kind == Solid::Kind::crane;
    for (auto* foot : s.feet) count = s.touch(foot, below, crane, seconds, count, depth);
    for (std::size_t i = 0; i < static_cast<std::size_t>(shape.hull_count); ++i)
      count = s.touch(s.hulls[i], below, crane, seconds, count, depth);
    if (depth <= most) continue;
    most = depth;
    result.deepest = &solid;
  }
  dBodyAddForce(s.body, force[0], force[1], force[2]);
  dBodyAddTorque(s.body, torque[0], torque[1], torque[2]);
  dWorldStep(s.world, seconds);
  result.contacts = count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const dReal* push = s.felt[i].force.f1;
    result.normal_force += push[2];
    if (s.felt[i].by_crane) result.by_crane = result.by_crane + Vector3{push[0], push[1], push[2]};
  }
  dJointGroupEmpty(s.joints);
  state = s.read();
  return result;
}

}  // namespace plant
