#include "cmrc/processes/user_tasks.hpp"

#include "state/visitor.hpp"

namespace cmrc {
namespace {

std::optional<report::Time> allowed_for(const UserTask& task) {
  if (task.deadline_ms <= 0) return std::nullopt;
  return report::from_seconds(task.deadline_ms * 1e-3);
}

}  // namespace

UserTasks::UserTasks(std::span<const UserTask> tasks, const Words& words, double refresh_frequency) : words_(words) {
  for (const UserTask& task : tasks) {
    const std::int64_t period = period_refreshes(task, refresh_frequency);
    rows_.push_back({task, period, period, false});
  }
}

void UserTasks::start(std::int64_t first) {
  for (Row& row : rows_)
    while (row.period > 0 && row.next < first) row.next += row.period;
}

Task UserTasks::block_of(std::size_t number, std::int64_t tick) const {
  return {.x = rows_[number].task.x,
          .kind = words_.kind_user + static_cast<Word>(number),
          .area = words_.us_base + static_cast<Word>(number) * words_.us_words,
          .tick = static_cast<std::uint32_t>(tick),
          .argument = static_cast<std::uint32_t>(rows_[number].task.argument)};
}

void UserTasks::refresh(HostServices& services) {
  const std::int64_t tick = services.tick();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (row.period == 0 || row.stopped || tick < row.next) continue;
    const auto allowed = allowed_for(row.task);
    for (; row.next + row.period <= tick; row.next += row.period)
      if (!row.out) services.drop_within(block_of(i, row.next), row.next, allowed);
    row.next += row.period;
    if (row.out) continue;
    row.out = true;
    if (allowed)
      services.load_within(block_of(i, tick), *allowed);
    else
      services.load(block_of(i, tick), std::nullopt);
  }
}

void UserTasks::each_passed(std::int64_t tick, const std::function<bool(const Task&)>& in_the_way,
                            const Passed& passed) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.period == 0 || row.stopped || tick < row.next || in_the_way(block_of(i, tick))) continue;
    for (std::int64_t due = row.next; due <= tick; due += row.period)
      passed(block_of(i, due), due, allowed_for(row.task), due + row.period <= tick);
  }
}

void UserTasks::Row::list_state(state::Visitor& list) {
  list("next", next);
  list("out", out);
  list("stopped", stopped);
}

void UserTasks::list_state(state::Visitor& list) { list("rows", rows_); }

}  // namespace cmrc
