#include "cmrc/crane.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "cmrc/importance.hpp"
#include "cmrc/ti_float.hpp"

namespace cmrc {
namespace {

constexpr double probe = 0.1;        // m, by which lowering is prolonged when nothing was met
constexpr double probe_after = 1.0;  // s after a ramp's end
constexpr int most_probes = 5;
// What has met something and stands on no corner switch is jammed between guides or cones, held by friction: its weight
// is taken off by and by, so that they can push it, and put on again.
constexpr double ease = 0.05;        // m
constexpr double ease_slower = 0.5;  // so that the load does not bounce on the rope, which it does with some 0.6 s
constexpr double ease_after = 0.15;  // s after a ramp's end: by then the load cell tells
constexpr double most_eased = 0.3;   // m
constexpr double hangs = 0.9;        // of what the rope carried before
// In wind the load is let down in two ramps. Between them it hangs where the guides (0.3 m high) already catch it,
// until it is over its place.
constexpr double hover = 0.2;            // m above the surface
constexpr double steady_for = 0.25;      // s
constexpr double touching_slower = 0.8;  // the second one meets the surface where it is fastest

}  // namespace

Crane::Crane(const CraneJob& job, const Words& words)
    : job_(job),
      words_(words),
      chain_(
          {.x = task::trajectory, .y = robot_class::crane, .kind = words.kind_trajectory_crane, .area = words.cr_base},
          {.x = task::inverse, .y = robot_class::crane, .kind = words.kind_inverse_crane, .area = words.cr_base},
          job.buffer_points),
      interval_(job.point_interval),
      next_interval_(job.slowed_interval),
      speeds_(job.speeds),
      next_speeds_(job.speeds) {}

std::int64_t Crane::ticks(double seconds) const {
  return static_cast<std::int64_t>(std::ceil(seconds * job_.refresh_frequency));
}

// ---- steps
// -------------------------------------------------------------------------------------------------------------

void Crane::enter(const Step& step, std::optional<unsigned> agv, Desk& desk) {
  retrying_ = false;
  switch (step.kind) {
    case Step::Kind::leg: begin_leg(step.leg, desk); break;
    case Step::Kind::align:
      desk.write(words_.cr_base + words_.cr_agv, words_.agv_unit + agv.value() * words_.agv_unit_words);
      begin_leg(words_.leg_align, desk);
      break;
    case Step::Kind::settle: since_ = desk.tick() + interval_; break;  // the last segment is still being followed
    case Step::Kind::lower:
      ramp_pending_ = true;
      phase_ = Phase::down;
      missed_ = probes_ = 0;
      eased_ = 0;
      hovering_ = low_ = false;
      break;
    case Step::Kind::lock: desk.write(words_.cr_base + words_.cr_spreader, Word{1}); break;
    case Step::Kind::open: desk.write(words_.cr_base + words_.cr_spreader, Word{0}); break;
    case Step::Kind::raise:
      low_ = false;
      ramp_pending_ = !ramp(-ramp_offset_, desk);
      break;
    case Step::Kind::hold: since_ = desk.tick() + ticks(step.seconds); break;
    default: throw std::logic_error("Crane: a step of another robot");
  }
}

bool Crane::done(const Step& step, Desk& desk) {
  switch (step.kind) {
    case Step::Kind::leg:
    case Step::Kind::align: return chain_.ended(desk);
    case Step::Kind::settle: return settled(desk);
    case Step::Kind::lower: return lowered(desk);
    case Step::Kind::lock:
      if (!pid_.locked) return false;
      desk.milestone(0, Milestone::Kind::locked, 0, desk.tick());
      return true;
    case Step::Kind::open:
      if (!pid_.open) return false;
      desk.milestone(0, Milestone::Kind::opened, 0, desk.tick());
      return true;
    case Step::Kind::raise: return raised(desk);
    case Step::Kind::hold: return desk.tick() >= since_;
    default: throw std::logic_error("Crane: a step of another robot");
  }
}

void Crane::begin_leg(Word leg, Desk& desk) {
  if (next_interval_ != interval_) {
    interval_ = next_interval_;
    const auto n = static_cast<double>(interval_);
    desk.write(words_.cr_base + words_.cr_point_period, ti_float(n / job_.refresh_frequency));
    desk.write(words_.cr_base + words_.cr_point_ticks, static_cast<Word>(interval_));
    desk.write(words_.cr_base + words_.cr_stretch, ti_float(n / static_cast<double>(job_.point_interval)));
  }
  if (next_speeds_ != speeds_) {
    speeds_ = next_speeds_;
    desk.write(words_.cr_base + words_.cr_speed, speeds_);
  }
  leg_ = leg;
  desk.write(words_.cr_base + words_.cr_leg, leg);
  chain_.begin(chain_.next_point(), interval_, desk.tick());
}

bool Crane::settled(const Desk& desk) const {
  if (pid_.tick <= since_) return false;
  return pid_.settled || desk.tick() - since_ > ticks(job_.settle_limit);
}

bool Crane::ramp(double delta, Desk& desk) {
  if (!desk.servo_resting()) return false;
  // Quintic blend: peak speed 1.875 delta / T.
  const double peak = job_.ramp_speed * (eased_ > 0 ? ease_slower : low_ ? touching_slower : 1.0);
  const std::int64_t duration = ticks(1.875 * std::abs(delta) / peak) + 1;
  const std::int64_t begin = desk.path(desk.tick()) + 2 * job_.servo_interval;
  const std::array<Word, 4> words = {static_cast<Word>(begin), static_cast<Word>(duration), ti_float(ramp_offset_),
                                     ti_float(delta)};
  desk.write(words_.cr_base + words_.cr_ramp_start, words);
  ramp_offset_ += delta;
  ramp_end_ = begin + duration;
  // A ramp in two parts is one to whoever compares runs.
  ramp_told_ = hovering_;
  if (!low_) desk.milestone(0, Milestone::Kind::ramp_begun, 0, desk.tick() + 2 * job_.servo_interval);
  return true;
}

bool Crane::ramp_done(const Desk& desk) const {
  return !ramp_pending_ && desk.path(pid_.tick) >= ramp_end_ && pid_.ramp_done;
}

bool Crane::lowered(Desk& desk) {
  switch (phase_) {
    case Phase::down: return down(desk);
    case Phase::up:
      if (raised(desk) && again_) aim_again(desk);
      break;
    case Phase::identify: load(words_.kind_identify, task::identify, desk); break;
    case Phase::plan: load(words_.kind_grab_path, task::grab_path, desk); break;
    case Phase::align:
      if (!chain_.through(desk.tick())) break;
      since_ = desk.tick() + interval_;
      phase_ = Phase::rest;
      break;
    case Phase::rest:
      if (!settled(desk)) break;
      ramp_pending_ = true;
      hovering_ = low_ = false;
      phase_ = Phase::down;
      break;
    case Phase::given_up: break;
  }
  return false;
}

bool Crane::down(Desk& desk) {
  if (ramp_pending_) {
    if (held() && !setting_down_) return false;
    if (probes_ > 0) retrying_ = true;
    if (probes_ == 0 && !low_) hung_ = load_;
    hovering_ = probes_ == 0 && !low_ && pid_.windy && job_.clearance > hover && !setting_down_;
    const double low = low_ ? hover : job_.clearance;
    ramp_pending_ = !ramp(probes_ > 0 ? probe : hovering_ ? job_.clearance - hover : low + job_.slack, desk);
    return false;
  }
  if (pid_.landed || load_ >= hangs * hung_) freed_ = true;
  if (!ramp_done(desk)) return false;
  if (hovering_) {
    if (!hovered(desk)) return false;
    hovering_ = false;
    low_ = ramp_pending_ = true;
    return false;
  }
  if (eased_ > 0) {
    ease_or_lower(desk);
    return false;
  }
  if (pid_.landed) return true;
  if (desk.path(pid_.tick) <= ramp_end_ + ticks(probe_after)) return false;
  if (++probes_ > most_probes) {
    ramp_pending_ = true;
    landing_missed(desk);
  } else if (load_ < hangs * hung_) {
    retrying_ = true;
    freed_ = false;
    eased_ = ease;
    if (!ramp(-ease, desk)) eased_ = 0, --probes_;
  } else {
    ramp_pending_ = true;
  }
  return false;
}

// Up by and by until the switches have closed or the rope carries the load; then down again by as much.
void Crane::ease_or_lower(Desk& desk) {
  if (desk.path(pid_.tick) <= ramp_end_ + ticks(ease_after)) return;
  if (freed_ || eased_ >= most_eased) {
    if (ramp(eased_, desk)) eased_ = 0;
  } else if (ramp(-ease, desk)) {
    eased_ += ease;
  }
}

// The rest of the way takes a second and a half: so long a load that is over its place and hardly moves stays there.
bool Crane::hovered(const Desk& desk) {
  const std::int64_t reached = desk.path(pid_.tick) - ramp_end_;
  if (!pid_.steady || reached < ticks(steady_for)) unsteady_ = desk.path(pid_.tick);
  return setting_down_ || desk.path(pid_.tick) - unsteady_ >= ticks(steady_for) || reached > ticks(job_.settle_limit);
}

void Crane::landing_missed(Desk& desk) {
  probes_ = 0;
  eased_ = 0;
  low_ = false;
  phase_ = setting_down_ ? Phase::given_up : Phase::up;
  if (setting_down_) return;
  again_.reset();
  retrying_ = true;
  desk.landing_missed(++missed_ > job_.landing_retries);
}

// Over the ship the container is looked for again and the way to it planned; over an AGV its pose is measured again.
// Where the table has led elsewhere the load only comes to rest.
void Crane::aim_again(Desk& desk) {
  asked_ = false;
  since_ = desk.tick() + interval_;
  if (!*again_) {
    phase_ = Phase::given_up;
  } else if (leg_ == 1 && !pid_.locked) {
    phase_ = Phase::identify;
  } else if (leg_ == words_.leg_align && pid_.locked) {
    begin_leg(words_.leg_align, desk);
    phase_ = Phase::align;
  } else {
    phase_ = Phase::rest;
  }
}

void Crane::landing_again() {
  missed_ = 0;
  again_ = true;
  ramp_pending_ = true;
  phase_ = Phase::up;
}

void Crane::load(Word kind, Word x, Desk& desk) {
  if (asked_) return;
  asked_ = true;
  desk.load({.x = x, .kind = kind, .area = words_.cr_base, .tick = static_cast<std::uint32_t>(desk.tick())},
            std::nullopt);
}

bool Crane::raised(Desk& desk) {
  if (!ramp_pending_) return ramp_done(desk);
  ramp_pending_ = !ramp(-ramp_offset_, desk);
  return false;
}

// ---- blocks that have ended
// --------------------------------------------------------------------------------------------

void Crane::finished(const Task& done, Word result, Word notify, Desk& desk) {
  if (done.kind == words_.kind_pid)
    pid_finished(done, result, desk);
  else if (done.kind == words_.kind_torque)
    torque_finished(result);
  else if (done.kind == words_.kind_trajectory_crane)
    chain_.trajectory_done((result & words_.end_of_leg) != 0, (notify & words_.must_inverse) != 0,
                           (notify & words_.must_trajectory) != 0);
  else if (done.kind == words_.kind_inverse_crane)
    chain_.inverse_done();
  else if (done.kind == words_.kind_identify && phase_ == Phase::identify)
    asked_ = false, phase_ = (notify & words_.must_process << 2) != 0 ? Phase::plan : Phase::rest;
  else if (done.kind == words_.kind_grab_path && phase_ == Phase::plan)
    begin_leg(1, desk), phase_ = Phase::align;
}

void Crane::torque_finished(Word result) {
  too_windy_ = (result & words_.torque_wind) != 0;
  load_ = static_cast<double>(static_cast<std::int32_t>(result) >> words_.torque_load);
}

void Crane::dropped(const Task& lost) {
  if (lost.kind == words_.kind_trajectory_crane)
    chain_.lost_trajectory();
  else if (lost.kind == words_.kind_inverse_crane)
    chain_.lost_inverse();
  else
    asked_ = false;
}

void Crane::pid_finished(const Task& done, Word result, Desk& desk) {
  pid_.tick = done.tick;
  pid_.landed = (result & words_.pid_landed) != 0;
  pid_.locked = (result & words_.pid_locked) != 0;
  pid_.open = (result & words_.pid_open) != 0;
  pid_.starved = (result & words_.pid_starved) != 0;
  pid_.settled = (result & words_.pid_settled) != 0;
  pid_.ramp_done = (result & words_.pid_ramp_done) != 0;
  pid_.windy = (result & words_.pid_windy) != 0;
  pid_.steady = (result & words_.pid_steady) != 0;
  if (!ramp_told_ && ramp_done(desk)) {
    ramp_told_ = true;
    desk.milestone(0, Milestone::Kind::ramp_ended, 0, pid_.tick);
  }
  // The count is 16 bits wide; the host keeps the rest.
  const std::int64_t step = static_cast<std::int64_t>((result - static_cast<Word>(consumed_)) & 0xFFFF);
  if (step == 0 || step > 0x8000) return;
  consumed_ += step;
  // Where the path has a clock of its own (path_clock.hpp), its segments are not N_t refreshes long.
  const bool now = (result & words_.pid_began) != 0 || desk.path(pid_.tick) != pid_.tick;
  segment_start_ = now ? pid_.tick : segment_start_ + interval_ * step;
  chain_.consumed(consumed_, segment_start_);
}

}  // namespace cmrc
