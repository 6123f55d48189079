#pragma once
// --snapshot-at and --resume: files of a run's state, and a run that continues from one (docs/snapshots.md).
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments/options.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/run/snapshot.hpp"
#include "io/file_roles.hpp"

namespace cli {

struct SnapshotRequest {
  report::Time at{};
  std::string file;
};

/// The snapshots of --snapshot-at in order of time. \throws InputError, also for an instant outside the run
std::vector<SnapshotRequest> snapshot_requests(const RunOptions& options, const cmrc::Config& config);

/// \throws InputError that names the file
cmrc::Snapshot read_snapshot(const std::string& file);

}  // namespace cli
