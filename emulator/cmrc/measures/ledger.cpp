#include "cmrc/measures/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "state/visitor.hpp"

namespace cmrc {
namespace {

std::vector<std::string> with(const std::vector<std::string>& user_tasks) {
  std::vector<std::string> all = job_kinds();
  for (const std::string& name : user_tasks) all.push_back("user." + name);
  return all;
}

std::vector<std::optional<unsigned>> by_kind(const std::vector<std::optional<unsigned>>& user_slots,
                                             std::size_t kinds) {
  std::vector<std::optional<unsigned>> all(job_kinds().size());
  all.insert(all.end(), user_slots.begin(), user_slots.end());
  all.resize(kinds);
  return all;
}

std::vector<Time> periods(Time servo, std::size_t user_tasks) {
  std::vector<Time> all(kind_rows.size() + user_tasks, Time::zero());
  all[static_cast<std::size_t>(JobKind::pid)] = all[static_cast<std::size_t>(JobKind::torque_compensation)] = servo;
  return all;
}

}  // namespace

Ledger::Ledger(LedgerConfig config)
    : names_(with(config.user_tasks)),
      own_slots_(by_kind(config.user_slots, names_.size())),
      booked_(config.booked.empty() ? config.causes : config.booked),
      booked_as_(config.booked_as),
      chain_times_(config.causes, config.chip_clock),
      account_(names_, booked_, periods(config.servo_period, config.user_tasks.size()), config.samples_max),
      why_(names_, chain_times_.causes(), config.misses_kept, own_slots_),
      released_(names_.size(), 0) {}

Ledger::Slot& Ledger::slot(unsigned number) {
  if (slots_.size() <= number) slots_.resize(number + 1);
  return slots_[number];
}

// ---- a job's life ----

void Ledger::release(std::size_t block, JobKind kind, Time released, std::optional<Time> deadline,
                     std::optional<std::int64_t> tick, std::uint32_t robot) {
  audit_.loaded(block, released);
  Open open;
  open.kind = kind;
  const auto index = static_cast<std::size_t>(kind);
  open.name = {index, robot, tick.value_or(released_.at(index))};
  ++released_[index];
  open.released = released;
  open.deadline = deadline;
  open.tick = tick;
  Try& attempt = open.wait_from(released);
  if (released <= refresh_.began) attempt.first_refresh = refresh_.began;
  open_[block] = std::move(open);
}

Ledger::Open Ledger::without_block(JobKind kind, Time released, std::optional<Time> deadline,
                                   std::optional<std::int64_t> tick, std::uint32_t robot) {
  const auto index = static_cast<std::size_t>(kind);
  Open open;
  open.kind = kind;
  open.name = {index, robot, tick ? *tick : released_.at(index)++};
  open.released = released;
  open.deadline = deadline;
  open.tick = tick;
  return open;
}

void Ledger::skipped(JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick,
                     Time found, std::uint32_t robot, report::Wait cause) {
  const Time end = deadline.value_or(found);
  const Open open = without_block(kind, released, deadline, tick, robot);
  report::Job job;
  job.kind = open.name.kind;
  job.progress = report::Progress::dropped;
  job.released = released;
  job.deadline = deadline;
  job.tick = tick;
  account_.add(job, end);
  ++misses_;
  JobTimes& jobs = jobs_[{job.kind, robot}];
  jobs.released.add(released);
  jobs.missed.add(released);
  MissedJob missed = missed_job(open, report::Outcome::dropped, end);
  missed.given_up = found;
  missed.dropped_by = cause;
  for (const auto& [block, other] : open_) {
    if (other.kind != kind || other.name.robot != robot) continue;
    missed.previous = other.name.number;
    missed.dropped_by = report::Wait::previous_out;
  }
  if (watcher_ != nullptr)
    watcher_->ended({open.name, report::Outcome::dropped, true, released, deadline, {}, end, true});
  why_.missed(missed, timeline_, audit_, watcher_);
}

void Ledger::never_loaded(JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick,
                          Time end, std::uint32_t robot) {
  Open open = without_block(kind, released, deadline, tick, robot);
  open.wait_from(released);
  book(open, job_of(open), end);
}

void Ledger::claimed(std::size_t block, unsigned number, Time at, CauseTimes causes, Word generation) {
  audit_.claimed(block, number, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  Open& open = found->second;
  if (const auto own = own_slots_.at(static_cast<std::size_t>(open.kind))) {
    audit_.require(number == *own, at, [&] {
      return fmt::format("block {}: DSP {} claimed a block for DSP {} alone", block, number, *own);
    });
  }
  ++slot(number).claims;
  open.slot = number;
  open.tries.back().run = report::Run{number, at, at, report::Run::End::running};
  if (open.parts.count == 0) open.first_claim = at;
  open.failed = false;
  open.at_claim = std::move(causes);
  timeline_.took(number, open.name, at);
  if (watcher_ != nullptr) watcher_->took(number, {open.name, block, generation, at});
}

void Ledger::leave(Open& open, Time at, report::Run::End end) {
  if (!open.slot) return;
  slot(*open.slot).occupied[static_cast<std::size_t>(open.kind)] += open.occupies_until(at);
  if (watcher_ != nullptr) watcher_->left(*open.slot, open.name, end, at, open.spent);
  report::Run& run = *open.tries.back().run;
  if (run.end != report::Run::End::running) return;  // it had failed before
  run.end = end;
  run.ended = at;
  timeline_.left(run.slot, open.name, at);
}

bool Ledger::finished(std::size_t block, unsigned number, Time at, const CauseTimes& causes, bool part) {
  audit_.finished(block, number, at);
  const auto found = open_.find(block);
  if (found == open_.end() || found->second.slot != number || found->second.finished) return false;
  Open& open = found->second;
  open.failed = false;
  open.tries.back().run->end =
      report::Run::End::running;  // the DSP finished after it was reported failed: clears that report
  open.spent = minus(causes, open.at_claim);
  leave(open, at, part ? report::Run::End::part : report::Run::End::done);
  const std::int64_t whole = (at - open.claimed()).count();
  if (part) {
    part_done(open, at, whole);
    return true;
  }
  open.finished = at;
  if (open.cycles_are_known())
    why_.ran(open.name.kind, open.parts.time.count() + whole,
             plus(open.parts.chain, chain_times_.of(open.spent, whole, true)));
  return true;
}

// From here the job waits for the block of its next part: until the host has seen the end of this part, and then in the
// list.
void Ledger::part_done(Open& open, Time at, std::int64_t whole) {
  open.parts.cycles = open.cycles_are_known() ? plus(open.parts.cycles, open.spent) : CauseTimes{};
  open.parts.chain = plus(open.parts.chain, chain_times_.of(open.spent, whole, true));
  open.parts.time += Time{whole};
  ++open.parts.count;
  open.slot.reset();
  open.at_claim.clear();
  open.spent.clear();
  open.wait_from(at);
}

void Ledger::continued(std::size_t block, std::size_t next, Time at) {
  audit_.removed(block, at);
  audit_.loaded(next, at);
  auto moved = open_.extract(block);
  if (moved.empty()) return;
  Try& attempt = moved.mapped().tries.back();
  attempt.first_refresh = std::max(attempt.waits_from, refresh_.began);
  moved.key() = next;
  open_.insert(std::move(moved));
}

void Ledger::put_back(std::size_t block, Time at) {
  audit_.put_back(block, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  Open& open = found->second;
  leave(open, at, report::Run::End::taken_away);
  open.slot.reset();
  open.failed = false;
  open.at_claim.clear();
  open.wait_from(at).first_refresh = at;
}

// The account has one name for causes that the chains distinguish by bus.
std::vector<std::int64_t> Ledger::booked(const std::vector<std::int64_t>& amounts) const {
  if (booked_as_.empty() || amounts.empty()) return amounts;
  std::vector<std::int64_t> all(booked_.size(), 0);
  for (std::size_t i = 0; i < amounts.size(); ++i) all.at(booked_as_.at(i)) += amounts[i];
  return all;
}

report::Job Ledger::job_of(const Open& open) const {
  report::Job job;
  job.kind = open.name.kind;
  job.released = open.released;
  job.deadline = open.deadline;
  job.claimed = open.first_claim;
  job.tick = open.tick;
  if (open.finished) {
    job.progress = report::Progress::finished;
    job.finished = *open.finished;
    const Time ran = open.parts.time + (*open.finished - open.claimed());
    const CauseTimes cycles = open.cycles_are_known() ? plus(open.parts.cycles, open.spent) : CauseTimes{};
    job.between = *open.finished - job.claimed - ran;
    job.cycles = booked(cycles);
    job.causes = booked(in_picoseconds(cycles, ran.count()));
  } else if (open.slot) {
    job.progress = open.failed ? report::Progress::lost : report::Progress::running;
  } else {
    job.progress = open.parts.count == 0 ? report::Progress::waiting : report::Progress::running;
  }
  return job;
}

MissedJob Ledger::missed_job(const Open& open, report::Outcome outcome, Time end) const {
  MissedJob missed;
  missed.name = open.name;
  missed.outcome = outcome;
  missed.released = open.released;
  missed.deadline = open.deadline;
  missed.end = end;
  missed.tries = open.tries;
  if (open.parts.count > 0) missed.execution = open.parts.chain;
  if (!open.tries.empty() && open.tries.back().run) {
    report::Run& run = *missed.tries.back().run;
    if (run.end == report::Run::End::running) run.ended = end;
    if (run.end == report::Run::End::running || run.end == report::Run::End::done) {
      missed.execution = plus(missed.execution, chain_times_.of(open.spent, (run.ended - run.claimed).count(),
                                                                run.end == report::Run::End::done));
    }
  }
  return missed;
}

report::Outcome Ledger::book(const Open& open, const report::Job& job, Time now) {
  const report::Outcome outcome = account_.add(job, now);
  if (outcome != report::Outcome::on_time) ++misses_;
  JobTimes& jobs = jobs_[{open.name.kind, open.name.robot}];
  jobs.released.add(job.released);
  if (job.progress == report::Progress::finished) jobs.finished.add(job.finished);
  const bool miss = report::missed(job, outcome, now);
  if (watcher_ != nullptr)
    watcher_->ended({open.name, outcome, miss, open.released, open.deadline, open.finished, now, false});
  if (!miss) return outcome;
  jobs.missed.add(job.released);
  MissedJob missed = missed_job(open, outcome, now);
  if (outcome == report::Outcome::dropped) missed.given_up = now;
  why_.missed(missed, timeline_, audit_, watcher_);
  return outcome;
}

void Ledger::forget(Time now) {
  Time oldest = now;
  for (const auto& [block, open] : open_) oldest = std::min(oldest, open.released);
  timeline_.forget(oldest);
}

void Ledger::dropped(std::size_t block, Time at) {
  audit_.dropped(block, at);
  const auto found = open_.find(block);
  if (found == open_.end()) return;
  leave(found->second, at, report::Run::End::taken_away);
  report::Job job = job_of(found->second);
  job.progress = report::Progress::dropped;
  job.causes.clear();
  book(found->second, job, at);
  open_.erase(found);
  forget(at);
}

report::Outcome Ledger::removed(std::size_t block) {
  const auto found = open_.find(block);
  if (found == open_.end()) return report::Outcome::on_time;
  const report::Job job = job_of(found->second);
  audit_.removed(block, job.finished);
  const report::Outcome outcome = book(found->second, job, job.finished);
  open_.erase(found);
  forget(job.finished);
  return outcome;
}

void Ledger::slot_failed(unsigned number, Time at) {
  timeline_.slot(number, SlotState::off, at);
  for (auto& [block, open] : open_) {
    if (open.slot != number || open.finished || open.failed) continue;
    open.failed = true;
    report::Run& run = *open.tries.back().run;
    run.end = report::Run::End::failed;
    run.ended = std::max(at, run.claimed);
  }
}

// ---- the host's refresh ----

void Ledger::refresh_began(Time at) {
  if (open_.empty()) timeline_.forget(at);  // no query will need it; a crane that has done its work may wait for hours
  refresh_ = {.began = at};
  for (auto& [block, open] : open_) {
    Try& attempt = open.tries.back();
    if (!attempt.first_refresh && attempt.waits_from <= at) attempt.first_refresh = at;
  }
}

void Ledger::offered(std::size_t block) {
  const auto found = open_.find(block);
  if (found != open_.end() && !found->second.tries.back().put_up) offered_.emplace_back(block, refresh_);
}

void Ledger::list_freed(Time at) {
  if (refresh_.held != Time::max()) refresh_.free = at;  // else it is the release of the refresh before, which was late
  for (auto& [block, refresh] : offered_) {
    refresh.free = at;
    if (const auto found = open_.find(block); found != open_.end()) found->second.tries.back().put_up = refresh;
  }
  offered_.clear();
}

// ---- reports ----

void Ledger::book_end(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest) {
  for (auto& [block, open] : open_) {
    if (open.released >= now) continue;
    if (open.slot && !open.finished && !open.failed && causes) open.spent = minus(causes(*open.slot), open.at_claim);
    if (Try& last = open.tries.back(); !last.put_up && !last.run && last.first_refresh && refresh_.free == Time::max())
      last.put_up = refresh_;  // it would have been offered by the refresh that is under way
    const Time end = open.finished.value_or(now);
    book(open, job_of(open), end);
  }
  std::erase_if(open_, [](const auto& one) { return one.second.finished.has_value(); });  // in no tick's way any more
  if (rest) rest(*this);
}

void Ledger::introduce(RunWatcher& watcher, const std::function<Word(std::size_t)>& generation) const {
  timeline_.introduce(watcher);
  for (const auto& [block, open] : open_)
    // Of a DSP that has failed nothing runs; it may have been reset, and run another block.
    if (open.slot && !open.finished && !open.failed)
      watcher.took(*open.slot, {open.name, block, generation(block), open.claimed()});
}

void Ledger::close(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest,
                   RunWatcher& watcher) const {
  Ledger all = *this;
  all.watch(&watcher);
  all.book_end(now, causes, rest);
}

Ledger::Report Ledger::tell(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest) const {
  Ledger all = *this;
  all.watch(nullptr);
  all.book_end(now, causes, rest);
  Report out;
  out.tasks = all.account_.report();
  for (std::size_t i = 0; i < out.tasks.size(); ++i) out.tasks[i].why_late = all.why_.summary(i, all.audit_);
  out.misses = all.why_.misses(all.audit_);
  out.misses_left_out = all.why_.left_out();
  out.audit = {all.audit_.checks(), all.audit_.violations()};
  out.jobs = std::move(all.jobs_);
  return out;
}

std::uint64_t Ledger::claims(unsigned number) const { return number < slots_.size() ? slots_[number].claims : 0; }

std::vector<report::Share> Ledger::occupied(unsigned number, Time now) const {
  std::vector<report::Share> shares;
  std::vector<std::int64_t> sums = number < slots_.size() ? slots_[number].occupied : Slot{}.occupied;
  for (const auto& [block, open] : open_) {
    if (open.slot == number && !open.finished) sums[static_cast<std::size_t>(open.kind)] += open.occupies_until(now);
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i] != 0) shares.push_back({names_.at(i), sums[i]});
  }
  return shares;
}

std::optional<report::JobName> Ledger::job_with(std::size_t block) const {
  const auto found = open_.find(block);
  return found == open_.end() ? std::nullopt : std::optional(found->second.name);
}

void Ledger::list_state(state::Visitor& list) {
  list("account", account_);
  list("audit", audit_);
  list("timeline", timeline_);
  list("why", why_);
  list("open", open_);
  list("slots", slots_);
  list("released", released_);
  list("jobs", jobs_);
  list("refresh", refresh_);
  list("offered", offered_);
  list("misses", misses_);
}

}  // namespace cmrc
