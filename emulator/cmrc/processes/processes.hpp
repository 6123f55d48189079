#pragma once
// The running processes of the table: the process and step of each robot, and which process starts next.
//
// A process starts when it is demanded, or when all that have to consent have consented. Processes without a robot run
// at the same time as all others; the crane and each AGV have one at a time. If several processes of a robot may start,
// the one with the lowest number does, unless another one replaces it. A crane's process to which an AGV's process
// consents gets the AGV in the loading spot.
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cmrc/configuration/rows/process_table.hpp"
#include "cmrc/processes/consents.hpp"
#include "cmrc/processes/crane_steps.hpp"
#include "cmrc/processes/fleet.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/releases.hpp"
#include "cmrc/processes/user_tasks.hpp"

namespace cmrc {

class Processes {
 public:
  Processes(const ProcessTable& table, std::span<const UserTask> tasks, const CraneJob& crane, const FleetJob& fleet,
            const Words& words);

  void start(HostServices& services);
  /// A block of a step, or of a robot's sub-process, has finished.
  void finished(const Task& task, Word result, Word notify, HostServices& services);
  /// A block was dropped after too many recomputations: its work is requested again.
  void dropped(const Task& task);
  /// A dropped block's work is not requested again: it stops. \returns what stops, for the report
  std::string abandoned(const Task& task);
  /// The work continues after the operator has cleared the error.
  void resume(const Task& task);
  /// An error stops the crane's steps, or lets them continue.
  void hold_crane(bool held) { crane_held_ = held; }
  /// An error has the load set down: the step `lower` ends, and no step follows. Off: the next step follows.
  void set_crane_down(bool asked);
  bool crane_is_down() const { return crane_down_; }
  bool crane_lowers() const;
  /// Repeats a landing that was given up.
  void landing_again();
  /// Advances as far as the last reports allow.
  void refresh(HostServices& services);

  /// Sub-process `number` of a robot has to be released now.
  bool releases(unsigned number, Robot robot) const;
  using Passed = std::function<void(const Task& task, std::int64_t due, std::int64_t deadline, bool dropped)>;
  /// Reports the releases by interval up to refresh `tick` to which the host has not come.
  /// \param in_the_way whether an earlier block of this task is not finished
  void each_passed(std::int64_t tick, const std::function<bool(const Task&)>& in_the_way, const Passed& passed) const;
  /// The work of the crane and of every AGV is finished (processes 7 and 8 have ended).
  bool job_done() const;
  /// The processes that run and were reported, each with its AGV as HostServices::process has it.
  void each_running(const std::function<void(unsigned number, Robot agv)>& tell) const;
  /// AGVs whose range sensors the host reads at this refresh.
  std::vector<unsigned> sensors_to_read(std::int64_t tick);
  /// A reading: mm to the nearest echo in the vehicle's way.
  void seen(unsigned agv, Word millimetres);
  /// \param staggered the AGVs' releases by interval come at different refreshes, else at the same one
  void set_releases(const RangeWatch& watch, bool staggered) { watch_ = watch, staggered_ = staggered; }
  /// The crane would begin a lift, and waits for less wind.
  bool waits_for_wind() const;
  CraneSteps& crane() { return crane_; }
  const CraneSteps& crane() const { return crane_; }
  Fleet& fleet() { return fleet_; }
  const Fleet& fleet() const { return fleet_; }
  void list_state(state::Visitor& list);

 private:
  /// A running process, or a place for one.
  struct Run {
    const Process* process = nullptr;
    std::size_t step = 0;
    std::optional<unsigned> agv = std::nullopt;  // of an AGV's process, or assigned to the crane's
    bool wants_task = false;                     // the step's block has to be loaded
    bool silent = false;   // its start was not reported: an AGV that waits in the queue at the beginning
    bool stopped = false;  // given up
    bool retired = false;  // its robot's work is finished
  };
  struct RunState;
  std::optional<unsigned> agv_in_spot() const;
  bool may_start(const Process& process, unsigned agv) const;
  const Process* next_of(Robots robot, unsigned agv) const;
  bool takes_agv(const Process& process) const;
  void begin(Run& run, const Process& process, std::optional<unsigned> agv, HostServices& services);
  void enter(Run& run, HostServices& services);
  void advance(Run& run, Word notify, HostServices& services);
  void end(Run& run, Word notify, HostServices& services);
  void demand(unsigned target, std::optional<unsigned> agv, HostServices& services);
  void start_free(HostServices& services);
  void load_task(Run& run, HostServices& services);
  Task task_of(const Run& run, const HostServices& services) const;
  Task user_block(const std::string& name, Robot robot) const;
  void move_crane(HostServices& services);
  void start_crane(HostServices& services);
  void move_agv(unsigned agv, HostServices& services);
  void release(Robot robot, HostServices& services);
  bool runs(const Release& release, std::int64_t tick) const;
  Task block_of(const Release& release, std::int64_t tick) const;
  std::int64_t interval(Robot robot) const { return robot == 0 ? crane_.interval() : fleet_.interval(robot - 1); }
  Release* release_of(const Task& task);
  Run& run_of(const Task& task);
  const Run& run_of_robot(Robot robot) const { return robot == 0 ? crane_run_ : agv_runs_.at(robot - 1); }
  unsigned demands(const Process& process, unsigned agv) const {
    return demands_.at(process.number).at(process.robot == Robots::agv ? agv : 0);
  }

  const ProcessTable table_;
  const std::vector<UserTask> tasks_;
  const Words& words_;
  Word undemandable_ = 0;  // bits of TB_NOTIFY that the row of sub-process 1 does not list
  Consents consents_;
  CraneSteps crane_;
  Fleet fleet_;
  std::vector<Run> free_runs_;  // processes without a robot, in the table's order
  Run crane_run_;
  bool start_waits_ = false;  // for less wind: the crane is between two processes
  bool crane_held_ = false;   // by an error, like the following:
  bool crane_sets_down_ = false, crane_down_ = false;
  std::vector<Run> agv_runs_;
  std::vector<std::vector<unsigned>> demands_;  // [process][agv]: tokens for one place, like consents
  std::vector<Release> releases_;               // of sub-processes that are released by interval or event
  std::vector<RangeField> fields_;              // of each AGV's range sensor
  RangeWatch watch_;
  bool staggered_ = true;
  std::int64_t read_until_ = 0;  // refresh up to which the sensors' readings are counted
};

}  // namespace cmrc
