#pragma once
// The host's software: refreshes the task-block list at f_s, every access a transaction on bus A (ruling 20), and runs
// the processes.
//
// One refresh, as steps between answers of the bus:
//   pointer    read the work pointer: what stood before it has been claimed since the last refresh
//   passed     where blocks are linked that are for one DSP alone: read the flags of those behind the pointer, up to
//              the first that waits for anybody
//   flags      read the flag of every block that is taken; of those that are done the result and notify words, of those
//   that are not and have
//              a heartbeat that word. Of those that the watchdog finds too old read the owner, fence it off, and read
//              the flag again: now it cannot change any more
//   field      read what the AGVs' range sensors see in their way, where a sub-process is released by it
//   (docs/processes.md) thinking   the host's own work, for a modelled time; then finished blocks are out, successors
//   in, t, J and order are computed;
//              new blocks and changed words of the job areas are written, not yet linked
//   semaphore  acquire the list
//   relink     read the work pointer (and flags) again: a block may have been claimed since; write t, J, links, the
//   work pointer; release doorbell   read the mask of idle DSPs, ring one per eligible block, lowest slot first; for
//   one that is for one DSP
//              alone, that one
//
// Between refreshes it boots the DSPs that ask for it (boot_loader.hpp); at power-on all of them before the first
// refresh.
//
// A refresh that is late leaves out the ticks it has missed: they are counted, and t advances by all of them.
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
#include "cmrc/processes/errors.hpp"
#include "cmrc/processes/processes.hpp"
#include "cmrc/programs/servo_law.hpp"
#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "cmrc/tasks/user_tasks.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/machine.hpp"
#include "report/event.hpp"
#include "report/run_report.hpp"

namespace cmrc {

/// What the host says of itself while it runs.
class HostListener {
 public:
  virtual ~HostListener() = default;
  virtual void event(const report::Event& event) = 0;
  virtual void failure(const report::FailureReport& failure) = 0;
};

class Host : public machine::HostProgram, private HostServices, private ErrorActions {
 public:
  /// \param boot_stream what a slot's DSP is to be sent; asked while the machine runs
  Host(const Config& config, const Words& words, const CraneJob& crane, const FleetJob& fleet, Ledger& ledger,
       HostListener& listener, std::function<std::vector<Word>(unsigned slot)> boot_stream);

  /// A checked event "set", for the first refresh at or after `at`.
  void change(Time at, const TimedEvent& event) { changes_.emplace(at, event); }
  /// Tells it of processes, milestones and servoing. Before the run.
  void set_course(Course* course) { course_ = course; }
  /// Torque compensation and PID are released at every tick.
  bool servoing() const { return servoing_; }
  bool job_done() const { return processes_.job_done(); }
  std::optional<Time> first_refresh() const { return first_refresh_; }

  Time next_wake() const override { return wake_at_; }
  void wake(Time now, machine::HostPort& port) override;
  void boot_requested(Time now) override;
  void read_done(std::uint32_t tag, std::span<const machine::Word> words, Time now, machine::HostPort& port) override;

  /// Counts; the times of the semaphore are the observer's to add.
  report::HostReport report() const;
  /// What waited for less wind.
  void add_wind(report::WindReport& wind) const;
  const ContainerCycles& cycles() const { return cycles_; }
  const Errors& errors() const { return errors_; }
  const TaskList& list() const { return list_; }
  std::int64_t refresh() const { return tick_; }
  const machine::Clock& refresh_clock() const { return clock_; }
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

  /// A periodic task of the crane: torque compensation or PID.
  struct Servo {
    Task task;
    JobKind job;
    unsigned subprocess;  // the row by which it is released
    std::int64_t next;    // nominal tick to be released next
    bool out = false;     // a block of it is in the list
    std::size_t block = 0;
    std::int64_t last_t = 0;  // t of the last block when it was found done
    bool stopped = false;     // given up
    bool waits = false;       // its block was given up, and an error block is to decide what follows
    void list_state(state::Visitor& list);
  };
  struct Done {
    std::size_t block;
    Word result, notify;
  };
  struct Hung {
    std::size_t block;
    std::optional<unsigned> slot;  // its owner, fenced off; none when the claim broke off before it was written
    std::int64_t age;              // refreshes
  };

