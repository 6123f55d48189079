#pragma once
// Wind on the load: a mean, and gusts along it by Kaimal's spectrum. A function of time and of the parameters,
// including the seed: there is no state.
//
//   n S(n) / sigma^2 = 4 f / (1 + 6 f)^(5/3),   f = n L / U     (control-notes.md 3; Kaimal et al. 1972 in the form of
//   IEC 61400-1)
//
// 224 lines, with frequencies drawn within bands of equal ratio and phases drawn from the circle; a line has the
// variance of its band. So the variance is sigma^2 for every seed, and no two lines have a common period. Between nodes
// at 20 Hz the speed is linear.
#include <array>
#include <cstdint>

#include "plant/parameters/config.hpp"

namespace plant {

inline constexpr double air_density = 1.225;     // kg/m3
inline constexpr double least_gusty_mean = 1.0;  // m/s: the mean wind carries the gusts past the load

class Wind {
 public:
  // The parameters must have passed `check`.
  explicit Wind(const WindParameters&);
  const WindParameters& parameters() const { return p_; }

  // Speed along its direction at `seconds`, m/s.
  double speed(double seconds);
  // The exact mean from one instant to a later one, at most 5 s later, m/s.
  double mean(double from, double to);
  // Force on a load that moves with `velocity` (world, m/s) and whose long side points to `yaw`, rad; N, world axes,
  // horizontal: 1/2 rho C_d A |w| w of the velocity w of the air relative to the load.
  std::array<double, 3> force(double seconds, const std::array<double, 3>& velocity, double yaw, bool container);

 private:
  static constexpr std::size_t lines = 224;
  static constexpr std::size_t kept = 128;  // more nodes than a mean over 5 s needs
  double node(std::int64_t number);
  double integral(double from, double to);  // between two neighbouring nodes, in units of their distance

  WindParameters p_;
  double sin_direction_, cos_direction_;
  std::array<double, lines> rate_{}, phase_{}, size_{};  // rad/s, rad, m/s
  // Computed nodes, by number modulo `kept`: a cache that changes no value.
  struct Node {
    std::int64_t number;
    double speed;
  };
  std::array<Node, kept> nodes_;
};

}  // namespace plant
