#include "cmrc/tasks/user_tasks.hpp"

namespace cmrc {

UserTasks::UserTasks(std::span<const UserTask> tasks, const Words& words, double refresh_frequency) : words_(words) {
  for (const UserTask& task : tasks) {
    const std::int64_t period = period_refreshes(task, refresh_frequency);
    rows_.push_back({task, period, period, false});
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
    const Task block{.x = row.task.x,
                     .kind = words_.kind_user + number,
                     .area = words_.us_base + number * words_.us_words,
                     .tick = static_cast<std::uint32_t>(services.tick()),
                     .argument = static_cast<std::uint32_t>(row.task.argument)};
    if (row.task.deadline_ms > 0)
      services.load_within(block, report::from_seconds(row.task.deadline_ms * 1e-3));
    else
      services.load(block, std::nullopt);
  }
}

}  // namespace cmrc
