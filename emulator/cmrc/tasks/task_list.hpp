#pragma once
// The host's own copy of the task-block list: what it has written to shared memory and read back.
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

namespace state {
class Visitor;
}

namespace cmrc {

enum class Flag : std::uint8_t { waiting, taken, done };

/// The task for which a block is loaded.
struct Task {
  std::uint32_t x = 0;      ///< kind of equation (7)
  std::uint32_t y = 0;      ///< robot class
  std::uint32_t kind = 0;   ///< KIND_*: the program that runs
  std::uint32_t robot = 0;  ///< 0 crane, n AGV n - 1; only for the host
  std::uint32_t area = 0;   ///< offset of the robot's area
  std::uint32_t tick = 0;   ///< refresh number of the nominal release
  std::uint32_t argument = 0;
  std::int64_t t = 0;                                   ///< waiting count at the start (a servo block inherits it)
  std::uint32_t slice = 0;                              ///< number of blocks of this task that were before
  std::optional<std::int64_t> deadline = std::nullopt;  ///< refresh number. Only for the host, like the following:
  std::uint32_t process = 0;                            ///< number of the process whose step it is; 0: none
  std::uint32_t error = 0;                              ///< number of the error that an error block is to decide
  std::uint32_t subprocess = 0;                         ///< number of the sub-process that released it
};

struct TaskBlock {
  Task task;
  std::int64_t t = 0;
  Flag flag = Flag::waiting;
  std::uint32_t importance = 0;
  std::uint32_t generation = 0;
  std::uint32_t own_x = 0;     ///< task.x before it was put back
  std::uint64_t inserted = 0;  ///< order of loading; decides between equal J
  std::uint32_t recomputations = 0;
  std::int64_t seen = -1;  ///< refresh at which its flag was first, and last, read as taken; -1: never
  std::int64_t running = -1;
  std::uint32_t beat = 0;  ///< TB_ALIVE as last read, and the refresh at which this value was first read; -1: never
  std::int64_t beat_seen = -1;
  std::int64_t resets = -1;  ///< number of the host's resets before the block is known to be taken; -1: not known
  bool in_use = false;
  bool fresh = false;           ///< its words are not in shared memory yet
  bool passed_through = false;  ///< see TaskList::pass_through
  std::uint32_t written_slice = 0;
  std::int64_t written_link = -1;  // as in shared memory, so that only changes are written
};

/// BLOCK_COUNT of the DSP programs (task_block.inc).
inline constexpr std::int64_t usual_block_count = 64;

/// The list has no place for a further block. Configurations that could fill it are refused (config_invariants.cpp), as
/// far as their blocks can be counted; errors that come at once, and a block that DSPs may still pass through, cannot.
class ListFull : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Blocks in a pool, in the order of ruling 19: taken ones first, then the waiting ones by falling J; among equal J the
/// one that was loaded first.
class TaskList {
 public:
  explicit TaskList(std::size_t capacity);

  /// Loads a block, waiting. \returns its place in the pool. \throws ListFull
  std::size_t load(const Task& task);
  void remove(std::size_t index);
  /// Marks a waiting block as taken: t = 0, without a sign of life yet.
  void take(std::size_t index);
  /// DSPs may still follow the link in the block's words: it is not used again before the next relinking.
  void pass_through(std::size_t index);
  /// Puts a taken block back behind the work pointer as a recompute block (x = 2).
  void put_back(std::size_t index, std::uint32_t x);

  /// t += elapsed for every block; computes J and the order again.
  void refresh(std::int64_t elapsed, const std::function<std::uint32_t(const TaskBlock&)>& importance);
  /// The list has been linked again: DSPs no longer follow the links of removed blocks.
  void release_passed();
  /// Computes the order again, after blocks were found taken.
  void sort();
  /// Order of the last refresh: places in the pool.
  std::span<const std::size_t> order() const { return order_; }

  TaskBlock& operator[](std::size_t index) { return blocks_[index]; }
  const TaskBlock& operator[](std::size_t index) const { return blocks_[index]; }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return blocks_.size(); }
  void list_state(state::Visitor& list);

 private:
  bool before(std::size_t a, std::size_t b) const;

  std::vector<TaskBlock> blocks_;
  std::vector<std::size_t> order_;
  std::uint64_t insertions_ = 0;
  std::size_t size_ = 0;
  bool any_passed_ = false;  // some block may be passed through
};

}  // namespace cmrc
