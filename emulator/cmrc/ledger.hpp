#pragma once
// Every job from its release to its end: who ran it, when, and what its DSP's cycles went into (rulings 16 to 18).
//
// A job is one release of a task. A block in the list stands for one job at a time; a recomputed block goes on being the same job.
// Claims and ends are seen at the DSPs' own writes to the block's flag; the host only says what is released and what is given up.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/audit.hpp"
#include "cmrc/list.hpp"
#include "cmrc/words.hpp"
#include "report/task_account.hpp"

namespace cmrc {

using report::Time;

/// Kinds of jobs in the order of ruling 29.
enum class JobKind : std::uint8_t {
  pid, torque_compensation, trajectory_crane, trajectory_agv, inverse_crane, inverse_agv, obstacle_avoidance, identify,
  grab_path, home_crane, home_agv, error, recompute,
  user  ///< the first of the user's own tasks
};
/// Keys of ruling 29, in the order of JobKind.
std::vector<std::string> job_kinds();
/// The job kind of a program (KIND_*).
JobKind job_kind(Word kind, const Words& words);

using CauseTimes = std::vector<std::int64_t>;  ///< cycles of one chip by cause

class Ledger {
 public:
  /// \param cause_names of the chips; \param servo_period of PID and torque compensation; \param user_tasks their names,
  /// kinds from JobKind::user on
  Ledger(std::vector<std::string> cause_names, Time servo_period, std::vector<std::string> user_tasks = {});

  /// A job exists from now on: it is released at `released` (a servo block may be loaded before its tick).
  void release(std::size_t block, JobKind kind, Time released, std::optional<Time> deadline, std::optional<std::int64_t> tick);
  /// A nominal tick for which no block could be released.
  void skipped(JobKind kind, Time released, Time deadline, std::int64_t tick);
  /// A DSP has marked the block 0Fh / FFh. Times are those at which the program issued the write.
  void claimed(std::size_t block, unsigned slot, Time at, const CauseTimes& causes);
  /// \returns whether it was this DSP's to finish.
  bool finished(std::size_t block, unsigned slot, Time at, const CauseTimes& causes);
  /// The block's DSP was given up; the block waits again.
  void put_back(std::size_t block, Time at);
  /// The block was given up for good (ruling 24).
  void dropped(std::size_t block, Time at);
  /// The host has seen FFh and taken the block out. \returns what became of the job.
  report::Outcome removed(std::size_t block);
  /// A DSP has died or been pulled; what it was running is lost unless it is recomputed.
  void slot_failed(unsigned slot, Time at);

  /// Statistics with the jobs that are still open booked as they stand at `now`.
  std::vector<report::TaskReport> report(Time now, unsigned slots) const;
  std::uint64_t claims(unsigned slot) const;
  /// Jobs that have ended late or were dropped so far.
  std::uint64_t misses() const { return misses_; }
  /// Picoseconds that a DSP was occupied, by job kind.
  std::vector<report::Share> occupied(unsigned slot, Time now) const;
  std::optional<JobKind> kind_of(std::size_t block) const;
  const std::string& name(JobKind kind) const { return names_.at(static_cast<std::size_t>(kind)); }
  const Audit& audit() const { return audit_; }

 private:
  struct Open {
    JobKind kind{};
    Time released{};
    std::optional<Time> deadline;
    std::optional<std::int64_t> tick;
    std::optional<unsigned> slot;   // running on it
    Time claimed{};
    bool failed = false;            // its DSP is dead
    std::optional<Time> finished;
    CauseTimes cycles;              // at the claim; after the end, what the run took
    CauseTimes causes;              // after the end: the same in picoseconds
  };
  struct Slot {
    std::uint64_t claims = 0;
    std::vector<std::int64_t> occupied = std::vector<std::int64_t>(21, 0);
  };

  report::Job job_of(const Open& open) const;
  report::Outcome book(const report::Job& job, Time now);
  void leave(Open& open, Time at);
  Slot& slot(unsigned number);

  std::vector<std::string> names_;
  report::TaskAccount account_;
  Audit audit_;
  std::map<std::size_t, Open> open_;
  std::vector<Slot> slots_;
  std::uint64_t misses_ = 0;
};

}  // namespace cmrc
