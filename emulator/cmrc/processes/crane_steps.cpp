#include "cmrc/processes/crane_steps.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "state/visitor.hpp"

namespace cmrc {
namespace {

constexpr double probe = 0.1;        // m, by which lowering is prolonged if the load touched nothing
constexpr double probe_after = 1.0;  // s after a ramp's end
constexpr int most_probes = 5;
// If the load has touched something but closed no corner switch, it is jammed between guides or cones, held by
// friction. Its weight is then taken off in small steps, so that guides and cones can push it, and put on again.
constexpr double ease = 0.05;        // m
constexpr double ease_slower = 0.5;  // so that the load does not bounce on the rope; its period there is some 0.6 s
constexpr double ease_after = 0.15;  // s after a ramp's end: by then the load cell shows the load
constexpr double most_eased = 0.3;   // m
constexpr double hangs = 0.9;        // share of the rope's earlier load
// In wind the load is lowered in two ramps. In between it hangs at a height at which the guides (0.3 m high) already
// catch it, until it is above its place.
constexpr double hover = 0.2;            // m above the surface
constexpr double steady_for = 0.25;      // s
constexpr double touching_slower = 0.8;  // the second ramp reaches the surface at its greatest speed

}  // namespace

CraneSteps::CraneSteps(const CraneJob& job, const Words& words)
    : job_(job),
      words_(words),
      chain_(task_of(JobKind::trajectory_crane, words), task_of(JobKind::inverse_crane, words), job.buffer_points),
      interval_(job.point_interval),
      next_interval_(job.slowed_interval),
      speeds_(job.speeds),
      next_speeds_(job.speeds),
      too_windy_(job.too_windy) {}

// Rounded up: a ramp is not faster, and a wait not shorter, than what is asked for.
std::int64_t CraneSteps::ticks(double seconds) const {
  return static_cast<std::int64_t>(std::ceil(seconds * job_.refresh_frequency));
}

// ---- steps ----

void CraneSteps::enter(const Step& step, std::optional<unsigned> agv, HostServices& services) {
  retrying_ = false;
  switch (step.kind) {
    case Step::Kind::leg: begin_leg(step.leg, services); break;
    case Step::Kind::align:
      services.write(words_.cr_base + words_.cr_agv, words_.agv_unit + agv.value() * words_.agv_unit_words);
      begin_leg(words_.leg_align, services);
      break;
    case Step::Kind::settle: since_ = services.tick() + interval_; break;  // the robot still follows the last segment
    case Step::Kind::lower:
      ramp_pending_ = true;
      phase_ = Phase::down;
      missed_ = probes_ = 0;
      eased_ = 0;
      hovering_ = low_ = false;
      break;
    case Step::Kind::lock: services.write(words_.cr_base + words_.cr_spreader, Word{1}); break;
    case Step::Kind::open: services.write(words_.cr_base + words_.cr_spreader, Word{0}); break;
    case Step::Kind::raise:
      low_ = false;
      ramp_pending_ = !ramp(-ramp_offset_, services);
      break;
    case Step::Kind::hold: since_ = services.tick() + ticks(step.seconds); break;
    default: throw std::logic_error("Crane: a step of another robot");
  }
}

bool CraneSteps::done(const Step& step, HostServices& services) {
  switch (step.kind) {
    case Step::Kind::leg:
    case Step::Kind::align: return chain_.ended(services);
    case Step::Kind::settle: return settled(services);
    case Step::Kind::lower: return lowered(services);
    case Step::Kind::lock:
      if (!pid_.locked) return false;
      services.milestone(0, Milestone::Kind::locked, 0, services.tick());
      return true;
    case Step::Kind::open:
      if (!pid_.open) return false;
      services.milestone(0, Milestone::Kind::opened, 0, services.tick());
      return true;
    case Step::Kind::raise: return raised(services);
    case Step::Kind::hold: return services.tick() >= since_;
    default: throw std::logic_error("Crane: a step of another robot");
  }
}

void CraneSteps::begin_leg(Word leg, HostServices& services) {
  if (next_interval_ != interval_) {
    interval_ = next_interval_;
    const auto n = static_cast<double>(interval_);
    services.write(words_.cr_base + words_.cr_point_period, ti_float(n / job_.refresh_frequency));
    services.write(words_.cr_base + words_.cr_point_ticks, static_cast<Word>(interval_));
    services.write(words_.cr_base + words_.cr_stretch, ti_float(n / static_cast<double>(job_.point_interval)));
  }
  if (next_speeds_ != speeds_) {
    speeds_ = next_speeds_;
    services.write(words_.cr_base + words_.cr_speed, speeds_);
  }
  leg_ = leg;
  services.write(words_.cr_base + words_.cr_leg, leg);
  chain_.begin(chain_.next_point(), interval_, services.tick());
}

bool CraneSteps::settled(const HostServices& services) const {
  if (pid_.tick <= since_) return false;
  return pid_.settled || services.tick() - since_ > ticks(job_.settle_limit);
}

bool CraneSteps::ramp(double delta, HostServices& services) {
  if (!services.servo_resting()) return false;
  // Quintic blend: peak speed 1.875 delta / T.
  const double peak = job_.ramp_speed * (eased_ > 0 ? ease_slower : low_ ? touching_slower : 1.0);
  const std::int64_t duration = ticks(1.875 * std::abs(delta) / peak) + 1;
  const std::int64_t begin = services.path(services.tick()) + 2 * job_.servo_interval;
  const std::array<Word, 4> words = {static_cast<Word>(begin), static_cast<Word>(duration), ti_float(ramp_offset_),
                                     ti_float(delta)};
  services.write(words_.cr_base + words_.cr_ramp_start, words);
  ramp_offset_ += delta;
  ramp_end_ = begin + duration;
  // For comparisons of runs a ramp in two parts is one ramp.
  ramp_reported_ = hovering_;
  if (!low_) services.milestone(0, Milestone::Kind::ramp_begun, 0, services.tick() + 2 * job_.servo_interval);
  return true;
}

bool CraneSteps::ramp_done(const HostServices& services) const {
  return !ramp_pending_ && services.path(pid_.tick) >= ramp_end_ && pid_.ramp_done;
}

bool CraneSteps::lowered(HostServices& services) {
  switch (phase_) {
    case Phase::down: return down(services);
    case Phase::up:
      if (raised(services) && again_) aim_again(services);
      break;
    case Phase::identify: load(JobKind::identify, services); break;
    case Phase::plan: load(JobKind::grab_path, services); break;
    case Phase::align:
      if (!chain_.through(services.tick())) break;
      since_ = services.tick() + interval_;
      phase_ = Phase::rest;
      break;
    case Phase::rest:
      if (!settled(services)) break;
      ramp_pending_ = true;
      hovering_ = low_ = false;
      phase_ = Phase::down;
      break;
    case Phase::given_up: break;
  }
  return false;
}

bool CraneSteps::down(HostServices& services) {
  if (ramp_pending_) {
    if (held() && !setting_down_) return false;
    if (probes_ > 0) retrying_ = true;
    if (probes_ == 0 && !low_) hung_ = load_;
    hovering_ = probes_ == 0 && !low_ && pid_.windy && job_.clearance > hover && !setting_down_;
    const double low = low_ ? hover : job_.clearance;
    ramp_pending_ = !ramp(probes_ > 0 ? probe : hovering_ ? job_.clearance - hover : low + job_.slack, services);
    return false;
  }
  if (pid_.landed || load_ >= hangs * hung_) freed_ = true;
  if (!ramp_done(services)) return false;
  if (hovering_) {
    if (!hovered(services)) return false;
    hovering_ = false;
    low_ = ramp_pending_ = true;
    return false;
  }
  if (eased_ > 0) {
    ease_or_lower(services);
    return false;
  }
  if (pid_.landed) return true;
  if (services.path(pid_.tick) <= ramp_end_ + ticks(probe_after)) return false;
  if (++probes_ > most_probes) {
    ramp_pending_ = true;
    landing_missed(services);
  } else if (load_ < hangs * hung_) {
    retrying_ = true;
    freed_ = false;
    eased_ = ease;
    if (!ramp(-ease, services)) eased_ = 0, --probes_;
  } else {
    ramp_pending_ = true;
  }
  return false;
}

// Upwards in small steps until the switches have closed or the rope carries the load; then downwards by the same
// distance.
void CraneSteps::ease_or_lower(HostServices& services) {
  if (services.path(pid_.tick) <= ramp_end_ + ticks(ease_after)) return;
  if (freed_ || eased_ >= most_eased) {
    if (ramp(eased_, services)) eased_ = 0;
  } else if (ramp(-ease, services)) {
    eased_ += ease;
  }
}

// The rest of the way takes a second and a half: a load that is above its place and hardly moves stays there for this
// time.
bool CraneSteps::hovered(const HostServices& services) {
  const std::int64_t reached = services.path(pid_.tick) - ramp_end_;
  if (!pid_.steady || reached < ticks(steady_for)) unsteady_ = services.path(pid_.tick);
  return setting_down_ || services.path(pid_.tick) - unsteady_ >= ticks(steady_for) ||
         reached > ticks(job_.settle_limit);
}

void CraneSteps::landing_missed(HostServices& services) {
  probes_ = 0;
  eased_ = 0;
  low_ = false;
  phase_ = setting_down_ ? Phase::given_up : Phase::up;
  if (setting_down_) return;
  again_.reset();
  retrying_ = true;
  services.landing_missed(++missed_ > job_.landing_retries);
}

// Above the ship the container is looked for again and the way to it is planned; above an AGV its pose is measured
// again. In other places of the table the load only comes to rest.
void CraneSteps::aim_again(HostServices& services) {
  asked_ = false;
  since_ = services.tick() + interval_;
  if (!*again_) {
    phase_ = Phase::given_up;
  } else if (leg_ == 1 && !pid_.locked) {
    phase_ = Phase::identify;
  } else if (leg_ == words_.leg_align && pid_.locked) {
    begin_leg(words_.leg_align, services);
    phase_ = Phase::align;
  } else {
    phase_ = Phase::rest;
  }
}

void CraneSteps::landing_again() {
  missed_ = 0;
  again_ = true;
  ramp_pending_ = true;
  phase_ = Phase::up;
}

void CraneSteps::load(JobKind kind, HostServices& services) {
  if (asked_) return;
  asked_ = true;
  Task task = task_of(kind, words_);
  task.tick = static_cast<std::uint32_t>(services.tick());
  services.load(task, std::nullopt);
}

bool CraneSteps::raised(HostServices& services) {
  if (!ramp_pending_) return ramp_done(services);
  ramp_pending_ = !ramp(-ramp_offset_, services);
  return false;
}

// ---- finished blocks ----

void CraneSteps::finished(const Task& done, Word result, Word notify, HostServices& services) {
  if (done.kind == words_.program(JobKind::pid))
    pid_finished(done, result, services);
  else if (done.kind == words_.program(JobKind::torque_compensation))
    torque_finished(done, result);
  else if (done.kind == words_.program(JobKind::trajectory_crane))
    chain_.trajectory_done((result & words_.end_of_leg) != 0, (notify & words_.must_inverse) != 0,
                           (notify & words_.must_trajectory) != 0);
  else if (done.kind == words_.program(JobKind::inverse_crane))
    chain_.inverse_done();
  else if (done.kind == words_.program(JobKind::identify) && phase_ == Phase::identify)
    asked_ = false, phase_ = (notify & words_.must_process << 2) != 0 ? Phase::plan : Phase::rest;
  else if (done.kind == words_.program(JobKind::grab_path) && phase_ == Phase::plan)
    begin_leg(1, services), phase_ = Phase::align;
}

// Torque compensation reads the anemometer only after PID has taken the pose at the start.
void CraneSteps::torque_finished(const Task& done, Word result) {
  if (servo_began_ && done.tick > *servo_began_) too_windy_ = (result & words_.torque_wind) != 0;
  load_ = static_cast<double>(static_cast<std::int32_t>(result) >> words_.torque_load);
}

void CraneSteps::dropped(const Task& lost) {
  if (lost.kind == words_.program(JobKind::trajectory_crane))
    chain_.lost_trajectory();
  else if (lost.kind == words_.program(JobKind::inverse_crane))
    chain_.lost_inverse();
  else
    asked_ = false;
}

void CraneSteps::pid_finished(const Task& done, Word result, HostServices& services) {
  if (!servo_began_) servo_began_ = services.tick();
  pid_.tick = done.tick;
  pid_.landed = (result & words_.pid_landed) != 0;
  pid_.locked = (result & words_.pid_locked) != 0;
  pid_.open = (result & words_.pid_open) != 0;
  pid_.starved = (result & words_.pid_starved) != 0;
  pid_.settled = (result & words_.pid_settled) != 0;
  pid_.ramp_done = (result & words_.pid_ramp_done) != 0;
  pid_.windy = (result & words_.pid_windy) != 0;
  pid_.steady = (result & words_.pid_steady) != 0;
  if (!ramp_reported_ && ramp_done(services)) {
    ramp_reported_ = true;
    services.milestone(0, Milestone::Kind::ramp_ended, 0, pid_.tick);
  }
  // The count is 16 bits wide; the host has the upper bits.
  const std::int64_t step = static_cast<std::int64_t>((result - static_cast<Word>(consumed_)) & 0xFFFF);
  if (step == 0 || step > 0x8000) return;
  consumed_ += step;
  // If the path has its own clock (path_clock.hpp), its segments are not N_t refreshes long.
  const bool now = (result & words_.pid_began) != 0 || services.path(pid_.tick) != pid_.tick;
  segment_start_ = now ? pid_.tick : segment_start_ + interval_ * step;
  chain_.consumed(consumed_, segment_start_);
}

void CraneSteps::list_state(state::Visitor& list) {
  list("chain", chain_);
  list("pid", pid_);
  list("interval", interval_);
  list("next_interval", next_interval_);
  list("speeds", speeds_);
  list("next_speeds", next_speeds_);
  list("consumed", consumed_);
  list("segment_start", segment_start_);
  list("since", since_);
  list("ramp_offset", ramp_offset_);
  list("ramp_end", ramp_end_);
  list("probes", probes_);
  list("hovering", hovering_);
  list("low", low_);
  list("unsteady", unsteady_);
  list("load", load_);
  list("hung", hung_);
  list("eased", eased_);
  list("freed", freed_);
  list("too_windy", too_windy_);
  list("servo_began", servo_began_);
  list("ramp_pending", ramp_pending_);
  list("ramp_reported", ramp_reported_);
  list("retrying", retrying_);
  list("phase", phase_);
  list("missed", missed_);
  list("again", again_);
  list("setting_down", setting_down_);
  list("leg", leg_);
  list("asked", asked_);
}

}  // namespace cmrc
