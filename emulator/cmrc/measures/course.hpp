#pragma once
// The course of a run: the places of crane, load and vehicles at each latch of the drives, and the progress of each
// robot's work. Errors, lag and demand are measured from two courses, the run's and its ideal run's (docs/report.md,
// Errors).
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "cmrc/measures/event_times.hpp"
#include "cmrc/tasks/milestone.hpp"
#include "machine/time/time.hpp"
#include "plant/parameters/basics.hpp"

namespace plant {
class Dock;
}
namespace state {
class Visitor;
}

namespace cmrc {

/// Rows of doubles, in memory that a child process shares with its parent.
class SharedRows {
 public:
  /// Room for `rows` rows; the system gives pages when rows are written. \throws std::runtime_error without enough
  /// memory
  SharedRows(std::size_t rows, std::size_t width);
  ~SharedRows();
  SharedRows(const SharedRows&) = delete;
  SharedRows& operator=(const SharedRows&) = delete;

  std::size_t room() const { return room_; }
  std::size_t width() const { return width_; }
  std::span<double> row(std::size_t index) { return {data_ + index * width_, width_}; }
  std::span<const double> row(std::size_t index) const { return {data_ + index * width_, width_}; }
  /// The first `rows` rows, one after the other.
  std::span<double> first(std::size_t rows) { return {data_, rows * width_}; }

 private:
  std::size_t room_, width_;
  double* data_ = nullptr;
};

/// Columns of a course's rows: joints in the order of plant::Joint (rad, m), the load's place in the world (3, m), sway
/// angles (2, rad), then each AGV's place (2, m).
inline constexpr std::size_t load_column = plant::joint_count, sway_column = load_column + 3,
                             agv_column = sway_column + 2;

/// Jobs of one kind for one robot.
struct JobTimes {
  EventTimes released, missed, finished;  ///< a missed job: when it was released
};
using JobsByRobot = std::map<std::pair<std::size_t, Robot>, JobTimes>;  ///< by kind and robot

/// Records one course during its run. Its memory is limited: in a long run only every second, fourth, ... latch has a
/// row, and only every second, fourth, ... point of a leg is a milestone. Begins and ends of legs are all kept.
class Course {
 public:
  static constexpr std::size_t milestones_max = 1 << 18;
  /// Parts of a metre or radian: rows are rounded to a nanometre. Finer digits are the integrators' noise, and would
  /// make the snapshots of long runs large.
  static constexpr double parts = 1 << 30;
  static double to_grid(double value) { return std::floor(value * parts + 0.5) / parts; }

  /// \param rows limit of rows; 0: no rows, only milestones
  Course(std::size_t rows, int agvs);

  void latch(const plant::Dock& dock, Time time);
  /// A robot begins a process, to which the next milestones belong.
  void process_begun(Robot robot, unsigned number);
  /// A leg begins: its points are numbered from `first`, one `interval` apart.
  void leg_begun(Robot robot, std::int64_t first, Time interval, Time at);
  /// \param number of a point: its number within the run; for other kinds 0
  void milestone(Robot robot, Milestone::Kind kind, std::int64_t number, Time at);
  /// From now on PID and torque compensation are released, or not released.
  void servo(bool on, Time at);

  bool recorded() const { return rows_.room() > 0; }
  std::size_t size() const { return size_; }
  /// Memory of its rows.
  std::size_t bytes() const { return size_ * (agv_column + 2 * static_cast<std::size_t>(agvs_)) * sizeof(double); }
  /// The time from row to row: row i is the latch at (i + 1) steps.
  Time step() const { return every_ * plant::latch_period; }
  /// The instant of the last row.
  Time end() const { return static_cast<std::int64_t>(size_) * step(); }
  /// The row at `time` or the last one before it; before the first row, the first row.
  std::span<const double> at(Time time) const;
  /// A column at any instant, linear between rows.
  double at(Time time, std::size_t column) const;
  const std::vector<Milestone>& milestones() const { return milestones_; }
  /// Instants at which servoing began and ended, in turn.
  const std::vector<Time>& servo_times() const { return servo_; }
  /// Whole point intervals inside legs in which a robot used no new point, until `end`: a gap of g intervals counts
  /// floor(g) - 1. By robot.
  std::map<Robot, std::uint64_t> starved_intervals(Time end) const;

  void list_state(state::Visitor& list);
  /// Everything except the rows, for a process that shares the rows.
  void list_all_but_rows(state::Visitor& list);

 private:
  /// A robot's place in its work, as needed for the keys of its milestones.
  struct Place {
    std::uint64_t process = 0, begun = 0;   // number of the process, and how many processes the robot has begun
    std::uint64_t legs = 0;                 // legs begun within the process
    std::int64_t first_point = 0;           // of the leg
    std::array<std::uint64_t, 8> counts{};  // of each kind within the process
  };
  /// A robot's leg, as needed to count intervals without points.
  struct Leg {
    Time last{}, interval{1};  // when it used a point, or the leg began
    bool open = false;
    std::uint64_t starved = 0;  // intervals without points, in all legs so far
    std::uint64_t starved_at(Time time) const;
  };

  static constexpr std::uint64_t points_every_most = std::uint64_t{1} << 32, processes_every_most = 1 << 16;

  void thin_rows();
  bool is_kept(const Milestone& one) const;
  void thin_milestones();

  SharedRows rows_;
  std::size_t size_ = 0;
  std::int64_t every_ = 1;             // every so many latches there is a row
  std::uint64_t points_every_ = 1;     // every so many points of a leg there is a milestone
  std::uint64_t processes_every_ = 1;  // every so many processes of a robot there are milestones beside the legs'
  std::size_t milestones_room_ = milestones_max;
  std::map<Robot, Leg> legs_;
  int agvs_;
  std::map<Robot, Place> places_;
  std::vector<Milestone> milestones_;
  std::vector<Time> servo_;
};

}  // namespace cmrc
