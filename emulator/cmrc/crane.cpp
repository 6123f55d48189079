#include "cmrc/crane.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cmrc/importance.hpp"
#include "cmrc/ti_float.hpp"

namespace cmrc {
namespace {

constexpr double probe = 0.1;        // m, by which lowering is prolonged when nothing was met
constexpr double probe_after = 1.0;  // s after a ramp's end
constexpr int most_probes = 5;

}  // namespace

CraneProcesses::CraneProcesses(const CraneJob& job, const Words& words, Consents& consents)
    : job_(job), words_(words), consents_(consents),
      chain_({.x = task::trajectory, .y = robot_class::crane, .kind = words.kind_trajectory_crane, .area = words.cr_base},
             {.x = task::inverse, .y = robot_class::crane, .kind = words.kind_inverse_crane, .area = words.cr_base},
             job.buffer_points) {}

std::int64_t CraneProcesses::ticks(double seconds) const {
  return static_cast<std::int64_t>(std::ceil(seconds * job_.refresh_frequency));
}

Task CraneProcesses::task(Word kind, std::uint32_t x, std::uint32_t y, const Desk& desk) const {
  return {.x = x, .y = y, .kind = kind, .robot = 0, .area = words_.cr_base, .tick = static_cast<std::uint32_t>(desk.tick())};
}

void CraneProcesses::start(Desk& desk) {
  consents_.give(4, 3);  // the crane is free
  consents_.give(4, 7);
  want_identify_ = true;
  start_process(1, desk);
}

void CraneProcesses::start_process(unsigned number, Desk& desk) { desk.process(number, true, number == 4 ? *agv_ + 1 : 0); }
void CraneProcesses::end_process(unsigned number, Desk& desk) { desk.process(number, false, number == 4 ? *agv_ + 1 : 0); }

void CraneProcesses::finished(const Task& done, Word result, Word notify, Desk& desk) {
  const auto must = [&](unsigned n) { return (notify & words_.must_process << n) != 0; };
  const auto may = [&](unsigned n) { return (notify & words_.may_process << n) != 0; };
  if (done.kind == words_.kind_pid) {
    pid_finished(done, result);
  } else if (done.kind == words_.kind_trajectory_crane) {
    chain_.trajectory_done((result & words_.end_of_leg) != 0, (notify & words_.must_inverse) != 0);
  } else if (done.kind == words_.kind_inverse_crane) {
    chain_.inverse_done();
  } else if (done.kind == words_.kind_identify) {
    end_process(1, desk);
    if (must(2)) {
      want_plan_ = true;
      start_process(2, desk);
    }
    if (may(7)) consents_.give(1, 7);
    if (may(8)) consents_.give(1, 8);
    job_done_ = may(7) && !must(2);
  } else if (done.kind == words_.kind_grab_path) {
    end_process(2, desk);
    if (may(3)) consents_.give(2, 3);
  } else if (done.kind == words_.kind_home_crane) {
    begin_leg(3, Motion::home_leg, desk);
  }
}

void CraneProcesses::dropped(const Task& lost) {
  if (lost.kind == words_.kind_trajectory_crane) chain_.lost_trajectory();
  else if (lost.kind == words_.kind_inverse_crane) chain_.lost_inverse();
  else if (lost.kind == words_.kind_identify) want_identify_ = true;
  else if (lost.kind == words_.kind_grab_path) want_plan_ = true;
  else if (lost.kind == words_.kind_home_crane) want_home_ = true;
}

void CraneProcesses::pid_finished(const Task& done, Word result) {
  pid_.tick = done.tick;
  pid_.landed = (result & words_.pid_landed) != 0;
  pid_.locked = (result & words_.pid_locked) != 0;
  pid_.open = (result & words_.pid_open) != 0;
  pid_.starved = (result & words_.pid_starved) != 0;
  pid_.settled = (result & words_.pid_settled) != 0;
  pid_.ramp_done = (result & words_.pid_ramp_done) != 0;
  // The count is 16 bits wide; the host keeps the rest.
  const std::int64_t step = static_cast<std::int64_t>((result - static_cast<Word>(consumed_)) & 0xFFFF);
  if (step == 0 || step > 0x8000) return;
  consumed_ += step;
  const std::int64_t due = segment_start_ + job_.point_interval * step;
  segment_start_ = pid_.tick - due < job_.servo_interval && pid_.tick >= due ? due : pid_.tick;
  chain_.consumed(consumed_, segment_start_);
}

void CraneProcesses::begin_leg(Word leg, Motion next, Desk& desk) {
  desk.write(words_.cr_base + words_.cr_leg, leg);
  chain_.begin(chain_.next_point(), job_.point_interval, desk.tick());
  motion_ = next;
}

void CraneProcesses::end_leg(Motion settle, Desk& desk) {
  if (!chain_.through(desk.tick())) return;
  motion_ = settle;
  since_ = desk.tick() + job_.point_interval;  // the last segment is still being followed
}

bool CraneProcesses::settled(const Desk& desk) const {
  if (pid_.tick <= since_) return false;
  return pid_.settled || desk.tick() - since_ > ticks(job_.settle_limit);
}

bool CraneProcesses::ramp(double delta, Desk& desk) {
  if (!desk.servo_resting()) return false;
  // Quintic blend: peak speed 1.875 delta / T.
  const std::int64_t duration = ticks(1.875 * std::abs(delta) / job_.ramp_speed) + 1;
  const std::int64_t begin = desk.tick() + 2 * job_.servo_interval;
  const std::array<Word, 4> words = {static_cast<Word>(begin), static_cast<Word>(duration), ti_float(ramp_offset_),
                                     ti_float(delta)};
  desk.write(words_.cr_base + words_.cr_ramp_start, words);
  ramp_offset_ += delta;
  ramp_end_ = begin + duration;
  return true;
}

bool CraneProcesses::ramp_done() const { return !ramp_pending_ && pid_.tick >= ramp_end_ && pid_.ramp_done; }

bool CraneProcesses::lowered(Desk& desk) {
  if (ramp_pending_) {
    ramp_pending_ = !ramp(probes_ == 0 ? job_.clearance + job_.slack : probe, desk);
    return false;
  }
  if (!ramp_done()) return false;
  if (pid_.landed) return true;
  if (pid_.tick > ramp_end_ + ticks(probe_after) && probes_ < most_probes) {
    ++probes_;
    ramp_pending_ = true;
  }
  return false;
}

void CraneProcesses::raise(Motion next, Desk& desk) {
  if (!ramp(-ramp_offset_, desk)) return;
  probes_ = 0;
  motion_ = next;
}

void CraneProcesses::refresh(Desk& desk, const Berth& berth) {
  if (want_identify_) desk.load(task(words_.kind_identify, task::identify, robot_class::none, desk), std::nullopt);
  if (want_plan_) desk.load(task(words_.kind_grab_path, task::grab_path, robot_class::none, desk), std::nullopt);
  if (want_home_) desk.load(task(words_.kind_home_crane, task::home_crane, robot_class::crane, desk), std::nullopt);
  want_identify_ = want_plan_ = want_home_ = false;
  move_on(desk, berth);
  chain_.refresh(desk);
}

void CraneProcesses::move_on(Desk& desk, const Berth& berth) {
  const auto set_payload = [&](double mass) { desk.write(words_.cr_base + words_.cr_payload, ti_float(mass)); };
  const auto set_spreader = [&](Word lock) { desk.write(words_.cr_base + words_.cr_spreader, lock); };
  switch (motion_) {
    case Motion::resting:
      if (consents_.all(3)) {
        consents_.consume(3);
        consents_.clear(4, 7);  // item 14: the target's cycle restarts
        start_process(3, desk);
        begin_leg(1, Motion::grab_leg, desk);
      } else if (consents_.all(7)) {
        consents_.consume(7);
        start_process(7, desk);
        want_home_ = true;
        motion_ = Motion::home_plan;
      }
      break;
    case Motion::grab_leg: end_leg(Motion::grab_settle, desk); break;
    case Motion::grab_settle:
      if (settled(desk)) motion_ = Motion::grab_lower, ramp_pending_ = true;
      break;
    case Motion::grab_lower:
      if (!lowered(desk)) break;
      set_spreader(1);
      motion_ = Motion::grab_lock;
      break;
    case Motion::grab_lock:
      if (!pid_.locked || !desk.servo_resting()) break;
      set_payload(job_.full_mass);
      raise(Motion::grab_raise, desk);
      break;
    case Motion::grab_raise:
      if (!ramp_done()) break;
      motion_ = Motion::carry_wait;
      desk.crane_waits(true);
      break;
    case Motion::carry_wait:
      // Leg 2 aims at the AGV's measured pose, so it cannot begin before one stands there.
      if (const auto agv = berth.agv_in_spot()) {
        desk.crane_waits(false);
        desk.write(words_.cr_base + words_.cr_agv, words_.agv_unit + *agv * words_.agv_unit_words);
        begin_leg(2, Motion::carry_leg, desk);
      }
      break;
    case Motion::carry_leg: end_leg(Motion::carry_settle, desk); break;
    case Motion::carry_settle:
      if (!settled(desk)) break;
      end_process(3, desk);
      consents_.give(3, 4);
      want_identify_ = true;
      start_process(1, desk);
      motion_ = Motion::holding;
      break;
    case Motion::holding: {
      const auto agv = berth.agv_in_spot();
      if (!agv || !consents_.all(4, *agv)) break;
      consents_.consume(4, *agv);
      consents_.clear(5, 8, *agv);  // item 14
      agv_ = agv;
      start_process(4, desk);
      motion_ = Motion::load_lower;
      ramp_pending_ = true;
      break;
    }
    case Motion::load_lower:
      if (!lowered(desk)) break;
      set_spreader(0);
      motion_ = Motion::load_open;
      break;
    case Motion::load_open:
      if (!pid_.open || !desk.servo_resting()) break;
      set_payload(job_.empty_mass);
      raise(Motion::load_raise, desk);
      break;
    case Motion::load_raise:
      if (!ramp_done()) break;
      end_process(4, desk);
      consents_.give(4, 3);
      consents_.give(4, 7);
      loaded_agv_ = agv_;
      agv_.reset();
      motion_ = Motion::resting;
      break;
    case Motion::home_plan: break;  // until the block that plans leg 3 is done
    case Motion::home_leg: end_leg(Motion::home_settle, desk); break;
    case Motion::home_settle:
      if (!settled(desk)) break;
      end_process(7, desk);
      motion_ = Motion::off;
      break;
    case Motion::off: break;
  }
}

std::optional<unsigned> CraneProcesses::take_loaded_agv() { return std::exchange(loaded_agv_, std::nullopt); }

std::optional<unsigned> CraneProcesses::loading() const { return agv_; }

bool CraneProcesses::grabbing() const {
  return motion_ >= Motion::grab_leg && motion_ <= Motion::holding;
}

}  // namespace cmrc
