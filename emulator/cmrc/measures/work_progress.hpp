#pragma once
// The progress of a robot's work, measured by the milestones of the ideal run (docs/report.md, Errors: lag).
#include <array>
#include <string>
#include <vector>

#include "cmrc/measures/course.hpp"
#include "report/values/measures.hpp"

namespace cmrc {

/// How far one unit of each joint moves the crane's spreader, m.
using Levers = std::array<double, plant::joint_count>;

/// The progress of a run's robot along the ideal run's work, and the time of this progress in the ideal run. Until the
/// run's last milestone within the window the milestones tell it; beyond it, how far the robot has got from there.
class WorkProgress {
 public:
  /// \param run, ideal have to outlive this object
  /// \param from, to the window that is measured
  WorkProgress(const Course& run, const Course& ideal, Robot robot, Time from, Time to, const Levers& levers);

  /// The robot does something in the ideal run.
  bool any() const { return way_.size() > 1; }

  /// The instant at which the ideal run had the progress that the run has at `time`. `time` must not decrease between
  /// calls.
  Time ideal_time(Time time);

  report::Lag lag(std::string name) const;

 private:
  /// At `at`, the robot has passed `done` milestones of the ideal run. Linear in between.
  struct Knot {
    Time at;
    double done;
  };

  /// How far the calls of ideal_time have come.
  struct Cursor {
    std::size_t next;  // knot
    Time run_until;    // instants of the run before this one are in `reach`
    Time ideal_until;  // until then the ideal run has got no farther than that
    double reach = 0;  // m, the greatest distance of the run from where it passed the last milestone
  };
  Cursor beginning() const { return {1, knots_.back().at, way_[passed()].at}; }
  /// How many milestones of the ideal run the run has passed within the window.
  std::size_t passed() const { return static_cast<std::size_t>(knots_.back().done); }
  Time beyond(Time time);
  double distance(const Course& course, Time from, Time to) const;

  const Course* run_;
  const Course* ideal_;
  Robot robot_;
  Levers levers_;
  Time to_;
  Time step_;                // from one instant at which both courses have a row to the next
  std::vector<Knot> way_;    // the ideal run's
  std::vector<Knot> knots_;  // the run's
  Cursor at_;
};

}  // namespace cmrc
