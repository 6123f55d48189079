#pragma once
// The parts of a run, from the configuration to the machine: what Simulation drives.
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/host.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/measures/run_profile.hpp"
#include "cmrc/measures/run_watchers.hpp"
#include "cmrc/run/errors_against_ideal.hpp"
#include "cmrc/run/observer.hpp"
#include "cmrc/run/run_end.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/run/snapshot_origin.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/system/machine.hpp"
#include "machine/system/machine_config.hpp"
#include "plant/dock/dock.hpp"
#include "report/events/event_log.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Words on a bus are reported when their burst has ended; no report comes later than this after its time.
inline constexpr Time settling = std::chrono::milliseconds{1};

class Simulation::Parts {
 public:
  /// \param recorded takes the run's course; then the run has neither events nor causes; may be null \param reference
  /// the ideal run, if it is known
  Parts(const Config& given, std::shared_ptr<Course> recorded, std::shared_ptr<const Reference> reference);

  /// Refuses speed limits, set one after another, with which a drive trips on its way. \throws ConfigError
  void check_sets(std::span<const TimedEvent> events) const;
  /// A future event goes into the machine's script or the host's.
  void expect(const TimedEvent& event);
  /// The state of a run. The ideal run, and what was measured against it, is made again.
  void list_state(state::Visitor& list);
  /// The state was loaded.
  void measure_again();

  void run_until(Time time);
  /// Continues an interrupted run.
  void resume();
  Time now() const { return run_end.now(); }
  bool over() const { return run_end.over(); }

  Ledger::Report ledger_report() const;
  std::optional<report::Errors> measure_errors(const JobsByRobot& jobs);
  std::string files() const { return digest_of_files(given_config, image); }
  void connect_traces();

  /// \throws std::logic_error after report_so_far
  void require_more_to_come(const char* call) const;
  /// \throws std::logic_error if the run has a profile, with which this call is not possible
  void require_no_profile(const char* call) const;

  Config given_config;
  Config original_config = given_config;  // before Simulation::at has added events
  std::string snapshot_key = key_of(given_config);
  Config config;
  ErrorsAgainstIdeal ideal;
  toolchain::Image image;
  Words words;
  plant::DockConfig dock_config;
  plant::Dock dock;
  machine::Config machine_config;
  Ledger ledger;
  report::EventLog log;
  RunObserver observer;
  Host host;
  machine::Machine machine;
  RunEnd run_end;
  std::shared_ptr<Course> course;
  std::chrono::steady_clock::duration elapsed{};
  std::map<unsigned, c40::TraceSink*> traces;
  std::optional<RunProfile> profile;
  RunWatchers watchers;
  bool reported_all = false;  // the order of events is settled further than is certain
};

}  // namespace cmrc
