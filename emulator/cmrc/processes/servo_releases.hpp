#pragma once
// The servo at work: torque compensation and PID, released at the nominal ticks k N_p while servoing is on (ruling 17).
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "cmrc/configuration/config.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/processes.hpp"
#include "cmrc/tasks/task_list.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

class ServoReleases {
 public:
  /// All must outlive this object. \param config may change during the run
  ServoReleases(const Config& config, const Words& words, const Processes& processes, const TaskList& list);
  /// The first refresh.
  void start(std::int64_t first);
  /// PID is released at nominal ticks: servoing is on. If an error has stopped it, its ticks are dropped.
  bool on() const { return released(pid_); }
  /// \param grown refreshes by which t grows at this refresh
  void refresh(std::int64_t grown, HostServices& services);
  /// \param dropped why it is dropped, if no earlier block is in its way; none: its job was never started
  using Passed = std::function<void(const Task& task, const NominalTick& tick, std::optional<report::Wait> dropped)>;
  /// Reports the releases up to refresh `last` to which the host has not come.
  /// \param open whether the job of a block is not finished
  void each_passed(std::int64_t last, const std::function<bool(std::size_t block)>& open, const Passed& passed) const;

  /// The block is the servo's.
  bool owns(const Task& task) const { return task.kind == pid_.task.kind || task.kind == torque_.task.kind; }
  /// A block has left the list: finished after t refreshes, or given up.
  void finished(std::size_t block, std::int64_t t);
  void given_up(std::size_t block);
  /// A task whose block was given up is released again, or stops: its ticks are dropped.
  void ask_again(const Task& task) { servo_of(task).waits = false; }
  void stop(const Task& task) { servo_of(task).stopped = true, servo_of(task).waits = false; }
  /// Both tasks stop, or are released again.
  void stop_all(bool stopped) { torque_.stopped = pid_.stopped = stopped, torque_.waits = pid_.waits = false; }
  bool pid_stopped() const { return stopped(pid_); }

  /// Torque compensation of the tick of this block of PID, or of one before, is not finished.
  bool torque_is_behind(const Task& pid) const;
  /// Neither is running, nor can be claimed before the next relink.
  bool resting() const { return rests(torque_) && rests(pid_); }
  void list_state(state::Visitor& list);

 private:
  struct Servo {
    Task task;
    unsigned subprocess;  // the row that releases it
    std::int64_t next;    // nominal tick to be released next
    bool out = false;     // one of its blocks is in the list
    std::size_t block = 0;
    std::int64_t last_t = 0;  // t of the last block when it was found finished
    bool stopped = false;     // given up: its ticks are dropped
    bool waits = false;       // its block was given up, and an error block has to decide what follows
    void list_state(state::Visitor& list);
  };
  Servo& servo_of(const Task& task) { return task.kind == pid_.task.kind ? pid_ : torque_; }
  bool released(const Servo& servo) const { return processes_.releases(servo.subprocess, servo.task.robot); }
  /// Given up. Without torque compensation's feed-forward PID gets no work either, so that the drives' time-out brakes.
  bool stopped(const Servo& servo) const { return servo.stopped || torque_.stopped; }
  /// Why a tick is dropped at this refresh, if no earlier block is in its way.
  report::Wait cause(const Servo& servo, std::int64_t tick, std::int64_t refresh) const;
  bool rests(const Servo& servo) const;
  /// An experiment leaves out this tick (scheduling.servo_loss_share, servo_served_every).
  bool left_out(std::int64_t tick) const;
  NominalTick nominal(std::int64_t tick) const;
  void refresh(Servo& servo, std::int64_t grown, HostServices& services);
  void load(Servo& servo, std::int64_t grown, HostServices& services);
  void drop(Servo& servo, HostServices& services);

  const Config& config_;
  const Processes& processes_;
  const TaskList& list_;
  const std::int64_t period_;  // N_p
  Servo torque_, pid_;
};

}  // namespace cmrc
