#pragma once
// How far a robot's work had come, told by the milestones of the ideal run (docs/report.md, Errors: lag).
#include <string>
#include <vector>

#include "cmrc/measures/course.hpp"
#include "report/measures.hpp"

namespace cmrc {

/// Where a run's robot stood on the ideal run's way, and when the ideal run stood there.
class WorkProgress {
 public:
  /// \param from, to the window that is measured
  WorkProgress(const Course& run, const Course& ideal, Robot robot, Time from, Time to);

  /// The robot does something in the ideal run.
  bool any() const { return way_.size() > 1; }

  /// The instant at which the ideal run had come as far as the run at `time`. Calls come in nondecreasing time.
  Time ideal_time(Time time);

  report::Lag lag(std::string name) const;

 private:
  /// At `at`, `done` milestones of the ideal run are behind the robot. Linear in between.
  struct Knot {
    Time at;
    double done;
  };

  Time to_;
  bool itself_;              // the ideal run beside itself: no rounding
  std::vector<Knot> way_;    // the ideal run's
  std::vector<Knot> knots_;  // the run's
  std::size_t next_ = 1;
};

}  // namespace cmrc
