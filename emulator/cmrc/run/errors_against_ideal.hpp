#pragma once
// The errors of a run against its ideal run. The ideal run is given, or made in a process of its own.
#include <memory>
#include <optional>
#include <string>

#include "cmrc/measures/measures.hpp"
#include "report/values/run_report.hpp"

namespace cmrc {

struct Config;
class ReferenceRun;
class RunEnd;

class ErrorsAgainstIdeal {
 public:
  /// \param given as the user gave it \param config as it runs
  /// \throws ConfigError if the reference is the ideal run of another configuration
  ErrorsAgainstIdeal(const Config& given, const Config& config, std::shared_ptr<const Reference> reference);
  ~ErrorsAgainstIdeal();

  /// The errors of the run are measured.
  bool measured() const;
  /// Starts the ideal run at the same time as this one.
  void begin();
  /// Results against another course of events, or a part of it, are measured again.
  void forget();
  /// The same, but a reference that was given stays.
  void measure_again();
  /// \throws ConfigError as the constructor
  void give(std::shared_ptr<const Reference> reference);
  const std::shared_ptr<const Reference>& given() const { return reference_; }

  /// The ideal run, after the end of this run.
  std::shared_ptr<const Reference> reference(const RunEnd& end);
  /// \param run this run, measured until its configured end
  std::optional<report::Errors> errors(Measured run, const RunEnd& end);
  /// Why there is no ideal run.
  const std::string& problem() const { return problem_; }

 private:
  const Config& given_;
  const Config& config_;
  std::shared_ptr<const Reference> reference_;
  std::unique_ptr<ReferenceRun> ideal_run_;
  std::string problem_;
  std::optional<report::Errors> errors_;
};

}  // namespace cmrc
