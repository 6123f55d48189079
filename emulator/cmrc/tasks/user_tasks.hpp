#pragma once
// Users' tasks (docs/add-a-task.md): rows of [[tasks]] in the configuration, each with a program, its row of equation
// (7) and its period.
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cmrc/configuration/timed_event.hpp"
#include "cmrc/configuration/value.hpp"
#include "cmrc/processes/host_services.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

struct UserTask {
  std::string name;                      ///< the report's key
  std::string program;                   ///< label of its entry in the DSP programs
  std::uint32_t x = 0;                   ///< its kind, in one of the gaps of the paper's table
  std::uint32_t importance = 0;          ///< J from t = due_refreshes on
  std::uint32_t importance_waiting = 0;  ///< J before that; 0: the task must not run early
  std::int64_t due_refreshes = 0;
  double period_ms = 0;
  double deadline_ms = 0;       ///< after its release; 0: none
  double heartbeat_ms = 0;      ///< limit between two beats of its program (lib/alive.asm); 0: no heartbeat
  std::int64_t argument = 0;    ///< TB_ARGUMENT
  std::optional<unsigned> dsp;  ///< the slot whose DSP alone may claim its blocks; none: every DSP
  Origin dsp_origin;
  std::vector<Value> parameters;  ///< initial words of its area: floats as TI singles
  Origin origin;
};

inline constexpr std::size_t most_user_tasks = 8;

/// \param fields of one [[tasks]] \param where it begins \throws ConfigError
UserTask user_task(const std::map<std::string, Field>& fields, const Origin& where);
/// Checks that no two tasks have the same name or kind, and that there are not too many. \throws ConfigError
void check_user_tasks(std::span<const UserTask> tasks);
/// Some task is for one DSP alone: the executive has to support such blocks (c40_programs/claim_own.asm).
bool own_blocks(std::span<const UserTask> tasks);
/// The task's fields as TOML, one line each.
std::string to_toml(const UserTask& task);
/// J of task `task` after t refreshes of waiting.
std::uint32_t importance(const UserTask& task, std::int64_t t);

/// Releases each task once per period; leaves out a period in which the block of the one before is not finished.
class UserTasks {
 public:
  UserTasks(std::span<const UserTask> tasks, const Words& words, double refresh_frequency);
  void refresh(HostServices& services);
  /// A block of a user's task has left the list, finished or given up.
  void ended(const Task& task) { rows_.at(task.kind - words_.kind_user).out = false; }
  /// The task is not released any more.
  void stop(const Task& task) { rows_.at(task.kind - words_.kind_user).stopped = true; }
  /// The task is released again.
  void resume(const Task& task) {
    rows_.at(task.kind - words_.kind_user).stopped = rows_.at(task.kind - words_.kind_user).out = false;
  }
  /// The block belongs to a user's task.
  bool is_one(const Task& task) const { return task.kind >= words_.kind_user; }
  /// The block was released here, not by a process or sub-process of the table.
  bool owns(const Task& task) const { return is_one(task) && task.process == 0 && task.subprocess == 0; }
  const UserTask& row(const Task& task) const { return rows_.at(task.kind - words_.kind_user).task; }
  /// The slot whose DSP alone may claim the block.
  std::optional<unsigned> own_slot(const Task& task) const { return is_one(task) ? row(task).dsp : std::nullopt; }
  void list_state(state::Visitor& list);

 private:
  struct Row {
    UserTask task;
    std::int64_t period, deadline;  // refreshes
    std::int64_t next;
    bool out = false;
    bool stopped = false;  // given up
    void list_state(state::Visitor& list);
  };
  const Words& words_;
  std::vector<Row> rows_;
};

}  // namespace cmrc
