// emulator without a command: simulates the dock.
#include <optional>

#include "cli/arguments/options.hpp"
#include "cli/arguments/settings.hpp"
#include "cli/debug/attach.hpp"
#include "cli/output_files/progress_line.hpp"
#include "cli/output_files/run_outputs.hpp"
#include "cli/output_files/snapshots.hpp"
#include "cmrc/run/simulation.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "report/events/event.hpp"

namespace cli {

int run(const RunOptions& options) {
  const std::optional<cmrc::Snapshot> resumed =
      options.resume ? std::optional(read_snapshot(*options.resume)) : std::nullopt;
  // Flags may repeat values of the snapshot. A flag that changes a value is refused when the run is restored.
  const cmrc::Config config =
      resumed ? build_config(options, resumed->configuration(), *options.resume) : build_config(options);
  RunOutputs outputs(options, config);
  cmrc::Simulation simulation(config);
  if (resumed) resume(simulation, *resumed, *options.resume, outputs.snapshots().left());
  outputs.attach(simulation);

  Attach attach(options);
  bool goes_on = attach.begin(simulation);
  const io::StopBySignal signals;
  const report::RunReport report = [&] {
    ProgressLine line(report::from_seconds(config.run.duration_s), !options.quiet);
    const auto show = [&](const cmrc::Progress& progress) {
      line.show(progress.simulated, progress.misses);
      return goes_on && !attach.wanted();
    };
    for (;;) {
      outputs.snapshots().run(simulation, show);
      if (outputs.snapshots().left().empty() || simulation.ended() || !goes_on) simulation.run(show);
      if (!goes_on || simulation.ended() || io::stop_asked() || !attach.wanted()) break;
      goes_on = attach.serve(simulation);
    }
    if (config.report.reference == cmrc::ReferenceKind::ideal && !config.run.ideal)
      line.show("the run is over; its ideal run is waited for");
    return simulation.report_so_far();
  }();
  outputs.write(report, simulation);
  if (simulation.interrupted()) return signals.status(success);
  const auto missed = outputs.snapshots().left();
  for (const SnapshotRequest& snapshot : missed)
    io::print(stderr, "--snapshot-at: {} is not written; the run ended at {} s, before {} s\n", snapshot.file,
              report::seconds(simulation.time()), report::seconds(snapshot.at));
  return missed.empty() ? simulation.exit_status() : run_failed;
}

}  // namespace cli
