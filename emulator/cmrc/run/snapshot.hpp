#pragma once
// A run at an instant: from it the same run goes on, in this process or another, and ends with the same report and
// hash.
#include <memory>
#include <string>
#include <string_view>

#include "report/event.hpp"
#include "state/archive.hpp"

namespace cmrc {

/// A snapshot that cannot be used: cut short, damaged, of another version or another configuration. The message says
/// which.
using SnapshotError = state::StateError;

class Snapshot {
 public:
  /// \param configuration of the run, as TOML, as it was before Simulation::at
  /// \param files a digest of the files that it names
  /// \param state what Simulation lists
  Snapshot(report::Time time, std::string configuration, std::string files, state::Saved state);

  report::Time time() const { return time_; }
  const std::string& configuration() const { return configuration_; }
  const std::string& files() const { return files_; }
  const std::string& state() const { return state_->text; }

  /// A file's contents: with a checksum, the version, and the configuration.
  std::string to_bytes() const;
  /// \throws SnapshotError
  static Snapshot from_bytes(std::string_view bytes);

 private:
  report::Time time_;
  std::string configuration_, files_;
  std::shared_ptr<const state::Saved> state_;
};

}  // namespace cmrc
