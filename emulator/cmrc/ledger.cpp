#include "cmrc/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cmrc {
namespace {

const std::vector<std::string>& kind_names() {
  static const std::vector<std::string> names = {
      "pid", "torque_compensation", "trajectory_planning.crane", "trajectory_planning.agv", "inverse_kinematics.crane",
      "inverse_kinematics.agv", "obstacle_avoidance", "identify", "grab_path", "home.crane", "home.agv", "error", "recompute"};
  return names;
}

std::vector<std::string> with(const std::vector<std::string>& user_tasks) {
  std::vector<std::string> all = kind_names();
  for (const std::string& name : user_tasks) all.push_back("user." + name);
  return all;
}

std::vector<Time> periods(Time servo, std::size_t user_tasks) {
  std::vector<Time> all(kind_names().size() + user_tasks, Time::zero());
  all[static_cast<std::size_t>(JobKind::pid)] = all[static_cast<std::size_t>(JobKind::torque_compensation)] = servo;
  return all;
}

}  // namespace

std::vector<std::string> job_kinds() { return kind_names(); }

JobKind job_kind(Word kind, const Words& words) {
  if (kind == words.kind_pid) return JobKind::pid;
  if (kind == words.kind_torque) return JobKind::torque_compensation;
  if (kind == words.kind_trajectory_crane) return JobKind::trajectory_crane;
  if (kind == words.kind_trajectory_agv) return JobKind::trajectory_agv;
  if (kind == words.kind_inverse_crane) return JobKind::inverse_crane;
  if (kind == words.kind_inverse_agv) return JobKind::inverse_agv;
  if (kind == words.kind_avoidance) return JobKind::obstacle_avoidance;
  if (kind == words.kind_identify) return JobKind::identify;
  if (kind == words.kind_grab_path) return JobKind::grab_path;
  if (kind == words.kind_home_crane) return JobKind::home_crane;
  if (kind == words.kind_home_agv) return JobKind::home_agv;
  if (kind == words.kind_error) return JobKind::error;
  if (kind >= words.kind_user && kind < words.kind_count) {
    return static_cast<JobKind>(static_cast<Word>(JobKind::user) + kind - words.kind_user);
  }
  throw std::invalid_argument("a task block of a kind that has no account");
}

Ledger::Ledger(std::vector<std::string> cause_names, Time servo_period, std::vector<std::string> user_tasks)
    : names_(with(user_tasks)), account_(names_, std::move(cause_names), periods(servo_period, user_tasks.size())) {}

Ledger::Slot& Ledger::slot(unsigned number) {
  if (slots_.size() <= number) slots_.resize(number + 1);
  return slots_[number];
}

void Ledger::release(std::size_t block, JobKind kind, Time released, std::optional<Time> deadline,
                     std::optional<std::int64_t> tick) {
  audit_.loaded(block, released);
  Open open;
  open.kind = kind;
  open.released = released;
  open.deadline = deadline;
  open.tick = tick;
  open_[block] = std::move(open);
}

report::Outcome Ledger::book(const report::Job& job, Time now) {
  const report::Outcome outcome = account_.add(job, now);
  if (outcome != report::Outcome::on_time) ++misses_;
  return outcome;
}

void Ledger::skipped(JobKind kind, Time released, Time deadline, std::int64_t tick) {
  report::Job job;
  job.kind = static_cast<std::size_t>(kind);
  job.progress = report::Progress::dropped;
  job.released = released;
  job.deadline = deadline;
  job.tick = tick;
  book(job, deadline);
}

