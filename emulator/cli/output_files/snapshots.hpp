#pragma once
// --snapshot-at and --resume: files of a run's state, and a run that continues from one (docs/snapshots.md).
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cli/arguments/options.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/run/snapshot.hpp"
#include "io/output_file.hpp"

namespace cli {

struct SnapshotRequest {
  report::Time at{};
  std::string file;
};

/// The snapshots of --snapshot-at in order of time. \throws InputError, also for an instant outside the run
std::vector<SnapshotRequest> snapshot_requests(const RunOptions& options, const cmrc::Config& config);

/// The files: a name that cannot be written is refused before the run.
class SnapshotFiles {
 public:
  explicit SnapshotFiles(std::vector<SnapshotRequest> requests);
  /// Runs to each snapshot that is left, until the run ends.
  void run(cmrc::Simulation& simulation, const std::function<bool(const cmrc::Progress&)>& show);
  std::span<const SnapshotRequest> left() const { return std::span(requests_).subspan(reached_); }

 private:
  std::vector<SnapshotRequest> requests_;
  std::vector<std::unique_ptr<io::OutputFile>> files_;
  std::size_t reached_ = 0;
};

/// \throws InputError that names the file
cmrc::Snapshot read_snapshot(const std::string& file);

/// Continues from the snapshot of `file`. \throws InputError, also for a request before its time
void resume(cmrc::Simulation& simulation, const cmrc::Snapshot& snapshot, const std::string& file,
            std::span<const SnapshotRequest> requests);

}  // namespace cli
