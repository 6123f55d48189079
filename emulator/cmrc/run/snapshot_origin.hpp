#pragma once
// What a snapshot is a state of: its run's configuration, program and files.
#include <string>
#include <string_view>

#include "cmrc/configuration/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// What two runs must have in common for the one to go on from the other's snapshot.
std::string key_of(Config config);

/// What two runs have in common, with `digest_of_files`, if nothing in their results may differ: the whole
/// configuration but the turn order, strictness (which is about the exit status) and the paths of files.
std::string result_key_of(Config config);

/// Of the DSPs' program, and of the files that a configuration names.
std::string digest_of_files(const Config& config, const toolchain::Image& image);

/// The first line that is in one of them only.
std::string first_other_line(std::string_view one, std::string_view other);

}  // namespace cmrc
