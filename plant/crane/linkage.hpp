#pragma once
// The double-link jib of a level-luffing crane, in its plane: jib, fly jib and tie bar form a closed loop of four bars,
// so that the nose, over which the rope runs, keeps its height while the jib luffs. A differential-algebraic system,
// solved by IDA (plant-and-bus.md 1.1 and 1.6). The dock's crane has a straight jib instead; this model is independent
// of the dock.
//
//   loop    jib e(t1) - back e(t2) - B - tie e(t3) = 0,   e(t) = (cos t, sin t), jib's pivot at the origin
//   motion  M(t) t'' + h(t, t') + g(t) = torque on the jib + (d loop / d t)^T lambda
//
// The loop is a constraint on its second derivative, with Baumgarte's terms of 10/s against drift. Inaccuracies: bars
// are rigid, joints without friction; the load hangs vertically below the nose and moves with it.
#include <array>
#include <memory>

namespace plant {

struct LinkageParameters {
  double jib = 26.0, jib_mass = 18e3;   // m, kg, slender
  double fly = 12.0, fly_mass = 6e3;    // m from the joint with the jib to the nose
  double back = 3.2;                    // m from that joint to the tie bar's
  double tie = 27.2, tie_mass = 4e3;    // m
  double base_x = -7.1, base_z = 4.75;  // m, tie bar's pivot from the jib's
  double load = 20e3;                   // kg at the nose
};

class Linkage {
 public:
  // Throws std::invalid_argument for impossible bars, or bars that do not form a loop.
  Linkage(const LinkageParameters&, double tolerance);
  ~Linkage();
  Linkage(const Linkage&) = delete;
  Linkage& operator=(const Linkage&) = delete;

  using Angles = std::array<double, 3>;  // jib, fly jib, tie bar: rad from the horizontal
  // Puts the jib there and the rest where the loop closes, with the rates that follow. Throws if the loop cannot close
  // there.
  void place(double jib_angle, double jib_rate);
  // A torque on the jib (N m), held for `seconds`. Throws std::runtime_error with IDA's reason near a position in which
  // the bars jam.
  void advance(double torque, double seconds);

  const Angles& angles() const { return angle_; }
  const Angles& rates() const { return rate_; }
  std::array<double, 2> nose() const;  // m
  double open() const;                 // m, the gap in the loop
  double energy() const;               // J
  double holding_torque() const;       // N m on the jib that keeps it at rest here
  std::array<double, 2> joint_force()
      const;  // N, of the tie bar on the fly jib, after the last advance or place (torque 0)

  struct Model;  // for IDA's callback

 private:
  struct Solver;
  std::unique_ptr<Model> model_;
  std::unique_ptr<Solver> solver_;
  Angles angle_{}, rate_{};
  std::array<double, 2> force_{};
};

}  // namespace plant
