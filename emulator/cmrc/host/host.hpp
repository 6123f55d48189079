#pragma once
// The host's software: refreshes the task-block list at f_s, every access a transaction on bus A (ruling 20), and runs
// the processes.
//
// One refresh has these steps, between answers of the bus:
//   pointer    read the work pointer: the blocks before it have been claimed since the last refresh
//   passed     only if blocks for one DSP alone are linked: read the flags of the blocks after the pointer, up to the
//              first one that any DSP may claim
//   flags      read the flag of every claimed block; for finished blocks the result and notify words, for unfinished
//              ones with a heartbeat that word. For blocks that are too old for the watchdog: read the owner, fence it
//              off, and read the flag again, which can no longer change
//   field      read the AGVs' range sensors, if a sub-process is released by them (docs/processes.md)
//   thinking   the host's own work, for a modelled time; then finished blocks are out, successors are in, t, J and
//              the order are computed; new blocks and changed words of the job areas are written, not yet linked
//   semaphore  acquire the list
//   relink     read the work pointer (and flags) again, because a block may have been claimed since; write t, J,
//              links and the work pointer; release the list
//   doorbell   read the mask of idle DSPs, ring one doorbell per eligible block, lowest slot first; for a block for
//              one DSP alone, that DSP's
//
// Between refreshes the host boots the DSPs that request it (boot_loader.hpp); at power-on it boots all of them before
// the first refresh.
//
// A late refresh leaves out the ticks that it has missed: they are counted, and t grows by all of them.
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/boot_loader.hpp"
#include "cmrc/host/liveness.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/processes/container_cycles.hpp"
#include "cmrc/processes/control_block.hpp"
#include "cmrc/processes/errors.hpp"
#include "cmrc/processes/processes.hpp"
#include "cmrc/processes/servo_releases.hpp"
#include "cmrc/processes/user_tasks.hpp"
#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/host_program.hpp"
#include "report/events/event.hpp"
#include "report/values/run_report.hpp"

namespace cmrc {

/// Reports of the host during a run.
class HostListener {
 public:
  virtual ~HostListener() = default;
  virtual void event(const report::Event& event) = 0;
  virtual void failure(const report::FailureReport& failure) = 0;
  virtual void reset_by_watchdog(unsigned slot) = 0;
  virtual void boot_given_up(unsigned slot, Time at) = 0;
  /// The host has done the work of a tick's refresh; its writes may be on their way. \param blocks in the list
  virtual void refreshed(Time tick, std::size_t blocks, Time now) = 0;
};

class Host : public machine::HostProgram, private HostServices, private ErrorActions {
 public:
  /// \param boot_stream the boot stream of a slot's DSP; called while the machine runs
  Host(const Config& config, const Words& words, const CraneJob& crane, const FleetJob& fleet, Ledger& ledger,
       HostListener& listener, std::function<std::vector<Word>(unsigned slot)> boot_stream);

  /// A checked event "set", executed at the first refresh at or after `at`.
  void change(Time at, const TimedEvent& event) { changes_.emplace(at, event); }
  /// Reports processes, milestones and servoing to `course`. To be called before the run.
  void set_course(Course* course) { course_ = course; }
  /// Adds to an account that ends at `end` the releases before then that the host has not looked at: it is paused, or
  /// waits for a bus. Every nominal tick before the end, minus gamma, belongs to the account. It is dropped if another
  /// one has come since, or the block before it is in its way; else its job was never started. When the host continues,
  /// it does the same.
  void count_rest(Time end, Ledger& account) const;
  /// Torque compensation and PID are released at every tick, or an error has stopped them.
  bool servoing() const { return servoing_from_.has_value(); }
  /// The refresh from which on they are.
  std::optional<Time> servoing_from() const { return servoing_from_; }
  bool job_done() const { return processes_.job_done(); }
  std::optional<Time> first_refresh() const { return first_refresh_; }

  Time next_wake() const override { return wake_at_; }
  void wake(Time now, machine::HostPort& port) override;
  void boot_requested(Time now) override;
  void read_done(std::uint32_t tag, std::span<const machine::Word> words, Time now, machine::HostPort& port) override;

  /// The host's counts up to `end`, with the ticks before then that have no refresh. The observer adds the times of the
  /// semaphore and of the refreshes.
  report::HostReport report(Time end) const;
  /// Adds the waits for less wind.
  void add_wind(report::WindReport& wind) const;
  /// The tick whose refresh has not ended.
  std::optional<Time> refresh_under_way() const;
  const Processes& processes() const { return processes_; }
  const ContainerCycles& cycles() const { return cycles_; }
  const Errors& errors() const { return errors_; }
  const TaskList& list() const { return list_; }
  std::int64_t refresh() const { return tick_; }
  void list_state(state::Visitor& list);

