#pragma once
// What a snapshot is a state of: its run's configuration, program and files.
#include <string>
#include <string_view>

#include "cmrc/config.hpp"
#include "toolchain/image.hpp"

namespace cmrc {

/// What two runs must have in common for the one to go on from the other's snapshot.
std::string key_of(Config config);

/// Of the DSPs' program, and of the files that a configuration names.
std::string digest_of_files(const Config& config, const toolchain::Image& image);

/// The first line that is in one of them only.
std::string first_other_line(std::string_view one, std::string_view other);

}  // namespace cmrc
