#pragma once
// The state of a run at an instant. The same run continues from it, in this process or another, and ends with the same
// report and hash.
#include <memory>
#include <string>
#include <string_view>

#include "report/events/event.hpp"
#include "state/archive.hpp"

namespace cmrc {

/// A snapshot that cannot be used: cut short, damaged, of another version or another configuration. The message says
/// which.
using SnapshotError = state::StateError;

class Snapshot {
 public:
  /// \param configuration of the run, as TOML, without events added by Simulation::at
  /// \param files a digest of the files that the configuration names
  /// \param state the state that Simulation lists
  Snapshot(report::Time time, std::string configuration, std::string files, state::Saved state);

  report::Time time() const { return time_; }
  const std::string& configuration() const { return configuration_; }
  const std::string& files() const { return files_; }
  const std::string& state() const { return state_->text; }

  /// The contents of a file: the state with a checksum, the version, and the configuration.
  std::string to_bytes() const;
  /// \throws SnapshotError
  static Snapshot from_bytes(std::string_view bytes);

 private:
  report::Time time_;
  std::string configuration_, files_;
  std::shared_ptr<const state::Saved> state_;
};

}  // namespace cmrc
