// Carries out the orders of Errors, and reports missed landings and blocks that were given up.
#include <fmt/format.h>

#include "cmrc/host/host.hpp"

namespace cmrc {

using report::EventKind;

void Host::error(Word number, Word what, Robot robot, Word phase, Word response) {
  note(EventKind::error, {number, what, robot, phase, response});
}

// In its first runs PID reads the pose, waits for torque compensation and enables the drives. From its third run on the
// drives wait for its codes.
bool Host::drives_wait_too_long() const {
  const double limit = config_.dock.drive_timeout_ms;
  return limit > 0 && pid_runs_ >= 3 && servoing() && !stopped(pid_) &&
         static_cast<double>((now_ - pid_ended_).count()) * 1e-9 > limit;
}

void Host::landing_missed(bool last) {
  cycles_.landing_missed();
  errors_.landing_missed(!last, now_, *this);
}

void Host::landing_decided(bool again) {
  processes_.crane().landing_decided(again);
  listener_.failure(
      {now_, std::nullopt, again ? "landing" : "stopped",
       again ? std::string("the load has not landed on all four corners: it is lifted, aligned and lowered again")
             : fmt::format("the load has not landed on all four corners in {} tries; stopped: the crane, above where "
                           "it should land",
                           config_.dock.landing_retries_max + 1)});
}

void Host::ask_again(const Task& lost) {
  if (lost.kind == words_.program(JobKind::torque_compensation) || lost.kind == words_.program(JobKind::pid))
    (lost.kind == words_.program(JobKind::pid) ? pid_ : torque_).waits = false;
  else if (user_tasks_.owns(lost))
    user_tasks_.ended(lost);
  else
    processes_.dropped(lost);
}

void Host::stop_work(const Task& lost) {
  std::string what;
  if (lost.kind == words_.program(JobKind::torque_compensation) || lost.kind == words_.program(JobKind::pid)) {
    Servo& servo = lost.kind == words_.program(JobKind::pid) ? pid_ : torque_;
    servo.stopped = true, servo.waits = false;
    what = fmt::format("sub-process {} ({}); the drives brake", servo.subprocess,
                       config_.processes.find_subprocess(servo.subprocess)->name);
  } else if (user_tasks_.owns(lost)) {
    user_tasks_.stop(lost);
    what = "the task";
  } else {
    what = processes_.abandoned(lost);
  }
  listener_.failure({now_, std::nullopt, "stopped",
                     fmt::format("a block of kind {} was given up {} times in a row; stopped: {}",
                                 ledger_.name(job_kind(lost.kind, words_)), drops_[{lost.kind, lost.robot}], what)});
}

void Host::resume_work(const Task& lost) {
  drops_.erase({lost.kind, lost.robot});
  if (lost.kind == words_.program(JobKind::torque_compensation) || lost.kind == words_.program(JobKind::pid))
    stop_servo(false);
  else if (user_tasks_.owns(lost))
    user_tasks_.resume(lost);
  else
    processes_.resume(lost);
}

}  // namespace cmrc