 private:
  enum class Step : std::uint8_t {
    resting,
    booting,
    pointer,
    passed,
    flags,
    alive,
    result,
    owner,
    verdict,
    signs,
    field,
    thinking,
    semaphore,
    retry,
    held,
    holder,
    locked_flags,
    relink,
    locked_passed,
    doorbell
  };

  struct Done {
    std::size_t block;
    Word result, notify;
  };
  struct Hung {
    std::size_t block;
    std::optional<unsigned> slot;  // its owner, fenced off; none if the claim broke off before the owner was written
    std::int64_t age;              // refreshes
  };

  // HostServices
  std::int64_t tick() const override { return tick_; }
  void load(const Task& task, std::optional<std::int64_t> deadline) override;
  void load_within(const Task& task, Time allowed) override {
    const Time released = clock_.at(tick_);
    load_block(task, job_kind(task.kind, words_), released, released + allowed, std::nullopt);
  }
  void drop(const Task& task, std::int64_t due, std::int64_t deadline) override {
    drop_block(task, due, clock_.at(deadline));
  }
  void drop_within(const Task& task, std::int64_t due, std::optional<Time> allowed) override {
    drop_block(task, due, allowed ? std::optional(clock_.at(due) + *allowed) : std::nullopt);
  }
  std::size_t load_tick(const Task& task, const NominalTick& tick) override {
    return load_block(task, job_kind(task.kind, words_), clock_.at(tick.released), clock_.at(tick.deadline),
                      tick.number);
  }
  void drop_tick(const Task& task, const NominalTick& tick, std::size_t block, report::Wait cause) override;
  using HostServices::write;
  void write(Word offset, std::span<const Word> words) override;
  bool servo_resting() const override { return servo_.resting(); }
  void process(unsigned number, bool started, Robot robot) override;
  void landing_missed(bool last) override;
  std::int64_t path(std::int64_t refresh) const override {
    return static_cast<std::int64_t>(errors_.path().at(refresh));
  }
  void error(Word number, Word what, Robot robot, Word phase, Word response) override;
  void control(Word generation, Word changed) override;
  void agv_waits(unsigned agv, bool waits) override { cycles_.agv_waits(agv, waits, now_); }
  void agv_sent(unsigned agv, std::int64_t interval) override { cycles_.sent(agv, interval); }
  void robot_begins(Robot robot, unsigned process) override { course_->process_begun(robot, process); }
  void leg_begun(Robot robot, std::int64_t first, std::int64_t interval, std::int64_t at) override;
  void milestone(Robot robot, Milestone::Kind kind, std::int64_t number, std::int64_t at) override;

  // ErrorActions: host_errors.cpp
  void hold_crane(bool held) override { processes_.hold_crane(held); }
  void set_crane_down(bool asked) override { processes_.set_crane_down(asked); }
  bool crane_is_down() const override { return processes_.crane_is_down(); }
  bool crane_lowers() const override { return processes_.crane_lowers(); }
  void landing_decided(bool again) override;
  void landing_again() override { processes_.landing_again(); }
  void ask_again(const Task& lost) override;
  bool stop_work(const Task& lost) override;
  void resume_work(const Task& lost) override;
  void stop_servo(bool stopped) override { servo_.stop_all(stopped); }

