#pragma once
// Rigid-body contact by ODE: one free body, touching solids, stepped with dWorldStep. Holds no state between steps.
#include <array>
#include <memory>
#include <span>

#include "plant/scene/scene.hpp"

namespace plant {

struct BodyState {
  std::array<double, 3> position{};           // centre of mass, m
  std::array<double, 4> turn = {1, 0, 0, 0};  // quaternion w, x, y, z
  std::array<double, 3> velocity{}, spin{};   // world, m/s and rad/s
};

// The body's shape and inertia in its own frame, whose origin is the centre of mass.
struct BodyShape {
  double mass;                                   // kg
  std::array<double, 3> inertia;                 // kg m2, principal
  std::array<std::array<double, 3>, 4> corners;  // feet that carry it, m
  struct Hull {
    std::array<double, 3> centre, half;
    double yaw;
  };
  std::array<Hull, 2> hulls;
  int hull_count;
};

struct ContactResult {
  int contacts = 0;
  double normal_force = 0.0;         // N, sum of the upward parts
  std::array<double, 3> by_crane{};  // N, the push by the crane's own legs
  const Solid* deepest = nullptr;    // the solid with the deepest contact
};

class ContactEngine {
 public:
  explicit ContactEngine(const LandingParameters&);
  ~ContactEngine();
  ContactEngine(const ContactEngine&) = delete;
  ContactEngine& operator=(const ContactEngine&) = delete;

  // One step of `seconds` under gravity, a force at the centre of mass and a torque, both constant and in world axes.
  ContactResult step(BodyState&, const BodyShape&, const std::array<double, 3>& force,
                     const std::array<double, 3>& torque, std::span<const Solid>, double seconds);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace plant
