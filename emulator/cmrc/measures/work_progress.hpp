#pragma once
// The progress of a robot's work, measured by the milestones of the ideal run (docs/report.md, Errors: lag).
#include <string>
#include <vector>

#include "cmrc/measures/course.hpp"
#include "report/measures.hpp"

namespace cmrc {

/// The progress of a run's robot along the ideal run's work, and the time of this progress in the ideal run.
class WorkProgress {
 public:
  /// \param from, to the window that is measured
  WorkProgress(const Course& run, const Course& ideal, Robot robot, Time from, Time to);

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

  Time to_;
  bool itself_;              // the ideal run's
  std::vector<Knot> way_;    // the run's
  std::vector<Knot> knots_;  // the run's
  std::size_t next_ = 1;
};

}  // namespace cmrc
