#pragma once
// From the errors that the host has dealt with, the timed events and the plant's record to what the report says of
// them.
#include <span>
#include <vector>

#include "cmrc/processes/errors.hpp"
#include "plant/dock/dock.hpp"
#include "report/handled_error.hpp"

namespace cmrc {

/// \param dock its recorded signals say how far things have moved: between two rows, on the straight line
/// \param block_name the name of a block's kind
std::vector<report::HandledError> handled_errors(std::span<const ErrorEntry> entries, const Config& config,
                                                 const plant::Dock& dock, Time end,
                                                 const std::function<std::string(Word kind)>& block_name);

}  // namespace cmrc