  // Desk
  std::int64_t tick() const override { return tick_; }
  void load(const Task& task, std::optional<std::int64_t> deadline) override;
  void drop(const Task& task, std::int64_t due, std::int64_t deadline) override;
  using HostServices::write;
  void write(Word offset, std::span<const Word> words) override;
  bool servo_resting() const override;
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
  void stop_work(const Task& lost) override;
  void resume_work(const Task& lost) override;
  void stop_servo(bool stopped) override {
    torque_.stopped = pid_.stopped = stopped, torque_.waits = pid_.waits = false;
  }

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
  std::int64_t silence_limit() const;  // refreshes; 0: none
  void next_field();
  void field_read(Word millimetres);
  /// Refreshes made: while the host is away nobody can show it a sign of life.
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
  /// \param on servoing is on; ticks at which it is not are nobody's
  void refresh_servo(Servo& servo, bool on);
  void load_servo(Servo& servo);
  void drop_tick(Servo& servo);
  /// An experiment leaves this nominal tick out (scheduling.servo_loss_share, servo_served_every).
  bool left_out(std::int64_t tick) const;
  std::size_t load_block(const Task& task, JobKind job, Time released, std::optional<Time> deadline,
                         std::optional<std::int64_t> tick);
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
  std::multimap<Time, TimedEvent> changes_;  // still to come
  machine::Clock clock_;
  Ledger& ledger_;
  HostListener& listener_;

  TaskList list_;
  Processes processes_;
  UserTasks user_tasks_;
  Errors errors_;
  ControlBlock control_;
  ContainerCycles cycles_;
  Servo torque_, pid_;
  Course* course_ = nullptr;
  bool servoing_ = false;
  std::optional<Time> first_refresh_;

  Step step_ = Step::resting;
  Time wake_at_;
  Time refresh_at_ = machine::never;  // the next one
  Time now_{};
  machine::HostPort* port_ = nullptr;  // during a call only
  std::int64_t tick_ = 0;
  std::int64_t elapsed_ = 0;         // refreshes since the last one
  std::int64_t grown_ = 0;           // by which t grows at this one
  std::vector<std::size_t> linked_;  // blocks from the work pointer on as shared memory links them: they wait, or were
                                     // claimed past those for one DSP alone
  bool own_linked_ = false;          // some of them are for one DSP alone
  std::deque<std::size_t> passed_;   // of them, those whose flags are still to be read
  std::deque<std::size_t> flags_;    // blocks whose flags are still to be read
  std::deque<unsigned> fields_;      // AGVs whose sensors are still to be read at this refresh
  std::deque<std::size_t> signs_;    // blocks that were out at this refresh, whose owners are alive
  std::vector<Done> done_;
  std::vector<Hung> hung_;
  bool pointer_in_doubt_ = false;  // a semaphore was freed: a claim may have broken off
  Time refused_since_{};
  bool refused_ = false;
  Word held_for_ = 0;         // us, the list's semaphore
  std::uint32_t dither_ = 1;  // state of the generator that varies the pause before the next try
  std::uint64_t eligible_ = 0;
  Word fence_ = 0xFFFFFFFF;
  std::array<std::int64_t, 32> renewed_{};  // refresh at which a slot was last reset by the host
  std::optional<unsigned> suspect_;         // owner of the block whose flag is being read again
  std::optional<unsigned> holder_;          // of the list, fenced off, from which it is being taken
  Liveness liveness_;
  BootLoader boots_;
  Time pid_ended_{};  // a block of PID was last found done
  std::uint64_t pid_runs_ = 0;
  std::map<std::pair<Word, Robot>, std::int64_t> drops_;  // of a kind and robot, in a row
  std::map<JobKind, std::int64_t> longest_;               // longest runs in refreshes, at least as configured
  std::map<JobKind, std::int64_t>
      gaps_;  // longest between two beats in refreshes, at least as configured; of kinds that have a heartbeat

  report::HostReport counts_;
  struct {
    std::int64_t waited = 0;  // refreshes
    std::uint64_t waits = 0;
    bool waits_now = false;
  } wind_;
  void watch_wind();
  report::Distribution durations_, lengths_;
};

}  // namespace cmrc
