#pragma once
// The parts of a run's report for its errors against the ideal run: the first lines, and the section.
#include <string>

#include "report/values/run_report.hpp"

namespace report {

/// f_p, f_t and f_a: demanded, realised, missed; the load's error and the lag.
std::string headline(const RunReport& report);
/// Errors by joint, sway and vehicle, lag, control cost, drives.
std::string errors_section(const RunReport& report);
/// The load after all drives had stopped.
std::string after_stop_section(const RunReport& report);

}  // namespace report
