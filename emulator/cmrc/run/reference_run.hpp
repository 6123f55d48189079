#pragma once
// The ideal run that a run is measured against, in a process beside it.
#include <memory>
#include <string>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/measures.hpp"

namespace io {
class ChildProcess;
}

namespace cmrc {

/// The configuration of a run's ideal run: the same for every number of DSPs, so that one may serve them all.
Config reference_of(Config config);
/// Text that two configurations share if one ideal run serves both.
std::string reference_key(const Config& config);

class ReferenceRun {
 public:
  /// Starts the ideal run of `config`, to its whole duration. \throws std::runtime_error without memory or process
  explicit ReferenceRun(const Config& config);
  ~ReferenceRun();
  ReferenceRun(const ReferenceRun&) = delete;
  ReferenceRun& operator=(const ReferenceRun&) = delete;

  /// Waits for its end. \throws std::runtime_error when it has died; io::Stopped, and may be called again
  std::shared_ptr<const Reference> wait();
  /// No more of it is wanted than up to `time`, nor more than comes within a moment.
  std::shared_ptr<const Reference> cut_short(Time time);

 private:
  struct Shared;
  std::shared_ptr<Reference> reference_;
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<io::ChildProcess> child_;
};

}  // namespace cmrc
