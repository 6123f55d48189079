#include "cmrc/measures/why_late.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "state/visitor.hpp"

namespace cmrc {
namespace {

using report::Wait;

/// Divides time into intervals that follow one another, so that no picosecond is counted twice or left out.
class Cutter {
 public:
  Cutter(Time from, Time end, report::WaitTimes& times) : at_(from), end_(std::max(from, end)), times_(times) {}
  /// The time up to `to` was `wait`, as far as it is after the last call's time and before the end.
  void until(Time to, Wait wait) {
    const Time next = std::clamp(to, at_, end_);
    times_[static_cast<std::size_t>(wait)] += (next - at_).count();
    at_ = next;
  }
  Time at() const { return at_; }

 private:
  Time at_, end_;
  report::WaitTimes& times_;
};

void add(report::WaitTimes& to, const report::WaitTimes& times) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += times[i];
}

std::int64_t sum(const report::WaitTimes& times) {
  return std::accumulate(times.begin(), times.end(), std::int64_t{0});
}

std::int64_t sum(const std::vector<std::int64_t>& times) {
  return std::accumulate(times.begin(), times.end(), std::int64_t{0});
}

/// Whether the run counts: it ended well (the job's whole run or a part of it), or has not ended.
bool counts(const report::Run& run) {
  return run.end == report::Run::End::done || run.end == report::Run::End::part || run.end == report::Run::End::running;
}

/// The first instant at which now + the shortest remaining time is past the deadline (ruling 18). While the job waits,
/// or its run is lost, the shortest remaining time is the usual run; once it is claimed, the rest of the usual run.
/// Finished parts are subtracted.
std::optional<Time> unavoidable_from(const MissedJob& job, Time usual) {
  if (!job.deadline) return std::nullopt;
  const Time tick{1};
  Time last_start = *job.deadline - usual;
  std::optional<Time> found;
  const auto waiting = [&](Time from, Time to) {
    const Time first = std::max(from, last_start + tick);
    if (!found && first < to) found = first;
  };
  if (job.tries.empty()) waiting(job.released, Time::max());
  for (const Try& attempt : job.tries) {
    const bool ran = attempt.run.has_value();
    waiting(attempt.waits_from, ran ? attempt.run->claimed : Time::max());
    if (!ran) break;
    const bool comes_to_nothing = !counts(*attempt.run);
    const bool part = attempt.run->end == report::Run::End::part;
    const Time until = comes_to_nothing || part ? attempt.run->ended : Time::max();
    const Time first = attempt.run->claimed > last_start ? attempt.run->claimed : *job.deadline + tick;
    if (!found && first < until) found = first;
    if (part) last_start = std::min(last_start + (attempt.run->ended - attempt.run->claimed), *job.deadline);
    if (comes_to_nothing)
      waiting(attempt.run->ended, &attempt == &job.tries.back() ? Time::max() : (&attempt + 1)->waits_from);
  }
  if (job.given_up && (!found || *job.given_up < *found)) found = std::max(*job.given_up, job.released);
  return found;
}

}  // namespace

WhyLate::WhyLate(std::vector<std::string> kinds, std::vector<std::string> causes, std::size_t kept,
                 std::vector<std::optional<unsigned>> own_slots)
    : kinds_(std::move(kinds)),
      causes_(std::move(causes)),
      kept_(kept),
      own_slots_(std::move(own_slots)),
      usual_(kinds_.size()),
      sums_(kinds_.size()) {
  for (Sums& of : sums_) of.execution.assign(causes_.size(), 0), of.behind.assign(kinds_.size(), 0);
}

void WhyLate::ran(std::size_t kind, std::int64_t execution, const std::vector<std::int64_t>& causes) {
  auto& usual = usual_.at(kind);
  if (!usual || execution < usual->execution) usual = report::Usual{execution, causes};
}

void WhyLate::missed(const MissedJob& job, const Timeline& timeline, BlockAudit& audit, RunWatcher* watcher) {
  Sums& sums = sums_.at(job.name.kind);
  Chain chain{job, {}, {}};
  if (job.tries.empty()) {  // a dropped tick
    const auto wait = static_cast<std::size_t>(job.dropped_by);
    ++sums.summary.dropped[wait];
    chain.waits[wait] = (job.end - job.released).count();
  }
  for (std::size_t i = 0; i < job.tries.size(); ++i) {
    const Try& attempt = job.tries[i];
    const Time next = i + 1 < job.tries.size() ? job.tries[i + 1].waits_from : job.end;
    Cutter cutter(attempt.waits_from, attempt.run ? attempt.run->claimed : next, chain.waits);
    cutter.until(attempt.first_refresh.value_or(Time::max()), Wait::host_late);
    if (attempt.put_up) {
      cutter.until(attempt.put_up->began, Wait::not_due);
      cutter.until(attempt.put_up->wanted, Wait::host_refresh);
      cutter.until(attempt.put_up->held, Wait::host_lock);
      cutter.until(attempt.put_up->free, Wait::host_refresh);
      const Waiting waiting =
          timeline.explain(cutter.at(), attempt.run ? attempt.run->claimed : next,
                           attempt.run ? std::optional(attempt.run->slot) : std::nullopt, own_slots_.at(job.name.kind));
      add(chain.waits, waiting.times);
      chain.behind.insert(chain.behind.end(), waiting.behind.begin(), waiting.behind.end());
    } else {
      cutter.until(Time::max(), Wait::not_due);
    }
    if (!attempt.run || counts(*attempt.run)) continue;
    Cutter lost(attempt.run->claimed, next, chain.waits);
    lost.until(attempt.run->ended, Wait::lost_run);
    lost.until(Time::max(), Wait::watchdog);
  }
  audit.require(
      sum(chain.waits) + sum(job.execution) == (job.end - job.released).count() && std::ranges::min(chain.waits) >= 0,
      job.end, [&] {
        return fmt::format("the waits and the run of {} {} do not add up to its response", kinds_.at(job.name.kind),
                           job.name.number);
      });
  if (!job.tries.empty()) {
    ++sums.summary.chains;
    add(sums.waits, chain.waits);
    for (std::size_t i = 0; i < job.execution.size(); ++i) sums.execution[i] += job.execution[i];
    if (!job.execution.empty()) ++sums.ran;
    for (const report::BlockingJob& behind : chain.behind) sums.behind.at(behind.job.kind) += behind.share;
    if (job.deadline) {
      ++sums.summary.with_deadline;
      sums.allowed += (*job.deadline - job.released).count();
      sums.summary.lateness += (job.end - *job.deadline).count();
    } else {
      sums.summary.lateness += (job.end - job.released).count();
    }
  }
  if (watcher != nullptr) watcher->missed({job, chain.waits, chain.behind});
  if (chains_.size() < kept_)
    chains_.push_back(std::move(chain));
  else
    ++left_out_;
}

