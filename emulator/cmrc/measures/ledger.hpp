#pragma once
// Every job from its release to its end: which DSP ran it, when, and the causes of its cycles (rulings 16 to 18).
//
// A job is one release of a task. A block in the list belongs to one job at a time; a recomputed block still belongs to
// the same job, and so do the blocks of a task in parts, one after the other. The ledger sees claims and ends at the
// DSPs' own writes to the block's flag; the host only reports what is released and what is given up.
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/configuration/rows/user_task.hpp"
#include "cmrc/measures/course.hpp"
#include "cmrc/measures/cycle_times.hpp"
#include "cmrc/measures/timeline.hpp"
#include "cmrc/measures/why_late.hpp"
#include "cmrc/tasks/block_audit.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/time/time.hpp"
#include "report/values/task_account.hpp"

namespace cmrc {

/// What the ledger has to know about the run.
struct LedgerConfig {
  std::vector<std::string> causes;      ///< of the jobs' cycles
  std::vector<std::string> booked;      ///< of the account's cycles; empty: the same
  std::vector<std::size_t> booked_as;   ///< for each of the jobs' causes, the account's
  Time servo_period{};                  ///< of PID and torque compensation
  std::vector<std::string> user_tasks;  ///< their names, kinds from JobKind::user on
  std::vector<std::optional<unsigned>> user_slots =
      {};  ///< by kind: the slot whose DSP alone may claim it, if there is one; empty: no kind has one
  machine::Clock chip_clock{25'000'000};
  std::size_t misses_kept = 1000;  ///< chains of causes that are kept one by one
  std::size_t samples_max = report::Distribution::usual_samples_max;
};

class Ledger {
 public:
  explicit Ledger(LedgerConfig config);

  /// A job begins: it is released at `released` (a servo block may be loaded before its tick).
  void release(std::size_t block, JobKind kind, Time released, std::optional<Time> deadline,
               std::optional<std::int64_t> tick, std::uint32_t robot = 0);
  /// A nominal tick for which no block could be released; the host found this at `found`.
  /// \param tick number of the nominal tick; none: for a kind without ticks, counted together with its jobs
  /// \param cause why, if no earlier block of the task is in its way
  void skipped(JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick, Time found,
               std::uint32_t robot = 0, report::Wait cause = report::Wait::host_late);
  /// A job of an account that ends at `end`: released before, but the host has loaded no block for it yet.
  void never_loaded(JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick,
                    Time end, std::uint32_t robot = 0);
  /// The block's job is not finished, whether or not the host knows that.
  bool is_open(std::size_t block) const {
    const auto found = open_.find(block);
    return found != open_.end() && !found->second.finished;
  }

  // The host's refresh: it begins, requests the list, has the list, has offered these blocks with J > 0, and has
  // released the list.
  void refresh_began(Time at);
  void list_wanted(Time at) { refresh_.wanted = at; }
  void list_held(Time at) { refresh_.held = at; }
  void offered(std::size_t block);
  void list_freed(Time at);
  /// The times of the present refresh.
  const RefreshTimes& refresh() const { return refresh_; }
  void refresh_ended(const RefreshTimes& times, Time at, std::size_t blocks) const {
    if (watcher_ != nullptr) watcher_->refreshed(times, at, blocks);
  }
  /// The states of the DSPs and of the list's semaphore.
  Timeline& timeline() { return timeline_; }
  /// The watcher is called for everything from now on; null: none. Not part of the state.
  void watch(RunWatcher* watcher) { watcher_ = watcher, timeline_.watch(watcher); }
  /// Reports the DSPs' present states and the open jobs. \param generation of a block, by its place in the pool
  void introduce(RunWatcher& watcher, const std::function<Word(std::size_t)>& generation) const;
  /// Adds to an account what only the host knows at its end: the releases that it has not looked at yet, by skipped()
  /// and never_loaded().
  using Rest = std::function<void(Ledger& account)>;
  /// Reports the jobs that are open at `now`, and the rest, as tell() counts them, to a watcher.
  void close(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest, RunWatcher& watcher) const;

  /// A DSP has marked the block 0Fh / FFh. Times are those at which the program issued the write.
  void claimed(std::size_t block, unsigned slot, Time at, CauseTimes causes, Word generation = 0);
  /// \param part the task is not finished: a block that continues it will follow \returns whether this DSP was the one
  /// to finish it.
  bool finished(std::size_t block, unsigned slot, Time at, const CauseTimes& causes, bool part = false);
  /// The host has seen that a part is finished and has loaded the block of the next one: the same job continues.
  void continued(std::size_t block, std::size_t next, Time at);
  /// The block's DSP was given up; the block waits again.
  void put_back(std::size_t block, Time at);
  /// The block was given up for good (ruling 24).
  void dropped(std::size_t block, Time at);
  /// The host has seen FFh and removed the block. \returns the outcome of the job.
  report::Outcome removed(std::size_t block);
  /// A DSP has failed, hung, been pulled out or reset; the block that it was running is lost unless it is recomputed.
  void slot_failed(unsigned slot, Time at);

