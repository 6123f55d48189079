#pragma once
// The crane's steps of processes: legs, ramps of the hoist, twist locks; and the crane's sub-processes 1 and 2.
//
// Lowering and raising are hoist ramps that PID adds to its set-point (plant-and-bus.md 4.4 item 17).
#include <array>
#include <cstdint>
#include <optional>

#include "cmrc/configuration/rows/process_table.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/point_chain.hpp"

namespace cmrc {

/// What the host knows about the crane's surroundings, SI units.
struct CraneJob {
  double clearance = 0.6;    ///< m, between a route's end and its target surface
  double slack = 0.1;        ///< m, by which lowering goes beyond the surface
  double ramp_speed = 0.15;  ///< m/s, peak
  double settle_limit = 20;  ///< s, limit of waiting for the load to come to rest, or in wind to be above its place
  double refresh_frequency = 8000;
  std::int64_t servo_interval = 8;
  std::int64_t point_interval = 64;   ///< N_t
  std::int64_t slowed_interval = 64;  ///< N^_t at the start
  std::int64_t buffer_points = 2;
  std::array<std::uint32_t, 7> speeds{};  ///< the words of CR_SPEED (servo_law.hpp)
  bool too_windy = false;                 ///< at power-on
  std::int64_t landing_retries = 3;       ///< how often a load that has not landed is lifted, aligned and lowered again
};

/// The last report of PID.
struct PidStatus {
  std::int64_t tick = 0;
  bool landed = false, locked = false, open = false, starved = false, settled = false, ramp_done = false;
  bool windy = false, steady = false;  ///< wind displaces the load; nevertheless it is above its place
};

class CraneSteps {
 public:
  CraneSteps(const CraneJob& job, const Words& words);

  /// Begins a step; all kinds except Step::Kind::task. \param agv the AGV that the process loads, for "align"
  void enter(const Step& step, std::optional<unsigned> agv, HostServices& services);
  /// Continues the step that was entered last: true when it is finished.
  bool done(const Step& step, HostServices& services);
  /// A block of PID or of sub-processes 1 and 2 has ended.
  void finished(const Task& task, Word result, Word notify, HostServices& services);
  /// A block was dropped after too many recomputations: its work is requested again.
  void dropped(const Task& task);
  /// A dropped block's work is not requested again.
  void abandon() { chain_.abandon(); }
  /// The work is requested again after abandon().
  void resume() { chain_.resume(); }
  /// The anemometer's mean is above its limit, by torque compensation's last report, before that by the host's reading
  /// at power-on. Then no lift begins.
  bool too_windy() const { return too_windy_; }
  /// The load would be lowered to a container, and waits for less wind.
  bool waits_for_wind() const { return phase_ == Phase::down && ramp_pending_ && held(); }
  /// In the step `lower`: the load is moving down, or stands.
  bool lowering() const { return phase_ == Phase::down && !ramp_pending_; }
  /// A load that has not landed is not lifted again: an error requested to set it down.
  void set_down(bool asked) { setting_down_ = asked; }
  /// The error block's decision about a missed landing.
  void landing_decided(bool again) { again_ = again; }
  /// Starts the landing again, after the operator has cleared the error.
  void landing_again();
  /// The load has not landed after all retries: it hangs above the place of the landing.
  bool gave_up() const { return phase_ == Phase::given_up; }
  void refresh(HostServices& services) { chain_.refresh(services); }

  /// A failed step is repeated: none of its progress is a milestone.
  bool retrying() const { return retrying_; }
  const PidStatus& pid() const { return pid_; }
  bool on_leg(std::int64_t tick) const { return chain_.under_way(tick); }
  /// N^_t: refreshes between points of the present leg.
  std::int64_t interval() const { return interval_; }
  void set_interval(std::int64_t refreshes) { next_interval_ = refreshes; }
  /// The words of CR_SPEED, valid from the next leg on.
  void set_speeds(const std::array<Word, 7>& words) { next_speeds_ = words; }
  void list_state(state::Visitor& list);

 private:
  void pid_finished(const Task& task, Word result, HostServices& services);
  void torque_finished(const Task& task, Word result);
  void begin_leg(Word leg, HostServices& services);
  bool settled(const HostServices& services) const;
  /// Commands a hoist ramp; false as long as the servo's words cannot be changed.
  bool ramp(double delta, HostServices& services);
  bool ramp_done(const HostServices& services) const;
  /// The phases of a landing. The ramp down, prolonged while the load touches nothing; then, if the corner switches
  /// have not closed, the ramp up, a new measurement of the place, the way to above it, rest, and down again
  /// (plant-and-bus.md 1.5).
  enum class Phase : std::uint8_t { down, up, identify, plan, align, rest, given_up };
  /// Continues a landing: true when the load stands and the ramp has ended.
  bool lowered(HostServices& services);
  bool down(HostServices& services);
  bool hovered(const HostServices& services);
  void ease_or_lower(HostServices& services);
  bool held() const { return too_windy_ && !pid_.locked && probes_ == 0 && !low_; }
  void landing_missed(HostServices& services);
  void aim_again(HostServices& services);
  void load(JobKind kind, HostServices& services);
  bool raised(HostServices& services);
  std::int64_t ticks(double seconds) const;

  CraneJob job_;
  const Words& words_;
  PointChain chain_;
  PidStatus pid_;
  std::int64_t interval_;
  std::int64_t next_interval_;  // from the next leg on
  std::array<Word, 7> speeds_, next_speeds_;
  std::int64_t consumed_ = 0;  // points used in the whole run
  std::int64_t segment_start_ = 0;
  std::int64_t since_ = 0;     // refresh from which the load may come to rest, or until which a step lasts
  double ramp_offset_ = 0;     // m added to l after the last ramp
  std::int64_t ramp_end_ = 0;  // in the path's clock
  int probes_ = 0;             // how often lowering was prolonged
  bool hovering_ = false,
       low_ = false;            // in wind: the load is lowered to between the guides, and waits there for a good moment
  std::int64_t unsteady_ = 0;   // refresh at which the load was last not above its place there
  double load_ = 0, hung_ = 0;  // kg on the rope, now and before lowering
  double eased_ = 0;            // m, by which a jammed load has been lifted
  bool freed_ = false;          // since lifting, the corner switches have closed, or the rope has carried the load
  bool too_windy_;
  std::optional<std::int64_t> servo_began_;  // the refresh at which PID was first found finished
  bool ramp_pending_ = false;
  bool ramp_reported_ = true;
  bool retrying_ = false;
  Phase phase_ = Phase::down;
  std::int64_t missed_ = 0;    // missed landings in a row
  std::optional<bool> again_;  // decision about the last missed landing
  bool setting_down_ = false;
  Word leg_ = 0;        // the last one
  bool asked_ = false;  // the block of this phase is in the list
};

}  // namespace cmrc
