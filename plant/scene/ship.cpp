#include "plant/scene/ship.hpp"

#include <numbers>

#include "plant/numerics/math.hpp"
#include "plant/numerics/noise.hpp"
#include "plant/scene/scene.hpp"

namespace plant {
namespace {

struct Wave {
  double size, period;  // m or rad, s
};
constexpr std::array<Wave, 5> waves = {{{0.2, 80.0},
                                        {0.1, 60.0},
                                        {0.1, 10.0},
                                        {0.5 * degree, 12.0},
                                        {0.1 * degree, 8.0}}};  // surge, sway, heave, roll, pitch
constexpr std::array<Stream, 5> streams = {Stream::ship_surge, Stream::ship_sway, Stream::ship_heave, Stream::ship_roll,
                                           Stream::ship_pitch};
constexpr std::array<Wave, 3> parts = {
    {{0.6, 1.0}, {0.3, 0.83}, {0.1, 1.31}}};  // shares of each wave's size and period

struct Value {
  double now = 0.0, rate = 0.0;
};

Value sum_of(const ShipMotion& motion, std::size_t i, double seconds) {
  Value sum;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const double size = motion.scale * waves[i].size * parts[k].size;
    const double rate = 2.0 * std::numbers::pi / (waves[i].period * parts[k].period);
    const double phase = 2.0 * std::numbers::pi * uniform(motion.seed, streams[i], static_cast<std::int64_t>(k));
    const auto [s, c] = sin_cos(rate * seconds + phase);
    sum.now += size * s;
    sum.rate += size * rate * c;
  }
  return sum;
}

}  // namespace

Vector3 ShipPose::at(const Vector3& point) const { return moves ? middle + shift + turn(point - middle) : point; }

Vector3 ShipPose::calm(const Vector3& world) const {
  return moves ? middle + turn.inverse(world - middle - shift) : world;
}

Vector3 ShipPose::velocity_at(const Vector3& world) const { return velocity + cross(spin, world - middle - shift); }

ShipPose ship_at(const DockConfig& config, const std::vector<ContainerData>& containers, double seconds) {
  ShipPose pose;
  pose.moves = config.ship.moves();
  if (!pose.moves) return pose;
  const auto wave = [&](std::size_t i) { return sum_of(config.ship, i, seconds); };
  const Value surge = wave(0), sway = wave(1), heave = wave(2), roll = wave(3), pitch = wave(4);
  double gone = 0.0;  // kg, since the start
  for (const ContainerData& c : containers) {
    const bool on_ship = c.state == ContainerState::on_ship;
    if (on_ship != c.from_ship) gone += on_ship ? -c.mass : c.mass;
  }
  const Box& ship = config.layout.ship;
  pose.middle = {0.5 * (ship.x_min + ship.x_max), 0.5 * (ship.y_min + ship.y_max), 0.0};
  pose.shift = {surge.now, sway.now, heave.now + config.ship.draught * gone};
  pose.velocity = {surge.rate, sway.rate, heave.rate};
  const auto [sr, cr] = sin_cos(roll.now);
  const auto [sp, cp] = sin_cos(pitch.now);
  pose.turn.axes << cp, sp * sr, sp * cr, 0.0, cr, -sr, -sp, cp * sr, cp * cr;
  pose.spin =
      Vector3{roll.rate * cp, pitch.rate, -roll.rate * sp};  // roll turns about the ship's own axis, which pitches
  return pose;
}

}  // namespace plant
