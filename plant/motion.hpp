#pragma once
// The crane moving: equations of motion, drives, friction and brakes, integrated over an interval in which the commands are held.
#include <array>

#include "plant/crane.hpp"
#include "plant/integrator.hpp"

namespace plant {

struct CraneState {
  CraneVector q{}, qd{};
  Joints torque{};      // motor side, N m, behind the current loop's lag
  double step = 1e-4;   // s, with which the integrator begins
};

// The sway angles, as bits of CraneInputs::locked.
inline constexpr unsigned sway_coordinates = 1U << Q_ALPHA | 1U << Q_BETA;

// What is held while the crane moves.
struct CraneInputs {
  Joints command{};            // motor torque, N m
  std::array<bool, joint_count> braked{};  // brake closed and slipping
  unsigned locked = 0;         // coordinates held at rest: brakes that hold, sway angles at L0 and L2
  Payload payload{};
  CraneVector external{};      // generalised forces besides the drives
};

class CraneMotion {
 public:
  CraneMotion(const CraneParameters&, double tolerance, int order = 4);
  const Crane& crane() const { return crane_; }

  void advance(CraneState&, const CraneInputs&, double seconds);
  CraneVector acceleration(const CraneState&, const CraneInputs&) const;
  // Forces that the locked coordinates' brakes must hold, 0 for the free ones.
  CraneVector holding_force(const CraneState&, const CraneInputs&) const;

  // Tests: fixed steps, and an independent multistep integrator.
  void advance_fixed(CraneState&, const CraneInputs&, double seconds, double step);
  void advance_reference(CraneState&, const CraneInputs&, double seconds, bool stiff);
  // Brings one coordinate to rest by an impulse there; the others feel it through the crane's inertia.
  void stop(CraneState&, const CraneInputs&, std::size_t coordinate) const;
  // CVODES' forward sensitivities: derivatives of (q, qd, torque) after `seconds` by the payload's mass and by the rope's length at the start.
  std::array<std::array<double, 2 * crane_size + joint_count>, 2> sensitivity(const CraneState&, const CraneInputs&, double seconds) const;
  long evaluations() const { return integrator_.evaluations(); }

  static constexpr std::size_t size = 2 * crane_size + joint_count;

 private:
  using Packed = std::array<double, size>;
  static void derivative(void* self, const double* y, double* yd);
  static Packed pack(const CraneState&);
  static void unpack(const Packed&, CraneState&);
  CraneVector applied_force(const CraneVector& q, const CraneVector& qd, const Joints& torque, const CraneInputs&) const;

  Crane crane_;
  double tolerance_;
  Packed absolute_;
  Integrator integrator_;
  const CraneInputs* inputs_ = nullptr;
};

}  // namespace plant
