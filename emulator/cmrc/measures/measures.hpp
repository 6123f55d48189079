#pragma once
// Compares a run's course with its ideal run's: errors, lag, demand and rates (docs/report.md, Errors).
#include <optional>
#include <string>
#include <vector>

#include "cmrc/measures/course.hpp"
#include "cmrc/measures/work_progress.hpp"
#include "report/values/measures.hpp"
#include "report/values/run_report.hpp"

namespace plant {
struct CraneParameters;
struct DockConfig;
}  // namespace plant

namespace cmrc {

struct Config;

/// How far one unit of each joint moves the spreader at the jib's full reach, m; for the rotator, half a container's
/// length.
Levers levers(const plant::CraneParameters& crane);

/// The part of an ideal run that is kept for the runs measured against it.
struct Reference {
  Reference(std::size_t rows, int agvs) : course(rows, agvs) {}
  std::string key;  ///< reference_key of the runs for which it is valid
  Course course;
  JobsByRobot jobs;
  std::vector<std::optional<double>> metrics;  ///< of its own report, in the order of report::metrics
  double elapsed_s = 0;
};

/// Rows of a course of the configured duration.
std::size_t rows_of(const Config& config);

/// The part of a run that is measured.
struct Measured {
  const Config& config;
  const plant::DockConfig& dock;
  const Course& course;
  const JobsByRobot& jobs;
  std::vector<std::string> kinds;  ///< the jobs' kinds, by number
  Time to{};                       ///< end of the window
};

/// The errors of a run against its ideal run's course, and its jobs compared with those that the ideal run released. A
/// course that is shorter than the window keeps its last row.
report::Errors measure(const Measured& run, const Course& ideal, const JobsByRobot& demanded);

}  // namespace cmrc
