#pragma once
// One AGV (plant-and-bus.md 1.5): single-track model with two steered axles, drive and steering lags, or two driven
// wheels; and its drive unit: a FIFO of set-points, each held for the period, and a speed loop at 100 Hz.
#include <array>
#include <cstdint>

#include "plant/numerics/integrator.hpp"
#include "plant/parameters/config.hpp"
#include "plant/parameters/device_codes.hpp"

namespace plant {

// With differential drive A_FRONT and A_REAR are the speeds of the left and the right wheel's rim, m/s.
enum AgvCoordinate : std::uint8_t {
  A_X,
  A_Y,
  A_HEADING,
  A_SPEED,
  A_SIDE,
  A_YAW_RATE,
  A_FRONT,
  A_REAR,
  A_FORCE,
  agv_size
};
inline constexpr AgvCoordinate A_LEFT = A_FRONT, A_RIGHT = A_REAR;

struct AgvSetPoint {
  double speed, front, rear;  // m/s, rad
  double turn = 0.0;          // rad/s, of a vehicle with differential drive
};

struct AgvState {
  std::array<double, agv_size> y{};  // m, rad, m/s, rad/s, N
  double step = 1e-3;                // s, the integrator's first step
  int container = -1;                // on the deck
  double load_mass = 0.0, load_inertia = 0.0;

  std::array<AgvSetPoint, agv_queue> fifo{};
  int waiting = 0;
  AgvSetPoint current{};        // held now
  Time period{20'000'000'000};  // how long each set-point is held
  Time due{0};                  // when the next one is taken; valid while running
  bool running = false;         // set-points are being taken
  bool dry = false;             // no set-points were left while driving; cleared when a set-point is taken
  bool standing = true;         // brakes hold
  bool bumped = false;          // after a collision: brakes until its bumper is reset
  double reference = 0.0;       // m/s, ramped
  double integral = 0.0;        // N
  double command = 0.0;         // N, to the drive
  Time served_since{-1};        // standing loaded in the warehouse since, or -1
};

// The load changes to another mass (kg) and inertia (kg m2 about the vertical). A new load moves with `motion` (m/s
// along and across the vehicle, rad/s) and shares its momentum with the vehicle, unless brakes hold the vehicle. A
// removed load takes its share of the momentum with it.
void change_load(AgvState&, const AgvParameters&, double mass, double inertia, const std::array<double, 3>& motion);

class AgvMotion {
 public:
  AgvMotion(const AgvParameters&, double tolerance);
  // Over an interval with constant commands. A standing vehicle only turns its wheels.
  void advance(AgvState&, double seconds);
  // The drive unit's 100-Hz tick: speed loop, standing brake. allowed: greatest forward speed by the protective field,
  // m/s.
  void drive_tick(AgvState&, double allowed) const;
  // Takes the next set-point if it is due at `now`. True if there was none while driving.
  static bool take_set_point(AgvState&, Time now);
  static bool push(AgvState&, const AgvSetPoint&);  // false: full, dropped

 private:
  static void derivative(void* self, double t, const double* y, double* yd);
  void differential(const double* y, double* yd) const;
  static double turn_of(const AgvState&);
  double mass(const AgvState& s) const { return p_.mass + s.load_mass; }

  AgvParameters p_;
  Integrator integrator_;
  const AgvState* state_ = nullptr;
};

}  // namespace plant
