#pragma once
// The keys of a run's report for its errors against the ideal run (docs/report.md).
#include <nlohmann/json.hpp>

#include "report/values/run_report.hpp"

namespace report {

/// Adds them to the report's root.
void add_measures(const RunReport& report, nlohmann::ordered_json& root);

}  // namespace report
