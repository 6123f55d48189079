#pragma once
// Sub-processes 1 and 2 of one robot: trajectory planning and inverse kinematics, point after point, as far ahead as
// the interpolation buffer has room (plant-and-bus.md 4.4 item 4).
//
// Trajectory planning of point k is loaded when that of k - 1 is finished, inverse kinematics of k - 2 is finished (the
// ring of Cartesian points holds two) and fewer than `depth` points are ahead of the robot. Inverse kinematics of k is
// loaded when trajectory planning of k is finished, and inherits its t: the refreshes since trajectory planning of k
// was loaded, even if trajectory planning of k + 1 is loaded in the same refresh. The deadline of both is the instant
// at which the buffer runs dry without point k. At rest, before the first point of a leg has been used, points are due
// at intervals from the leg's beginning.
#include <cstdint>
#include <deque>

#include "cmrc/processes/host_services.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

class PointChain {
 public:
  /// `trajectory` and `inverse` are the tasks to load; this class sets tick, argument and t.
  PointChain(Task trajectory, Task inverse, std::int64_t depth)
      : trajectory_(trajectory), inverse_(inverse), depth_(depth) {}

  /// A leg begins: its first point has number `first`, and points are `interval` refreshes apart.
  void begin(std::int64_t first, std::int64_t interval, std::int64_t tick);
  /// The report of trajectory planning's block: the point was the leg's last one; inverse kinematics of this point is
  /// demanded; trajectory planning is demanded again.
  void trajectory_done(bool end_of_leg, bool inverse, bool again);
  void inverse_done() {
    ++joint_;
    inverse_out_ = false;
  }
  /// The robot has used `count` points since the start of the run, the last one from refresh `start` on (crane:
  /// reported by PID).
  void consumed(std::int64_t count, std::int64_t start);
  /// A set-point was written to the drive's own buffer, which holds each for one interval (AGV).
  void pushed(std::int64_t tick);
  /// Loads the blocks for which there is room.
  void refresh(HostServices& services);
  /// All points of the leg have been used; reports them to the host.
  bool ended(HostServices& services);
  /// A block was given up: its point is requested again.
  void lost_trajectory() { trajectory_out_ = false; }
  void lost_inverse() { inverse_out_ = false; }

  /// No more points: the work is given up.
  void abandon() { abandoned_ = active_, active_ = false; }
  /// Continues after abandon().
  void resume() { active_ = active_ || abandoned_, abandoned_ = false; }

  bool active() const { return active_; }
  /// All points of the leg have passed inverse kinematics, and all were used.
  bool through(std::int64_t tick) const;
  /// A leg has begun, and is not finished.
  bool under_way(std::int64_t tick) const { return active_ && !through(tick); }
  std::int64_t next_point() const { return cartesian_; }
  std::int64_t interval() const { return interval_; }
  /// Tasks and depth are not listed: they never change.
  void list_state(state::Visitor& list);
  /// The buffer would be dry; the robot is moving.
  bool dry(std::int64_t tick) const { return active_ && anchored_ && !through(tick) && need(joint_) < tick; }

 private:
  std::int64_t need(std::int64_t point) const { return base_ + interval_ * (point - base_count_); }
  std::int64_t consumed_by(std::int64_t tick) const;
  void tell(HostServices& services);

  Task trajectory_;
  Task inverse_;
  std::int64_t depth_;
  std::int64_t interval_ = 1;
  std::int64_t cartesian_ = 0;  // points made by trajectory planning; also the number of the next one
  std::int64_t joint_ = 0;      // the same for inverse kinematics
  std::int64_t consumed_ = 0;
  std::int64_t base_ = 0;  // refresh at which point base_count_ is needed
  std::int64_t base_count_ = 0;
  std::int64_t loaded_at_ = 0;   // refresh at which the last trajectory block was loaded
  std::int64_t planned_at_ = 0;  // the same for the last finished one: the inverse block of its point inherits its t
  bool anchored_ = false;        // the robot has used a point of this leg
  bool drive_buffer_ = false;
  bool trajectory_out_ = false;
  bool inverse_out_ = false;
  bool again_ = false;  // the leg has begun, or trajectory planning has demanded itself
  bool ended_ = false;
  bool active_ = false;
  std::int64_t begun_at_ = 0;           // refresh
  std::int64_t reported_ = 0;           // used points that were reported to the host
  std::deque<std::int64_t> used_from_;  // refresh, of each further point that the robot has used or its drive holds
  bool begin_reported_ = true, end_reported_ = true;
  bool abandoned_ = false;
};

}  // namespace cmrc
