#pragma once
// The ideal run against which a run is measured, in a process of its own.
#include <memory>
#include <string>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/measures.hpp"

namespace io {
class ChildProcess;
}

namespace cmrc {

/// The configuration of a run's ideal run: the same for every number of DSPs, so that one ideal run can serve them all.
Config reference_of(Config config);
/// A text that is equal for two configurations if one ideal run serves both.
std::string reference_key(const Config& config);

class ReferenceRun {
 public:
  /// Starts the ideal run of `config` for its whole duration. \throws std::runtime_error without memory or process
  explicit ReferenceRun(const Config& config);
  ~ReferenceRun();
  ReferenceRun(const ReferenceRun&) = delete;
  ReferenceRun& operator=(const ReferenceRun&) = delete;

  /// Waits for its end. \throws std::runtime_error if it has died; io::Stopped, and may then be called again
  std::shared_ptr<const Reference> wait();
  /// Ends it early: no more is needed than up to `time`, or up to what is ready within a moment.
  std::shared_ptr<const Reference> cut_short(Time time);

 private:
  struct Shared;
  std::shared_ptr<Reference> reference_;
  std::unique_ptr<Shared> shared_;
  std::unique_ptr<io::ChildProcess> child_;
};

}  // namespace cmrc
