#include "cmrc/tasks/user_tasks.hpp"

#include <algorithm>
#include <cmath>

namespace cmrc {

UserTasks::UserTasks(std::span<const UserTask> tasks, const Words& words, double refresh_frequency) : words_(words) {
  const auto refreshes = [&](double ms) {
    return std::max<std::int64_t>(1, std::llround(ms * 1e-3 * refresh_frequency));
  };
  for (const UserTask& task : tasks) {
    const std::int64_t period = task.period_ms > 0 ? refreshes(task.period_ms) : 0;
    rows_.push_back({task, period, task.deadline_ms > 0 ? refreshes(task.deadline_ms) : 0, period, false});
  }
}

void UserTasks::refresh(HostServices& services) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (row.period == 0 || row.stopped || services.tick() < row.next) continue;
    row.next += row.period * ((services.tick() - row.next) / row.period + 1);
    if (row.out) continue;
    row.out = true;
    const auto number = static_cast<Word>(i);
    services.load({.x = row.task.x,
                   .kind = words_.kind_user + number,
                   .area = words_.us_base + number * words_.us_words,
                   .tick = static_cast<std::uint32_t>(services.tick()),
                   .argument = static_cast<std::uint32_t>(row.task.argument)},
                  row.deadline > 0 ? std::optional(services.tick() + row.deadline) : std::nullopt);
  }
}

}  // namespace cmrc
