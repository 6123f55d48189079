#pragma once
// Users' tasks at work: released once per period, or by processes.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cmrc/processes/host_services.hpp"
#include "cmrc/tasks/user_task.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

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
    std::int64_t period;  // refreshes
    std::int64_t next;
    bool out = false;
    bool stopped = false;  // given up
    void list_state(state::Visitor& list);
  };
  const Words& words_;
  std::vector<Row> rows_;
};

}  // namespace cmrc
