#pragma once
// Compares what the ideal run demanded with what the run did: jobs, rates, points (docs/report.md, Rates).
#include "cmrc/measures/measures.hpp"

namespace cmrc {

/// Adds to `errors` the jobs of each kind compared with those that the ideal run released, and f_p, f_t and f_a.
void add_demand(const Measured& run, const Course& ideal, const JobsByRobot& demanded, report::Errors& errors);

}  // namespace cmrc
