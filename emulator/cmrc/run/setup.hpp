#pragma once
// Makes the parts of a run from the configuration, and the report from the parts.
#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/host.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/processes/crane_steps.hpp"
#include "cmrc/processes/fleet.hpp"
#include "cmrc/run/observer.hpp"
#include "machine/system/machine.hpp"
#include "plant/dock/dock.hpp"
#include "report/event_log.hpp"
#include "report/run_report.hpp"

namespace cmrc {

plant::DockConfig nominal_dock_of(const Config& config);
/// With clock deviations if run.phase_jitter is set (clock_deviations.hpp).
/// \param image and `words` of the DSPs' program
/// \throws ConfigError for a dock that cannot be, or in which the controller cannot do its job (dock_job.hpp)
plant::DockConfig dock_of(const Config& config, const toolchain::Image& image, const Words& words);
/// \param dock at power-on
CraneJob crane_of(const Config& config, const plant::DockConfig& layout, plant::Dock& dock);
FleetJob fleet_of(const Config& config, const plant::DockConfig& dock, const Words& words);
/// \throws machine::BoardError
machine::Config machine_of(const Config& config);
machine::Config nominal_machine_of(const Config& config);

/// A word of a job area that the operator loads before the start.
struct AreaWord {
  Word offset;
  Word value;
};
std::vector<AreaWord> initial_words(const Config& config, const plant::DockConfig& layout, const Words& words,
                                    plant::Dock& dock);

/// Everything from which a report is made.
struct ReportInputs {
  const Config& config;
  const machine::Machine& machine;
  const plant::Dock& dock;
  const plant::DockConfig& layout;
  const Host& host;
  const Ledger& ledger;
  const RunObserver& observer;
  const report::EventLog& log;
  report::StopReason stop;
  std::chrono::steady_clock::duration elapsed;
  std::vector<std::string> causes;
  Ledger::Report account;
  const Course& course;
  std::optional<report::Errors> errors;
  std::string reference_problem;
  std::optional<Time> account_end;             ///< from this time on no drive worked any more
  std::function<std::string(Word)> kind_name;  ///< the name of a KIND_*
};
report::RunReport make_report(ReportInputs evidence);

}  // namespace cmrc
