#pragma once
// The crane's steps with a servo that the test plays: it reports what PID and torque compensation would.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include "cmrc/processes/crane_steps.hpp"
#include "tests/unit/made_host.hpp"

namespace made {

using cmrc::JobKind;
using Kind = cmrc::Step::Kind;

struct Crane {
  explicit Crane(double clearance = 0.6, bool too_windy = false) : steps(job_with(clearance, too_windy), w) {}
  static cmrc::CraneJob job_with(double clearance, bool too_windy) {
    cmrc::CraneJob job;
    job.too_windy = too_windy;
    job.clearance = clearance;
    job.settle_limit = 2;
    job.refresh_frequency = 1000;
    job.landing_retries = 1;
    return job;
  }

  cmrc::Words w = words();
  Host host;
  cmrc::CraneSteps steps;

  void enter(Kind kind, unsigned leg = 0, double seconds = 0) {
    cmrc::Step step;
    step.kind = kind;
    step.leg = leg;
    step.seconds = seconds;
    steps.enter(step, 2, host);
  }
  bool done(Kind kind) {
    cmrc::Step step;
    step.kind = kind;
    return steps.done(step, host);
  }
  /// At this refresh PID reports: bits, points used so far.
  void pid(std::int64_t tick, Word bits, Word used = 0) {
    host.now = tick;
    cmrc::Task task;
    task.kind = w.program(JobKind::pid);
    task.tick = static_cast<std::uint32_t>(tick);
    steps.finished(task, bits | used, 0, host);
  }
  /// Torque compensation of the next refresh reports the mass on the rope, and whether there is too much wind.
  void torque(Word mass, bool wind = false) {
    cmrc::Task task;
    task.kind = w.program(JobKind::torque_compensation);
    task.tick = static_cast<std::uint32_t>(host.now + 1);
    steps.finished(task, mass << w.torque_load | (wind ? w.torque_wind : 0), 0, host);
  }
  void block(JobKind kind, Word result, Word notify) {
    cmrc::Task task;
    task.kind = w.program(kind);
    steps.finished(task, result, notify, host);
  }
  /// "begin+duration offset delta" of the ramp that was commanded since the last call; "-": none was.
  std::string ramp() {
    const Word begin = host.take(w.cr_base + w.cr_ramp_start);
    if (begin == 0xDEAD'DEAD) return "-";
    const Word duration = host.take(w.cr_base + w.cr_ramp_start + 1);
    return fmt::format("{}+{} {} {}", begin, duration, number(host.take(w.cr_base + w.cr_ramp_start + 2)),
                       number(host.take(w.cr_base + w.cr_ramp_start + 3)));
  }
  /// Continues the landing at this refresh; PID has reported these bits there. \returns the ramp, or "done"
  std::string land(std::int64_t tick, Word bits) {
    pid(tick, bits);
    return done(Kind::lower) ? "done" : ramp();
  }
  /// Leg `leg` is entered, and its only point is planned.
  void plan(Word leg) {
    enter(Kind::leg, leg);
    refresh();
    block(JobKind::trajectory_crane, w.end_of_leg, w.must_inverse);
    refresh();
    block(JobKind::inverse_crane, 0, 0);
  }
  /// Leg `leg` is entered and driven to its end.
  void drive(Word leg) {
    plan(leg);
    used_ += 1;
    pid(host.now, 0, used_);
    CHECK(done(Kind::leg));
    host.news();
  }
  std::string refresh() {
    steps.refresh(host);
    std::string all;
    for (const Word kind : host.kinds())
      all += kind == w.program(JobKind::trajectory_crane) ? "T"
             : kind == w.program(JobKind::inverse_crane)  ? "I"
             : kind == w.program(JobKind::identify)       ? "identify"
             : kind == w.program(JobKind::grab_path)      ? "plan"
                                                          : "?";
    return all;
  }

 private:
  Word used_ = 0;
};

}  // namespace made