  /// Statistics, chains of causes, and the audit; jobs that are still open are counted with their state at `now`, if
  /// they were released before.
  struct Report {
    std::vector<report::TaskReport> tasks;
    std::vector<report::MissReport> misses;
    std::uint64_t misses_left_out = 0;
    report::AuditReport audit;
    JobsByRobot jobs;
  };
  /// \param causes a slot's cycles by cause so far, for the jobs that are still running
  Report tell(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest = {}) const;
  std::uint64_t claims(unsigned slot) const;
  /// Jobs that have ended late or were dropped, so far.
  std::uint64_t misses() const { return misses_; }
  /// Picoseconds that a DSP was occupied, by job kind.
  std::vector<report::Share> occupied(unsigned slot, Time now) const;
  /// The job that has this block.
  std::optional<report::JobName> job_with(std::size_t block) const;
  const std::string& name(JobKind kind) const { return names_.at(static_cast<std::size_t>(kind)); }
  const BlockAudit& audit() const { return audit_; }
  void list_state(state::Visitor& list);

 private:
  struct Parts {
    unsigned count = 0;
    Time time{};                      // time that they ran
    CauseTimes cycles;                // by cause; empty unless known for each
    std::vector<std::int64_t> chain;  // ps, by a chain's causes
  };
  struct Open {
    JobKind kind{};
    report::JobName name;
    Time released{};
    std::optional<Time> deadline;
    std::optional<std::int64_t> tick;
    std::optional<unsigned> slot;  // the DSP that runs it
    bool failed = false;           // its DSP has failed
    std::optional<Time> finished;
    CauseTimes at_claim;
    CauseTimes spent;  // cycles of the run by cause, after its end
    std::vector<Try> tries;
    Time first_claim{};  // first claim of the whole run: of its first part, if it has parts
    Parts parts;         // finished parts
    /// Of the run, and of its finished parts.
    bool cycles_are_known() const { return !spent.empty() && (parts.count == 0 || !parts.cycles.empty()); }
    Try& wait_from(Time at) {
      Try& attempt = tries.emplace_back();
      attempt.waits_from = at;
      return attempt;
    }
    Time claimed() const { return tries.back().run ? tries.back().run->claimed : Time{}; }
    /// How long its DSP has been occupied with it until `now`: no longer than until the DSP's failure or reset.
    std::int64_t occupies_until(Time now) const {
      const report::Run& run = *tries.back().run;
      return ((run.end == report::Run::End::running ? now : run.ended) - run.claimed).count();
    }
  };
  struct Slot {
    std::uint64_t claims = 0;
    std::vector<std::int64_t> occupied =
        std::vector<std::int64_t>(kind_rows.size() + most_user_tasks, 0);  // by job kind
  };

  std::vector<std::int64_t> booked(const std::vector<std::int64_t>& amounts) const;
  report::Job job_of(const Open& open) const;
  void part_done(Open& open, Time at, std::int64_t whole);
  /// A job for which the host has loaded no block.
  Open without_block(JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick,
                     std::uint32_t robot);
  MissedJob missed_job(const Open& open, report::Outcome outcome, Time end) const;
  report::Outcome book(const Open& open, const report::Job& job, Time now);
  void leave(Open& open, Time at, report::Run::End end);
  void book_end(Time now, const std::function<CauseTimes(unsigned)>& causes, const Rest& rest);
  void forget(Time now);
  Slot& slot(unsigned number);

  std::vector<std::string> names_;
  std::vector<std::optional<unsigned>> own_slots_;  // by kind
  std::vector<std::string> booked_;
  std::vector<std::size_t> booked_as_;
  ChainTimes chain_times_;
  report::TaskAccount account_;
  BlockAudit audit_;
  Timeline timeline_;
  WhyLate why_;
  std::map<std::size_t, Open> open_;
  std::vector<Slot> slots_;
  std::vector<std::int64_t> released_;  // number of jobs so far, by kind
  JobsByRobot jobs_;
  RefreshTimes refresh_{{}, {}, {}, {}};                       // the present one
  std::vector<std::pair<std::size_t, RefreshTimes>> offered_;  // blocks whose refresh has not released the list yet
  std::uint64_t misses_ = 0;
  RunWatcher* watcher_ = nullptr;
};

}  // namespace cmrc
