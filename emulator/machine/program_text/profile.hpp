#pragma once
// A chip's profile together with its program: routines by name, instructions by source line.
#include <set>

#include "c40/observers/profile.hpp"
#include "report/text/profile_report.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

/// A profile without groups, with the names of the chip's causes.
report::Profile empty_profile();

report::CyclesByCause by_cause(const c40::Causes& causes);

/// \param outside cycles outside all instructions; \param starts further addresses at which routines begin, besides
/// called ones; \param all_lines include instructions of the source that were not executed
report::ProfileGroup profile_group(const c40::ProfileCounts& counts, const c40::Causes& outside,
                                   const std::set<c40::Address>& starts, const toolchain::Image& image, bool all_lines);

/// Adds a group, and its costs to the total.
void add_group(report::Profile& profile, report::ProfileGroup group);

}  // namespace machine