  void rest();
  void start();
  void begin_refresh();
  void apply_changes();
  void set_releases();
  void pointer_read(Word pointer);
  void collect_taken();
  void next_flag();
  void flag_read(Word flag);
  void alive_read(Word beat);
  void judge();
  void owner_read(Word owner);
  void verdict_read(Word flag);
  void after_flags();
  std::int64_t silence_limit() const;  // in refreshes; 0: no limit
  void next_field();
  void field_read(Word millimetres);
  /// Number of refreshes made: while the host is paused, it can see no sign of life.
  std::int64_t looks() const { return static_cast<std::int64_t>(counts_.refreshes); }
  void begin_thinking();
  void sign_read(Word owner);
  void judge_silence();
  void think();
  void take_out(const Done& done);
  void load_next_part(std::size_t done, const Task& task, std::uint32_t own_x);
  void recompute(const Hung& hung);
  void give_up(std::size_t block);
  void fence_off(unsigned slot);
  void renew(unsigned slot);
  void drop_block(const Task& task, std::int64_t due, std::optional<Time> deadline);
  /// Throws the list's error with instant and place.
  std::size_t place_in_list(const Task& task);
  std::size_t load_block(const Task& task, JobKind job, Time released, std::optional<Time> deadline,
                         std::optional<std::int64_t> tick);
  /// The word TB_TICK of a waiting block at this refresh.
  Word tick_of(const TaskBlock& block) const;
  void write_new_blocks();
  void acquire();
  void semaphore_read(Word taken);
  void held_read(Word microseconds);
  void holder_read(Word owner);
  void take_from_holder(bool taken);
  void try_again();
  void claimed_before(Word pointer);
  bool look_past(Step step);
  bool passed_read(Word flag);
  void taken_at_last(std::size_t index);
  void taken_in_doubt(std::size_t index);
  bool waits(std::size_t index) const { return list_[index].in_use && list_[index].flag == Flag::waiting; }
  std::optional<unsigned> own_slot(std::size_t index) const { return user_tasks_.own_slot(list_[index].task); }
  void relink();
  void ring(Word idle);
  void end_refresh();
  bool drives_wait_too_long() const;
  std::int64_t watchdog_limit(JobKind job) const;
  std::int64_t age(const TaskBlock& block) const;
  std::uint32_t importance_of(const TaskBlock& block) const;
  bool is_long(const TaskBlock& block) const;
  void hold_back_long_blocks();
  void note(report::EventKind kind, std::array<std::uint32_t, 5> arguments);
  JobKind job_of(std::size_t block) const { return job_kind(list_[block].task.kind, words_); }

  Config config_;
  const Words words_;
  ImportanceParameters parameters_;
  const Intervals intervals_;
  std::multimap<Time, TimedEvent> changes_;  // future ones
  machine::Clock clock_;
  Ledger& ledger_;
  HostListener& listener_;

  TaskList list_;
  Processes processes_;
  UserTasks user_tasks_;
  Errors errors_;
  ControlBlock control_;
  ContainerCycles cycles_;
  ServoReleases servo_;
  Course* course_ = nullptr;
  std::optional<Time> servoing_from_;
  std::optional<Time> first_refresh_;

  Step step_ = Step::resting;
  Time wake_at_;
  Time refresh_at_ = machine::never;  // the next one
  Time now_{};
  machine::HostPort* port_ = nullptr;  // only during a call
  std::int64_t tick_ = 0;
  std::int64_t elapsed_ = 0;         // refreshes since the last one
  std::int64_t grown_ = 0;           // growth of t at this refresh
  std::vector<std::size_t> linked_;  // blocks from the work pointer on, in the order of the links in shared memory:
                                     // they wait, or were claimed past blocks for one DSP alone
  bool own_linked_ = false;          // some of them are for one DSP alone
  std::deque<std::size_t> passed_;   // those of them whose flags are still to be read
  std::deque<std::size_t> flags_;    // blocks whose flags are still to be read
  std::deque<unsigned> fields_;      // AGVs whose sensors are still to be read at this refresh
  std::deque<std::size_t> signs_;    // blocks that were claimed at this refresh, whose owners are alive
  std::vector<Done> done_;
  std::vector<Hung> hung_;
  bool pointer_in_doubt_ = false;  // a semaphore was released by force: a claim may have broken off
  Time refused_since_{};
  bool refused_ = false;
  Word held_for_ = 0;         // us for which the list's semaphore is held
  std::uint32_t dither_ = 1;  // state of the generator that varies the pause before the next try
  std::uint64_t eligible_ = 0;
  Word fence_ = 0xFFFFFFFF;
  std::int64_t resets_ = 0;  // number of times that the host has reset a slot, or found it without a program
  std::array<std::int64_t, machine::most_slots> renewed_{};  // the last one of a slot, in this count; 0: none
  std::optional<unsigned> suspect_;                          // owner of the block whose flag is being read again
  std::optional<unsigned> holder_;  // owner of the list, fenced off, from which the host takes or has taken it
  Liveness liveness_;
  BootLoader boots_;
  Time pid_ended_{};  // when a block of PID was last found finished
  std::uint64_t pid_runs_ = 0;
  std::map<std::pair<Word, Robot>, std::int64_t> drops_;  // drops in a row, by kind and robot
  std::map<JobKind, std::int64_t> longest_;               // longest runs in refreshes, at least the configured ones
  std::map<JobKind, std::int64_t>
      gaps_;  // longest gap between two beats in refreshes, at least the configured one; for kinds with a heartbeat

  report::HostReport counts_;
  struct {
    std::int64_t waited = 0;  // refreshes
    std::uint64_t waits = 0;
    bool waits_now = false;
  } wind_;
  void watch_wind();
  report::Distribution lengths_;
};

}  // namespace cmrc
