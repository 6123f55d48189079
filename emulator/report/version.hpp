#pragma once
// The version, which emulator/report/version.cmake asks git for.

namespace report {

/// Of the project: "0.1.0", or between releases "0.1.0.devN+gHASH". No part of a run's hash.
extern const char* const emulator_version;

}  // namespace report
