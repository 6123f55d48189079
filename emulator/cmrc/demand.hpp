#pragma once
// What the ideal run demanded of the run, and what of it was done: jobs, rates, points (docs/report.md, Rates).
#include <cstdint>
#include <map>

#include "cmrc/measures.hpp"

namespace cmrc {

/// Adds to `errors` the jobs of each kind against those that the ideal run released, and f_p, f_t and f_a.
void add_demand(const Measured& run, const Course& ideal, const JobsByRobot& demanded, report::Errors& errors);

/// Whole point intervals inside legs in which a robot consumed no new point: a gap of g intervals counts floor(g) - 1. By robot.
std::map<Robot, std::uint64_t> starved_intervals(const Course& course, Time end);

}  // namespace cmrc
