#pragma once
// Makes the report's account of errors from the errors that the host has handled, the timed events and the plant's
// record.
#include <span>
#include <vector>

#include "cmrc/processes/errors.hpp"
#include "plant/dock/dock.hpp"
#include "report/values/handled_error.hpp"

namespace cmrc {

/// \param dock its recorded signals give the distances moved; between two rows, interpolated linearly
/// \param block_name the name of a block's kind
std::vector<report::HandledError> handled_errors(std::span<const ErrorEntry> entries, const Config& config,
                                                 const plant::Dock& dock, Time end,
                                                 const std::function<std::string(Word kind)>& block_name);

}  // namespace cmrc
