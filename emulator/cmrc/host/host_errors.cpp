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
  return limit > 0 && pid_runs_ >= 3 && servoing() && !servo_.pid_stopped() &&
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
  if (servo_.owns(lost))
    servo_.ask_again(lost);
  else if (user_tasks_.owns(lost))
    user_tasks_.ended(lost);
  else
    processes_.dropped(lost);
}

bool Host::stop_work(const Task& lost) {
  std::string what;
  const bool servo = servo_.owns(lost);
  const std::string& kind = ledger_.name(job_kind(lost.kind, words_));
  if (servo) {
    servo_.stop(lost);
    const Subprocess& row = config_.processes.subprocess_of(kind);
    what = fmt::format("sub-process {} ({}); the drives brake", row.number, row.name);
  } else if (user_tasks_.owns(lost)) {
    user_tasks_.stop(lost);
    what = "the task";
  } else {
    what = processes_.abandoned(lost);
  }
  listener_.failure({now_, std::nullopt, "stopped",
                     fmt::format("a block of kind {} was given up {} times in a row; stopped: {}", kind,
                                 drops_[{lost.kind, lost.robot}], what)});
  return servo;
}

void Host::resume_work(const Task& lost) {
  drops_.erase({lost.kind, lost.robot});
  if (servo_.owns(lost))
    stop_servo(false);
  else if (user_tasks_.owns(lost))
    user_tasks_.resume(lost);
  else
    processes_.resume(lost);
}

}  // namespace cmrc
