#pragma once
// What the ideal run demanded of the run, and what of it was done: jobs, rates, points (docs/report.md, Rates).
#include "cmrc/measures/measures.hpp"

namespace cmrc {

/// Adds to `errors` the jobs of each kind against those that the ideal run released, and f_p, f_t and f_a.
void add_demand(const Measured& run, const Course& ideal, const JobsByRobot& demanded, report::Errors& errors);

}  // namespace cmrc
