#pragma once
// --snapshot-at and --resume: a run written to a file on the way, and gone on with from one (docs/snapshots.md).
#include <optional>
#include <string>
#include <vector>

#include "cli/options.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/run/snapshot.hpp"
#include "io/file_roles.hpp"

namespace cli {

struct SnapshotRequest {
  report::Time at{};
  std::string file;
};

/// What --snapshot-at asks for, by time. \throws InputError, also for an instant that is not within the run
std::vector<SnapshotRequest> snapshot_requests(const RunOptions& options, const cmrc::Config& config);

/// \throws InputError naming the file
cmrc::Snapshot read_snapshot(const std::string& file);
void write_snapshot(const std::string& file, const cmrc::Snapshot& snapshot);

}  // namespace cli
