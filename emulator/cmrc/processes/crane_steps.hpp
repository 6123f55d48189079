#pragma once
// The crane as the steps of its processes see it: legs, ramps of the hoist, twist locks; and its sub-processes 1 and 2.
//
// Lowering and raising are hoist ramps that PID adds to its set-point (plant-and-bus.md 4.4 item 17).
#include <array>
#include <cstdint>
#include <optional>

#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/point_chain.hpp"
#include "cmrc/processes/process_table.hpp"

namespace cmrc {

/// What the host knows of the crane's world, SI units.
struct CraneJob {
  double clearance = 0.6;    ///< m, between a route's end and the surface it aims at
  double slack = 0.1;        ///< m, by which lowering goes further
  double ramp_speed = 0.15;  ///< m/s, peak
  double settle_limit = 20;  ///< s, waiting for the load to come to rest, or over its place in wind
  double refresh_frequency = 8000;
  std::int64_t servo_interval = 8;
  std::int64_t point_interval = 64;   ///< N_t
  std::int64_t slowed_interval = 64;  ///< N^_t at the start
  std::int64_t buffer_points = 2;
  std::array<std::uint32_t, 7> speeds{};  ///< the words of CR_SPEED (servo_law.hpp)
  std::int64_t landing_retries =
      3;  ///< a load that has not landed is lifted, aligned and lowered again at most so many times
};

/// What PID told the host last.
struct PidStatus {
  std::int64_t tick = 0;
  bool landed = false, locked = false, open = false, starved = false, settled = false, ramp_done = false;
  bool windy = false, steady = false;  ///< wind displaces the load; it is over its place all the same
};

class CraneSteps {
 public:
  CraneSteps(const CraneJob& job, const Words& words);

  /// Begins a step; all kinds but Step::Kind::task. \param agv whom the process loads, for "align"
  void enter(const Step& step, std::optional<unsigned> agv, HostServices& services);
  /// Goes on with the step that was entered last: true when it is done.
  bool done(const Step& step, HostServices& services);
  /// A block of PID or of sub-processes 1 and 2 has ended.
  void finished(const Task& task, Word result, Word notify, HostServices& services);
  /// It was dropped after too many recomputations: what it was for is asked for again.
  void dropped(const Task& task);
  /// ... and will not be asked for any more.
  void abandon() { chain_.abandon(); }
  /// ... or again.
  void resume() { chain_.resume(); }
  /// Torque compensation has said so: the anemometer's mean is above its limit. No lift begins then.
  bool too_windy() const { return too_windy_; }
  /// It would go down for a container, and waits for less wind.
  bool waits_for_wind() const { return phase_ == Phase::down && ramp_pending_ && held(); }
  /// In the step `lower`: it is on its way down, or stands.
  bool lowering() const { return phase_ == Phase::down && !ramp_pending_; }
  /// It does not lift the load when that has not landed: an error has it set down.
  void set_down(bool asked) { setting_down_ = asked; }
  /// What the error block has decided on a landing that was missed.
  void landing_decided(bool again) { again_ = again; }
  /// From the beginning, after the operator has cleared the error.
  void landing_again();
  /// The load has not landed after all retries: it hangs where it was lowered from.
  bool gave_up() const { return phase_ == Phase::given_up; }
  void refresh(HostServices& services) { chain_.refresh(services); }

  /// It does again what has failed: nothing of it is a milestone.
  bool retrying() const { return retrying_; }
  const PidStatus& pid() const { return pid_; }
  bool on_leg(std::int64_t tick) const { return chain_.under_way(tick); }
  /// N^_t: refreshes between points of the present leg.
  std::int64_t interval() const { return interval_; }
  void set_interval(std::int64_t refreshes) { next_interval_ = refreshes; }
  /// The words of CR_SPEED from the next leg on.
  void set_speeds(const std::array<Word, 7>& words) { next_speeds_ = words; }
  void list_state(state::Visitor& list);

 private:
  void pid_finished(const Task& task, Word result, HostServices& services);
  void torque_finished(Word result);
  void begin_leg(Word leg, HostServices& services);
  bool settled(const HostServices& services) const;
  /// Commands a hoist ramp; false while the servo's words cannot be changed.
  bool ramp(double delta, HostServices& services);
  bool ramp_done(const HostServices& services) const;
  /// How far a landing is: the ramp down, prolonged while nothing is met; then, when the corner switches have not
  /// closed, the ramp up, a new look at what it is to land on, the way over it, rest, and down again
  /// (plant-and-bus.md 1.5).
  enum class Phase : std::uint8_t { down, up, identify, plan, align, rest, given_up };
  /// Goes on with a landing: true when the load stands and the ramp is over.
  bool lowered(HostServices& services);
  bool down(HostServices& services);
  bool hovered(const HostServices& services);
  void ease_or_lower(HostServices& services);
  bool held() const { return too_windy_ && !pid_.locked && probes_ == 0 && !low_; }
  void landing_missed(HostServices& services);
  void aim_again(HostServices& services);
  void load(Word kind, Word x, HostServices& services);
  bool raised(HostServices& services);
  std::int64_t ticks(double seconds) const;

  CraneJob job_;
  const Words& words_;
  PointChain chain_;
  PidStatus pid_;
  std::int64_t interval_;
  std::int64_t next_interval_;  // from the next leg on
  std::array<Word, 7> speeds_, next_speeds_;
  std::int64_t consumed_ = 0;  // points, all of the run
  std::int64_t segment_start_ = 0;
  std::int64_t since_ = 0;     // refresh from which the load may settle, or until which a step holds
  double ramp_offset_ = 0;     // m added to l when the last ramp is over
  std::int64_t ramp_end_ = 0;  // by the path's clock
  int probes_ = 0;             // how often lowering was prolonged
  bool hovering_ = false,
       low_ = false;            // in wind: it is let down between the guides, and waits there for a good moment; it has
  std::int64_t unsteady_ = 0;   // refresh at which it last was not over its place there
  double load_ = 0, hung_ = 0;  // kg on the rope, and when it was about to be let down
  double eased_ = 0;            // m, by which it has been lifted again where it stood jammed
  bool freed_ = false;          // since then the corner switches have closed, or the rope has carried the load
  bool too_windy_ = false;
  bool ramp_pending_ = false;
  bool ramp_told_ = true;
  bool retrying_ = false;
  Phase phase_ = Phase::down;
  std::int64_t missed_ = 0;    // landings in a row
  std::optional<bool> again_;  // decided on the last missed landing
  bool setting_down_ = false;
  Word leg_ = 0;        // the last one
  bool asked_ = false;  // the block of this phase is out
};

}  // namespace cmrc
