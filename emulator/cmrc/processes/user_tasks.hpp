#pragma once
// Users' tasks at work: released once per period, or by processes.
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "cmrc/configuration/rows/user_task.hpp"
#include "cmrc/processes/host_services.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// Releases each task once per period, at refreshes that are multiples of it; leaves out a period in which the block of
/// the one before is not finished. If the host is late, the last of the periods that have passed is released and the
/// others are dropped.
class UserTasks {
 public:
  UserTasks(std::span<const UserTask> tasks, const Words& words, double refresh_frequency);
  /// The first refresh.
  void start(std::int64_t first);
  void refresh(HostServices& services);
  using Passed =
      std::function<void(const Task& task, std::int64_t due, std::optional<report::Time> allowed, bool dropped)>;
  /// Reports the releases up to refresh `tick` to which the host has not come.
  /// \param in_the_way whether an earlier block of this task is not finished
  void each_passed(std::int64_t tick, const std::function<bool(const Task&)>& in_the_way, const Passed& passed) const;
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
  Task block_of(std::size_t number, std::int64_t tick) const;

  const Words& words_;
  std::vector<Row> rows_;
};

}  // namespace cmrc
