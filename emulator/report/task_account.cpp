#include "report/task_account.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

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

TaskAccount::TaskAccount(std::vector<std::string> kinds, std::vector<std::string> causes, std::vector<Time> periods)
    : names_(std::move(kinds)), causes_(std::move(causes)), periods_(std::move(periods)) {
  if (periods_.size() != names_.size()) throw std::invalid_argument("TaskAccount: one period per kind");
  kinds_.resize(names_.size());
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    kinds_[i].counts.kind = names_[i];
    kinds_[i].causes.assign(causes_.size(), 0);
    kinds_[i].cycles.assign(causes_.size(), 0);
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
  const auto fits = [this](const std::vector<std::int64_t>& causes) { return causes.empty() || causes.size() == causes_.size(); };
  if (!fits(job.causes) || !fits(job.cycles))
    throw std::invalid_argument("TaskAccount: a job's causes do not match the account's");
  const Outcome outcome = classify(job);
  ++kind.counts.released;
  ++counter(kind.counts, outcome);

  const bool claimed = job.progress != Progress::waiting && job.progress != Progress::dropped;
  if (claimed) {
    kind.waiting.add((job.claimed - job.released).count());
    if (job.tick) kind.starts.push_back({*job.tick, job.claimed});
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

Jitter TaskAccount::jitter(std::size_t index) const {
  Jitter result;
  const Time period = periods_[index];
  if (period == Time::zero()) return result;
  std::vector<Start> starts = kinds_[index].starts;
  std::ranges::sort(starts, {}, &Start::tick);
  std::int64_t smallest = std::numeric_limits<std::int64_t>::max();
  std::int64_t largest = std::numeric_limits<std::int64_t>::min();
  double squares = 0;
  for (std::size_t i = 1; i < starts.size(); ++i) {
    if (starts[i].tick != starts[i - 1].tick + 1) continue;
    const std::int64_t deviation = (starts[i].time - starts[i - 1].time - period).count();
    smallest = std::min(smallest, deviation);
    largest = std::max(largest, deviation);
    squares += static_cast<double>(deviation) * static_cast<double>(deviation);
    ++result.count;
  }
  if (result.count == 0) return result;
  result.peak_to_peak = largest - smallest;
  result.worst = std::max(std::abs(smallest), std::abs(largest));
  result.rms = std::sqrt(squares / static_cast<double>(result.count));
  return result;
}

std::vector<TaskReport> TaskAccount::report() const {
  std::vector<TaskReport> reports;
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    const Kind& kind = kinds_[i];
    TaskReport report = kind.counts;
    report.response = kind.response.summary();
    report.waiting = kind.waiting.summary();
    report.execution = kind.execution.summary();
    report.lateness = kind.lateness.summary();
    report.start_jitter = jitter(i);
    for (std::size_t cause = 0; cause < causes_.size(); ++cause) {
      report.execution_causes.push_back({causes_[cause], kind.causes[cause]});
      report.execution_cycles.push_back({causes_[cause], kind.cycles[cause]});
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace report
