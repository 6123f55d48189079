#pragma once
// The project's version; emulator/report/version.cmake gets it from git.

namespace report {

/// "0.1.0", or between releases "0.1.0.devN+gHASH". Not part of a run's hash.
extern const char* const emulator_version;

}  // namespace report
