#pragma once
// A chip's profile beside the program that it ran: routines by name, instructions by source line.
#include <set>

#include "c40/profile.hpp"
#include "report/profile_report.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

/// A profile without groups, with the names of the chip's causes.
report::Profile empty_profile();

report::CyclesByCause by_cause(const c40::Causes& causes);

/// \param outside cycles that no instruction took; \param starts where routines begin besides those that were called;
/// \param all_lines instructions of the source that were not executed, too
report::ProfileGroup profile_group(const c40::ProfileCounts& counts, const c40::Causes& outside,
                                   const std::set<c40::Address>& starts, const toolchain::Image& image, bool all_lines);

/// Adds a group, and its costs to the whole.
void add_group(report::Profile& profile, report::ProfileGroup group);

}  // namespace machine
