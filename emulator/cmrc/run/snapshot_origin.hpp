#pragma once
// What a snapshot is a state of: its run's configuration, program and files.
#include <string>
#include <string_view>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "report/event.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// What two runs must have in common for the one to go on from the other's snapshot.
std::string key_of(Config config);

/// What two runs have in common, with `digest_of_inputs`, if nothing in their results may differ: the whole
/// configuration but the turn order, strictness (which is about the exit status) and the paths of files.
std::string result_key_of(Config config);

/// The configuration without its events from `time` on: runs that have it in common are alike until then.
Config beginning_of(Config config, report::Time time);

/// What a configuration says of the files that it needs, empty where it needs none: two configurations that say the
/// same need the same files.
std::vector<std::string> inputs_of(const Config& config);

/// SHA-256 of those files: the DSPs' program as it is assembled, before anything of the configuration is put into it,
/// the layout and the board. \throws what a missing or a wrong file throws
std::string digest_of_inputs(const Config& config);

/// Of the DSPs' program, and of the files that a configuration names.
std::string digest_of_files(const Config& config, const toolchain::Image& image);

/// The first line that is in one of them only.
std::string first_other_line(std::string_view one, std::string_view other);

}  // namespace cmrc
