#pragma once
// The crane's processes: 1 identify, 2 plan the grab, 3 grab, 4 load, 7 go home.
//
// Process 3: leg 1 to above the container, settle, lower, lock, raise, leg 2 to above the AGV, settle. Process 4: lower, open, raise.
// Process 7: plan leg 3, follow it, settle. Lowering and raising are hoist ramps that PID adds to its set-point.
// Processes 1 and 2 are one block each and run beside process 4.
#include <cstdint>
#include <optional>

#include "cmrc/chain.hpp"
#include "cmrc/config.hpp"
#include "cmrc/consents.hpp"
#include "cmrc/desk.hpp"

namespace cmrc {

/// What the host knows of the crane's world, SI units.
struct CraneJob {
  double clearance = 0.6;       ///< m, between a route's end and the surface it aims at
  double slack = 0.1;           ///< m, by which lowering goes further
  double ramp_speed = 0.15;     ///< m/s, peak
  double settle_limit = 20;     ///< s, waiting for the load to come to rest
  double empty_mass = 10e3;     ///< kg on the rope
  double full_mass = 40480;
  double refresh_frequency = 8000;
  std::int64_t servo_interval = 8;
  std::int64_t point_interval = 64;
  std::int64_t buffer_points = 2;
};

/// What PID told the host last.
struct PidStatus {
  std::int64_t tick = 0;
  bool landed = false, locked = false, open = false, starved = false, settled = false, ramp_done = false;
};

/// Who stands in the loading spot.
class Berth {
 public:
  virtual ~Berth() = default;
  virtual std::optional<unsigned> agv_in_spot() const = 0;
};

class CraneProcesses {
 public:
  CraneProcesses(const CraneJob& job, const Words& words, Consents& consents);

  /// The run begins: process 1 is loaded (item 15).
  void start(Desk& desk);
  void finished(const Task& task, Word result, Word notify, Desk& desk);
  /// A block was dropped after too many recomputations: what it was for is asked for again.
  void dropped(const Task& task);
  /// Moves on as far as the last reports allow.
  void refresh(Desk& desk, const Berth& berth);

  /// The container that process 4 has just set down stands on this AGV; asked once.
  std::optional<unsigned> take_loaded_agv();
  /// An AGV is being loaded.
  std::optional<unsigned> loading() const;
  bool servoing() const { return motion_ != Motion::off; }
  bool job_done() const { return job_done_; }
  /// Process 3 holds a container, or is on its way to hold one.
  bool grabbing() const;
  const PidStatus& pid() const { return pid_; }
  const PointChain& chain() const { return chain_; }

 private:
  enum class Motion {
    resting, grab_leg, grab_settle, grab_lower, grab_lock, grab_raise, carry_wait, carry_leg, carry_settle, holding,
    load_lower, load_open, load_raise, home_plan, home_leg, home_settle, off
  };

  void pid_finished(const Task& task, Word result);
  void move_on(Desk& desk, const Berth& berth);
  void begin_leg(Word leg, Motion next, Desk& desk);
  void end_leg(Motion settle, Desk& desk);
  bool settled(const Desk& desk) const;
  /// Commands a hoist ramp; false while the servo's words cannot be changed.
  bool ramp(double delta, Desk& desk);
  bool ramp_done() const;
  /// Lowers until the load stands: true when it does and the ramp is over.
  bool lowered(Desk& desk);
  void raise(Motion next, Desk& desk);
  void start_process(unsigned number, Desk& desk);
  void end_process(unsigned number, Desk& desk);
  std::int64_t ticks(double seconds) const;
  Task task(Word kind, std::uint32_t x, std::uint32_t y, const Desk& desk) const;

  CraneJob job_;
  const Words& words_;
  Consents& consents_;
  PointChain chain_;
  PidStatus pid_;
  Motion motion_ = Motion::resting;
  std::optional<unsigned> agv_;         // being loaded
  std::optional<unsigned> loaded_agv_;
  std::int64_t consumed_ = 0;           // points, all of the run
  std::int64_t segment_start_ = 0;
  std::int64_t since_ = 0;              // refresh at which the present motion was entered
  double ramp_offset_ = 0;              // m added to l when the last ramp is over
  std::int64_t ramp_end_ = 0;
  int probes_ = 0;                      // how often lowering was prolonged
  bool ramp_pending_ = false;
  bool job_done_ = false;
  bool want_identify_ = false, want_plan_ = false, want_home_ = false;
};

}  // namespace cmrc