std::vector<report::Share> WhyLate::parts(const report::WaitTimes& waits, const std::vector<std::int64_t>& execution,
                                          std::int64_t ran, std::int64_t not_run,
                                          const std::optional<report::Usual>& usual,
                                          std::optional<std::int64_t> slack) const {
  std::vector<report::Share> all;
  const auto put = [&](std::string name, std::int64_t ps) {
    if (ps != 0) all.push_back({std::move(name), ps});
  };
  for (std::size_t i = 0; i < waits.size(); ++i) put(report::name(static_cast<Wait>(i)), waits[i]);
  for (std::size_t i = 0; i < causes_.size() && ran > 0; ++i) {
    put("execution." + causes_[i], execution[i] - (usual ? ran * usual->causes[i] : 0));
  }
  if (usual) put("not_run", -not_run * usual->execution);
  if (slack) put("slack", -*slack);
  return all;
}

report::MissReport WhyLate::close(const Chain& chain, BlockAudit& audit) const {
  const MissedJob& job = chain.job;
  const auto& usual = usual_.at(job.name.kind);
  const std::int64_t shortest = usual ? usual->execution : 0;
  report::MissReport out;
  out.job = job.name;
  out.kind = kinds_.at(job.name.kind);
  out.outcome = report::name(job.outcome);
  out.released = job.released;
  out.deadline = job.deadline;
  out.end = job.end;
  if (usual) out.usual = shortest;
  std::optional<std::int64_t> slack;
  if (job.deadline) {
    out.lateness = (job.end - *job.deadline).count();
    slack = (*job.deadline - job.released).count() - shortest;
  }
  out.unavoidable = unavoidable_from(job, Time{shortest});
  out.parts =
      parts(chain.waits, job.execution, job.execution.empty() ? 0 : 1, job.execution.empty() ? 1 : 0, usual, slack);
  out.behind = chain.behind;
  for (const Try& attempt : job.tries) {
    if (attempt.run) out.runs.push_back(*attempt.run);
  }
  out.previous = job.previous;
  std::int64_t total = 0;
  for (const auto& part : out.parts) total += part.amount;
  const std::int64_t expected = out.lateness ? *out.lateness : (job.end - job.released).count() - shortest;
  audit.require(total == expected, job.end, [&] {
    return fmt::format("the causes of {} {} add up to {} ps, not to its lateness of {} ps", out.kind, job.name.number,
                       total, expected);
  });
  return out;
}

std::vector<report::MissReport> WhyLate::misses(BlockAudit& audit) const {
  std::vector<report::MissReport> all;
  for (const Chain& chain : chains_) all.push_back(close(chain, audit));
  return all;
}

report::WhyLate WhyLate::summary(std::size_t kind, BlockAudit& audit) const {
  const Sums& sums = sums_.at(kind);
  const auto& usual = usual_.at(kind);
  const std::int64_t shortest = usual ? usual->execution : 0;
  report::WhyLate out = sums.summary;
  if (usual) out.usual = shortest;
  const auto chains = static_cast<std::int64_t>(out.chains);
  const auto with_deadline = static_cast<std::int64_t>(out.with_deadline);
  out.parts = parts(sums.waits, sums.execution, sums.ran, chains - sums.ran, usual,
                    with_deadline > 0 ? std::optional(sums.allowed - with_deadline * shortest) : std::nullopt);
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (sums.behind[i] != 0) out.behind.push_back({kinds_[i], sums.behind[i]});
  }
  out.lateness -=
      (chains - with_deadline) * shortest;  // jobs without a deadline count as late by what exceeds the usual run
  std::int64_t total = 0;
  for (const auto& part : out.parts) total += part.amount;
  audit.require(total == out.lateness, Time{}, [&] {
    return fmt::format("the summed causes of {} add up to {} ps, not to its lateness of {} ps", kinds_.at(kind), total,
                       out.lateness);
  });
  return out;
}

void WhyLate::list_state(state::Visitor& list) {
  list("usual", usual_);
  list("chains", chains_);
  list("sums", sums_);
  list("left_out", left_out_);
}

}  // namespace cmrc