void Ledger::claimed(std::size_t block, unsigned number, Time at, const CauseTimes& causes) {
  audit_.claimed(block, number, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  ++slot(number).claims;
  found->second.slot = number;
  found->second.claimed = at;
  found->second.failed = false;
  found->second.cycles = causes;
  found->second.causes.clear();
}

void Ledger::leave(Open& open, Time at) {
  if (!open.slot) return;
  account_.occupied(*open.slot, static_cast<std::size_t>(open.kind), open.claimed, at);
  slot(*open.slot).occupied[static_cast<std::size_t>(open.kind)] += (at - open.claimed).count();
}

bool Ledger::finished(std::size_t block, unsigned number, Time at, const CauseTimes& causes) {
  audit_.finished(block, number, at);
  const auto found = open_.find(block);
  if (found == open_.end() || found->second.slot != number || found->second.finished) return false;
  Open& open = found->second;
  leave(open, at);
  open.finished = at;
  if (open.cycles.size() != causes.size()) {
    open.cycles.clear();
    return true;
  }
  std::int64_t total = 0;
  for (std::size_t i = 0; i < causes.size(); ++i) total += open.cycles[i] = causes[i] - open.cycles[i];
  // Cycles to picoseconds so that the parts sum to the whole exactly: each cumulative sum is rounded, not each part.
  const std::int64_t whole = (at - open.claimed).count();
  std::int64_t cycles = 0, before = 0;
  for (const std::int64_t part : open.cycles) {
    cycles += part;
    const std::int64_t until =
        total == 0 ? 0 : static_cast<std::int64_t>(std::llround(static_cast<double>(whole) * static_cast<double>(cycles) / static_cast<double>(total)));
    open.causes.push_back(until - before);
    before = until;
  }
  return true;
}

void Ledger::put_back(std::size_t block, Time at) {
  audit_.put_back(block, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  leave(found->second, at);
  found->second.slot.reset();
  found->second.failed = false;
  found->second.cycles.clear();
  found->second.causes.clear();
}

report::Job Ledger::job_of(const Open& open) const {
  report::Job job;
  job.kind = static_cast<std::size_t>(open.kind);
  job.released = open.released;
  job.deadline = open.deadline;
  job.claimed = open.claimed;
  job.tick = open.tick;
  if (open.finished) {
    job.progress = report::Progress::finished;
    job.finished = *open.finished;
    job.causes = open.causes;
    job.cycles = open.cycles;
  } else if (open.slot) {
    job.progress = open.failed ? report::Progress::lost : report::Progress::running;
  } else {
    job.progress = report::Progress::waiting;
  }
  return job;
}

void Ledger::dropped(std::size_t block, Time at) {
  audit_.dropped(block, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  leave(found->second, at);
  report::Job job = job_of(found->second);
  job.progress = report::Progress::dropped;
  job.causes.clear();
  book(job, at);
  open_.erase(found);
}

report::Outcome Ledger::removed(std::size_t block) {
  const auto found = open_.find(block);
  if (found == open_.end()) return report::Outcome::on_time;
  const report::Job job = job_of(found->second);
  audit_.removed(block, job.finished);
  const report::Outcome outcome = book(job, job.finished);
  open_.erase(found);
  return outcome;
}

void Ledger::slot_failed(unsigned number, Time) {
  for (auto& [block, open] : open_) {
    if (open.slot == number && !open.finished) open.failed = true;
  }
}

std::vector<report::TaskReport> Ledger::report(Time now, unsigned slots) const {
  report::TaskAccount account = account_;
  for (const auto& [block, open] : open_) {
    if (open.released <= now) account.add(job_of(open), now);
  }
  return account.report(slots);
}

std::uint64_t Ledger::claims(unsigned number) const { return number < slots_.size() ? slots_[number].claims : 0; }

std::vector<report::Share> Ledger::occupied(unsigned number, Time now) const {
  std::vector<report::Share> shares;
  std::vector<std::int64_t> sums = number < slots_.size() ? slots_[number].occupied : Slot{}.occupied;
  for (const auto& [block, open] : open_) {
    if (open.slot == number && !open.finished) sums[static_cast<std::size_t>(open.kind)] += (now - open.claimed).count();
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i] != 0) shares.push_back({names_.at(i), sums[i]});
  }
  return shares;
}

std::optional<JobKind> Ledger::kind_of(std::size_t block) const {
  const auto found = open_.find(block);
  return found == open_.end() ? std::nullopt : std::optional(found->second.kind);
}

}  // namespace cmrc
