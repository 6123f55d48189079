#include "cmrc/run/errors_against_ideal.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "cmrc/configuration/config.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/reference_run.hpp"
#include "cmrc/run/run_end.hpp"
#include "io/stop.hpp"

namespace cmrc {

ErrorsAgainstIdeal::ErrorsAgainstIdeal(const Config& given, const Config& config,
                                       std::shared_ptr<const Reference> reference)
    : given_(given), config_(config) {
  if (reference) give(std::move(reference));
}

ErrorsAgainstIdeal::~ErrorsAgainstIdeal() = default;

bool ErrorsAgainstIdeal::measured() const { return config_.report.reference == ReferenceKind::ideal; }

void ErrorsAgainstIdeal::begin() {
  if (!measured() || config_.run.ideal || reference_ || ideal_run_) return;
  ideal_run_ = std::make_unique<ReferenceRun>(given_);
}

void ErrorsAgainstIdeal::forget() {
  reference_.reset();
  measure_again();
}

void ErrorsAgainstIdeal::measure_again() {
  ideal_run_.reset();
  problem_.clear();
  errors_.reset();
}

void ErrorsAgainstIdeal::give(std::shared_ptr<const Reference> reference) {
  if (reference->key != reference_key(given_))
    throw ConfigError(
        "reference: it is the ideal run of another configuration; only DSPs, their speed and failures may differ");
  reference_ = std::move(reference);
}

std::shared_ptr<const Reference> ErrorsAgainstIdeal::reference(const RunEnd& end) {
  if (!measured() || config_.run.ideal || (!end.over() && !end.interrupted())) return nullptr;
  if (!ideal_run_ && !reference_ && problem_.empty()) ideal_run_ = std::make_unique<ReferenceRun>(given_);
  if (!reference_ && problem_.empty()) {
    try {
      reference_ = end.interrupted() ? ideal_run_->cut_short(end.now()) : ideal_run_->wait();
    } catch (const io::Stopped&) {
      throw;
    } catch (const std::runtime_error& error) {
      problem_ = error.what();
    }
  }
  ideal_run_.reset();
  return reference_;
}

std::optional<report::Errors> ErrorsAgainstIdeal::errors(Measured run, const RunEnd& end) {
  if (errors_) return errors_;
  const auto ideal = reference(end);
  if (!ideal && !(config_.run.ideal && measured())) return std::nullopt;
  const Course& meant = ideal ? ideal->course : run.course;
  const JobsByRobot& demanded = ideal ? ideal->jobs : run.jobs;
  run.to = end.interrupted() || config_.run.ideal ? end.now() : end.end();
  if (end.interrupted())
    run.to = std::min(run.to, meant.end() + meant.step());  // the last row is valid until the next one would come
  if (end.stop() == report::StopReason::job_done && meant.size() > 0)
    run.to = std::min(end.end(), std::max(end.now(), meant.end()));
  report::Errors made = measure(run, meant, demanded);
  if (ideal) made.reference_elapsed_s = ideal->elapsed_s;
  if (end.over() && !end.interrupted()) errors_ = made;
  return made;
}

}  // namespace cmrc
