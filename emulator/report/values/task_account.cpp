#include "report/values/task_account.hpp"

#include <algorithm>
#include <stdexcept>

#include "state/visitor.hpp"

namespace report {

std::string name(Outcome outcome) {
  switch (outcome) {
    case Outcome::on_time: return "on_time";
    case Outcome::late: return "late";
    case Outcome::unfinished: return "unfinished";
    case Outcome::never_started: return "never_started";
    case Outcome::lost: return "lost";
    case Outcome::dropped: return "dropped";
  }
  return "unknown";
}

TaskAccount::TaskAccount(std::vector<std::string> kinds, std::vector<std::string> causes,
                         const std::vector<Time>& periods, std::size_t samples_max)
    : causes_(std::move(causes)) {
  if (periods.size() != kinds.size()) throw std::invalid_argument("TaskAccount: one period per kind");
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const Distribution none(samples_max);
    const std::vector<std::int64_t> zero(causes_.size(), 0);
    TaskReport counts;
    counts.kind = std::move(kinds[i]);
    kinds_.push_back({std::move(counts), none, none, none, none, Starts(periods[i].count()), zero, zero});
  }
}

namespace {

Outcome classify(const Job& job) {
  switch (job.progress) {
    case Progress::finished: return !job.deadline || job.finished <= *job.deadline ? Outcome::on_time : Outcome::late;
    case Progress::running: return Outcome::unfinished;
    case Progress::waiting: return Outcome::never_started;
    case Progress::lost: return Outcome::lost;
    case Progress::dropped: return Outcome::dropped;
  }
  throw std::invalid_argument("TaskAccount: no such progress");
}

std::uint64_t& counter(TaskReport& report, Outcome outcome) {
  switch (outcome) {
    case Outcome::on_time: return report.on_time;
    case Outcome::late: return report.late;
    case Outcome::unfinished: return report.unfinished;
    case Outcome::never_started: return report.never_started;
    case Outcome::lost: return report.lost;
    case Outcome::dropped: return report.dropped;
  }
  throw std::invalid_argument("TaskAccount: no such outcome");
}

}  // namespace

bool missed(const Job& job, Outcome outcome, Time now) {
  switch (outcome) {
    case Outcome::on_time: return false;
    case Outcome::unfinished:
    case Outcome::never_started: return job.deadline && *job.deadline < now;
    default: return true;
  }
}

Outcome TaskAccount::add(const Job& job, Time now) {
  Kind& kind = kinds_.at(job.kind);
  const auto fits = [this](const std::vector<std::int64_t>& causes) {
    return causes.empty() || causes.size() == causes_.size();
  };
  if (!fits(job.causes) || !fits(job.cycles))
    throw std::invalid_argument("TaskAccount: a job's causes do not match the account's");
  const Outcome outcome = classify(job);
  ++kind.counts.released;
  ++counter(kind.counts, outcome);

  const bool claimed = job.progress != Progress::waiting && job.progress != Progress::dropped;
  if (claimed) {
    kind.waiting.add((job.claimed - job.released).count());
    if (job.tick) kind.starts.add(*job.tick, job.claimed.count());
  }
  if (job.progress == Progress::finished) {
    kind.response.add((job.finished - job.released).count());
    kind.execution.add((job.finished - job.claimed - job.between).count());
    for (std::size_t i = 0; i < job.causes.size(); ++i) kind.causes[i] += job.causes[i];
    for (std::size_t i = 0; i < job.cycles.size(); ++i) kind.cycles[i] += job.cycles[i];
    if (outcome == Outcome::late) kind.lateness.add((job.finished - *job.deadline).count());
  }

  if (!missed(job, outcome, now)) {
    kind.streak = 0;
    return outcome;
  }
  ++kind.counts.misses;
  kind.counts.longest_miss_streak = std::max(kind.counts.longest_miss_streak, ++kind.streak);
  return outcome;
}

std::vector<TaskReport> TaskAccount::report() const {
  std::vector<TaskReport> reports;
  for (const Kind& kind : kinds_) {
    TaskReport report = kind.counts;
    report.response = kind.response.summary();
    report.waiting = kind.waiting.summary();
    report.execution = kind.execution.summary();
    report.lateness = kind.lateness.summary();
    report.start_jitter = kind.starts.jitter();
    for (std::size_t cause = 0; cause < causes_.size(); ++cause) {
      report.execution_causes.push_back({causes_[cause], kind.causes[cause]});
      report.execution_cycles.push_back({causes_[cause], kind.cycles[cause]});
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

void TaskAccount::list_state(state::Visitor& list) { list("kinds", kinds_); }

}  // namespace report
