#include "cmrc/tasks/task_list.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "state/visitor.hpp"

namespace cmrc {

TaskList::TaskList(std::size_t capacity) : blocks_(capacity) { order_.reserve(capacity); }

std::size_t TaskList::load(const Task& task) {
  const auto free = std::find_if(blocks_.begin(), blocks_.end(),
                                 [](const TaskBlock& block) { return !block.in_use && !block.passed_through; });
  if (free == blocks_.end())
    throw ListFull(fmt::format("the task-block list is full: all {} blocks are in use", capacity()));
  const std::uint32_t generation = free->generation + 1, written_slice = free->written_slice;
  *free = TaskBlock{};
  free->written_slice = written_slice;
  free->task = task;
  free->own_x = task.x;
  free->t = task.t;
  free->generation = generation;
  free->inserted = ++insertions_;
  free->in_use = true;
  free->fresh = true;
  const auto index = static_cast<std::size_t>(free - blocks_.begin());
  order_.push_back(index);
  ++size_;
  return index;
}

void TaskList::remove(std::size_t index) {
  blocks_[index].in_use = false;
  order_.erase(std::find(order_.begin(), order_.end(), index));
  --size_;
}

void TaskList::take(std::size_t index) {
  TaskBlock& block = blocks_[index];
  block.flag = Flag::taken;
  block.t = 0;
  block.seen = block.running = block.beat_seen = block.resets = -1;
}

void TaskList::put_back(std::size_t index, std::uint32_t x) {
  TaskBlock& block = blocks_[index];
  block.task.x = x;
  block.flag = Flag::waiting;
  block.t = 0;
  ++block.generation;
  block.inserted = ++insertions_;
  block.fresh = true;
  block.written_link = -1;
}

bool TaskList::before(std::size_t a, std::size_t b) const {
  const TaskBlock& first = blocks_[a];
  const TaskBlock& second = blocks_[b];
  if (first.importance != second.importance) return first.importance > second.importance;
  return first.inserted < second.inserted;
}

void TaskList::refresh(std::int64_t elapsed, const std::function<std::uint32_t(const TaskBlock&)>& importance) {
  for (const std::size_t index : order_) {
    blocks_[index].t += elapsed;
    blocks_[index].importance = importance(blocks_[index]);
  }
  sort();
}

void TaskList::pass_through(std::size_t index) {
  blocks_[index].passed_through = true;
  any_passed_ = true;
}

void TaskList::release_passed() {
  if (!any_passed_) return;
  any_passed_ = false;
  for (TaskBlock& block : blocks_) block.passed_through = false;
}

void TaskList::sort() {
  std::sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    const bool a_waits = blocks_[a].flag == Flag::waiting;
    const bool b_waits = blocks_[b].flag == Flag::waiting;
    return a_waits != b_waits ? b_waits : before(a, b);
  });
}

void TaskList::list_state(state::Visitor& list) {
  list("blocks", blocks_);
  list("order", order_);
  list("insertions", insertions_);
  list("size", size_);
  if (list.loads()) any_passed_ = true;
}

}  // namespace cmrc
