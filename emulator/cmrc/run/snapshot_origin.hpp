#pragma once
// The origin of a snapshot: its run's configuration, program and files.
#include <string>
#include <string_view>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "report/events/event.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// What must be equal in two runs if one continues from the other's snapshot, apart from the paths of files.
std::string key_of(Config config);
/// A configuration in TOML without its lines of paths.
std::string without_paths(const std::string& toml);

/// What must be equal in two runs, together with `digest_of_inputs`, for equal results: the whole configuration except
/// the turn order, strictness (which affects the exit status) and the paths of files.
std::string result_key_of(Config config);

/// The configuration without its events from `time` on: runs with the same result are equal until then.
Config beginning_of(Config config, report::Time time);

/// The configuration's settings that name files, empty if it names none: configurations with equal settings need the
/// same files.
std::vector<std::string> inputs_of(const Config& config);

/// SHA-256 of those files: the DSPs' program as assembled, without the configuration's values, the layout and the
/// board. \throws the errors for a missing or a wrong file
std::string digest_of_inputs(const Config& config);

/// SHA-256 of the DSPs' program, and of the files that a configuration names. A file that has gone during the run
/// counts as empty.
std::string digest_of_files(const Config& config, const toolchain::Image& image);

/// The first line that only one of the two has.
std::string first_other_line(std::string_view one, std::string_view other);

}  // namespace cmrc
