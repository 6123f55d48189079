#pragma once
// Makes the report from the parts of a run.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/host.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/run/observer.hpp"
#include "machine/system/machine.hpp"
#include "plant/dock/dock.hpp"
#include "report/events/event_log.hpp"
#include "report/values/run_report.hpp"

namespace cmrc {

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
