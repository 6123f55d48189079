#pragma once
// A run's course beside its ideal run's: errors, lag, demand and rates (docs/report.md, Errors).
#include <array>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/course.hpp"
#include "plant/parameters/config.hpp"
#include "report/measures.hpp"
#include "report/run_report.hpp"

namespace cmrc {

/// By how much one unit of each joint moves the spreader at the jib's full reach, m; of the rotator, half a container's
/// length.
std::array<double, plant::joint_count> levers(const plant::CraneParameters& crane);

/// What an ideal run leaves for the runs that are measured against it.
struct Reference {
  Reference(std::size_t rows, int agvs) : course(rows, agvs) {}
  std::string key;  ///< reference_key of the runs that it serves
  Course course;
  JobsByRobot jobs;
  std::vector<std::optional<double>> metrics;  ///< of its own report, as report::metrics has them
  double elapsed_s = 0;
};

/// Rows of a course of the configured duration.
std::size_t rows_of(const Config& config);

/// A run, as far as it is measured.
struct Measured {
  const Config& config;
  const plant::DockConfig& dock;
  const Course& course;
  const JobsByRobot& jobs;
  std::vector<std::string> kinds;  ///< the jobs' kinds, by number
  Time to{};                       ///< end of the window
};

/// The errors of a run against its ideal run's course, and its jobs against those that the ideal run released. Courses
/// that are shorter than the window stay at their last row.
report::Errors measure(const Measured& run, const Course& ideal, const JobsByRobot& demanded);

}  // namespace cmrc
