#pragma once
// The host's services for the processes during a refresh.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "cmrc/tasks/milestone.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "cmrc/tasks/words.hpp"
#include "report/events/event.hpp"
#include "report/values/why_late.hpp"

namespace cmrc {

/// A nominal tick k N_p of the servo; refresh numbers.
struct NominalTick {
  std::int64_t number;  ///< k
  std::int64_t released, deadline;
};

class HostServices {
 public:
  virtual ~HostServices() = default;
  /// The number of the present refresh.
  virtual std::int64_t tick() const = 0;
  /// Loads a block into the list. \param deadline refresh number; none: never late
  virtual void load(const Task& task, std::optional<std::int64_t> deadline) = 0;
  /// The same; the deadline is `allowed` after the release, wherever that falls between refreshes.
  virtual void load_within(const Task& task, report::Time allowed) = 0;
  /// A block was due at refresh `due`, but could not be loaded, because the block before it was not finished. It is
  /// dropped, and counts as missed.
  virtual void drop(const Task& task, std::int64_t due, std::int64_t deadline) = 0;
  /// The same, with a deadline like that of load_within; none: without a deadline.
  virtual void drop_within(const Task& task, std::int64_t due, std::optional<report::Time> allowed) = 0;
  /// Loads a block of the servo. \returns its place in the list
  virtual std::size_t load_tick(const Task& task, const NominalTick& tick) = 0;
  /// No block could be released for this tick. \param block place of the block before it \param cause why, if that
  /// block is not in the way
  virtual void drop_tick(const Task& task, const NominalTick& tick, std::size_t block, report::Wait cause) = 0;
  /// Writes words of a job area; they arrive before a block loaded in the same refresh can be claimed.
  virtual void write(Word offset, std::span<const Word> words) = 0;
  void write(Word offset, Word word) { write(offset, std::span<const Word>(&word, 1)); }
  /// Neither torque compensation nor PID is running: several words that they read may be changed together.
  virtual bool servo_resting() const = 0;
  /// The path's clock at a refresh; hoist ramps use this clock.
  virtual std::int64_t path(std::int64_t refresh) const = 0;
  /// An error was noticed (phase 0), decided (1), its response was carried out (2), it was cleared (3).
  virtual void error(Word number, Word what, Robot robot, Word phase, Word response) = 0;
  /// The servo's parameters have a new generation. `changed`: the channels with new rows; bit 5: the words against
  /// sway.
  virtual void control(Word generation, Word changed) = 0;
  /// A process has started or ended. For process 4 the robot is the AGV that is loaded.
  virtual void process(unsigned number, bool started, Robot robot) = 0;
  /// Not all corner switches have closed: the load is lifted, and lowered again unless this was the last try.
  virtual void landing_missed(bool last) = 0;
  /// An AGV has reached its slot of the queue or the loading spot, or leaves its slot.
  virtual void agv_waits(unsigned agv, bool waits) = 0;
  /// An AGV starts to the warehouse with this N^_a.
  virtual void agv_sent(unsigned agv, std::int64_t interval) = 0;
  /// A robot has begun a process (Course::process_begun), or has reached this milestone at refresh `at`
  /// (Course::milestone).
  virtual void robot_begins(Robot robot, unsigned process) = 0;
  /// A leg has begun at refresh `at`: its points are numbered from `first`, `interval` refreshes apart.
  virtual void leg_begun(Robot robot, std::int64_t first, std::int64_t interval, std::int64_t at) = 0;
  virtual void milestone(Robot robot, Milestone::Kind kind, std::int64_t number, std::int64_t at) = 0;
};

}  // namespace cmrc
