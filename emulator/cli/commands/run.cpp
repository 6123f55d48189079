// emulator without a command: simulates the dock.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <span>

#include "c40/chip/chip.hpp"
#include "cli/arguments/options.hpp"
#include "cli/arguments/settings.hpp"
#include "cli/debug/attach.hpp"
#include "cli/output_files/perfetto_file.hpp"
#include "cli/output_files/progress_line.hpp"
#include "cli/output_files/snapshots.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/simulation.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "machine/program_text/instruction_trace.hpp"
#include "machine/system/machine.hpp"
#include "page/html.hpp"
#include "page/recorder.hpp"
#include "report/event.hpp"
#include "report/trace_text.hpp"

namespace cli {
namespace {

using report::Time;

std::string instruction_file(const RunOptions& options, unsigned slot) {
  return fmt::format("{}.dsp{}", *options.trace, slot);
}

/// The files for the instructions of the chosen DSPs.
class InstructionFiles {
 public:
  InstructionFiles(const RunOptions& options, report::Window window, cmrc::Simulation& simulation) {
    const machine::Clock& clock = simulation.machine().chip_clock();
    const c40::Cycles from = clock.tick_at_or_after(window.from);
    const c40::Cycles to =
        window.to == Time::max() ? std::numeric_limits<c40::Cycles>::max() : clock.tick_at_or_after(window.to);
    for (const unsigned slot : options.trace_instructions) {
      auto file = std::make_unique<io::OutputFile>(instruction_file(options, slot));
      std::ostream& out = file->stream();
      out << (options.trace_labels ? report::labelled_trace_header : report::instruction_trace_header) << '\n';
      sinks_.push_back(std::make_unique<machine::InstructionText>(
          slot, [&out](const std::string& line) { out << line << '\n'; }, from, to,
          options.trace_labels ? std::optional(machine::Labels::of_dock(simulation.image())) : std::nullopt));
      simulation.trace(slot, *sinks_.back());
      files_.push_back(std::move(file));
    }
  }
  void finish() {
    for (const auto& file : files_) file->commit_or_note();
  }

 private:
  std::vector<std::unique_ptr<io::OutputFile>> files_;
  std::vector<std::unique_ptr<machine::InstructionText>> sinks_;
};

void check(const RunOptions& options, const cmrc::Config& config) {
  if (options.quiet && options.profile && options.profile->empty())
    throw InputError("--profile: with --quiet a file is needed, --profile FILE");
  if (options.trace_window && !options.trace) throw InputError("--trace-window: needs --trace FILE");
  if (!options.trace_instructions.empty() && !options.trace)
    throw InputError("--trace-instructions: needs --trace FILE");
  if (options.trace_labels && options.trace_instructions.empty())
    throw InputError("--trace-labels: needs --trace-instructions N, the DSP whose instructions it is about");
  const auto machine = cmrc::as_run(config).machine;  // an ideal run has one DSP
  const auto slots = std::max(machine.dsps, machine.slots);
  for (const unsigned slot : options.trace_instructions)
    if (slot >= slots)
      throw InputError(fmt::format("--trace-instructions: there is no DSP {}; 0 to {} are possible", slot, slots - 1));
  if (options.profile && (options.resume || !options.snapshots.empty()))
    throw InputError(
        "--profile: a run with a profile has no snapshots; leave out --profile, or --resume and --snapshot-at");
}

void resume(cmrc::Simulation& simulation, const cmrc::Snapshot& snapshot, const std::string& file,
            const std::vector<SnapshotRequest>& requests) {
  if (!requests.empty() && requests.front().at < snapshot.time())
    throw InputError(fmt::format("--snapshot-at: {} s has passed; {} continues from {} s",
                                 report::seconds(requests.front().at), file, report::seconds(snapshot.time())));
  try {
    simulation.restore(snapshot);
  } catch (const cmrc::SnapshotError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

/// The title of the page: configuration file, DSPs and load.
std::string page_title(const RunOptions& options, const cmrc::Config& config) {
  const std::string name =
      options.config ? std::filesystem::path(*options.config).stem().string() : options.preset.value_or("base");
  return fmt::format("{}: {} DSP{}, {:g} s", io::printable(name), config.machine.dsps,
                     config.machine.dsps == 1 ? "" : "s", config.run.duration_s);
}

/// The files of --snapshot-at: a name that cannot be written is refused before the run.
class SnapshotFiles {
 public:
  explicit SnapshotFiles(std::span<const SnapshotRequest> requests) : requests_(requests) {
    for (const SnapshotRequest& request : requests) files_.push_back(std::make_unique<io::OutputFile>(request.file));
  }
  /// Runs to each snapshot that is left, until the run ends.
  void run(cmrc::Simulation& simulation, const std::function<bool(const cmrc::Progress&)>& show) {
    for (; !left().empty(); ++reached_) {
      const report::Time at = left().front().at;
      simulation.run(show, cmrc::Simulation::usual_slice, at);
      if (simulation.time() != at) return;
      files_[reached_]->stream() << simulation.snapshot().to_bytes();
      files_[reached_]->commit_or_note();
    }
  }
  std::span<const SnapshotRequest> left() const { return requests_.subspan(reached_); }

 private:
  std::span<const SnapshotRequest> requests_;
  std::vector<std::unique_ptr<io::OutputFile>> files_;
  std::size_t reached_ = 0;
};

}  // namespace

int run(const RunOptions& options) {
  const std::optional<cmrc::Snapshot> resumed =
      options.resume ? std::optional(read_snapshot(*options.resume)) : std::nullopt;
  // Flags may repeat values of the snapshot. A flag that changes a value is refused when the run is restored.
  const cmrc::Config config =
      resumed ? build_config(options, resumed->configuration(), *options.resume) : build_config(options);
  check(options, config);
  const std::optional<PerfettoRequest> timeline = perfetto_request(options, config);
  const std::vector<SnapshotRequest> snapshots = snapshot_requests(options, config);
  io::FileRoles files = files_read(options, config);
  files.reads("--resume", options.resume.value_or(""));
  for (const SnapshotRequest& snapshot : snapshots) files.writes("--snapshot-at", snapshot.file);
  files.writes("--report", options.report.value_or(""))
      .writes("--page", options.page.value_or(""))
      .writes("--profile", options.profile.value_or(""))
      .writes("--trace", options.trace.value_or(""))
      .writes("--perfetto", options.perfetto.value_or(""));
  for (const unsigned slot : options.trace_instructions)
    files.writes("--trace-instructions", instruction_file(options, slot));
  const report::Window window =
      options.trace_window ? parse_window("--trace-window", *options.trace_window) : report::Window{};
  if (report::seconds(window.from) >= config.run.duration_s)
    throw InputError(fmt::format("--trace-window: it begins at {} s, and the run ends at {} s",
                                 report::seconds(window.from), config.run.duration_s));

  SnapshotFiles snapshot_files(snapshots);
  std::optional<io::OutputFile> report_file;
  if (options.report) report_file.emplace(*options.report);
  std::optional<io::OutputFile> profile_file;
  if (options.profile && !options.profile->empty()) profile_file.emplace(*options.profile);
  std::optional<PerfettoFile> perfetto;
  if (timeline) perfetto.emplace(*timeline);
  std::optional<io::OutputFile> page_file;
  if (options.page) page_file.emplace(*options.page);
  std::optional<io::OutputFile> trace_file;
  std::optional<report::EventTextTrace> trace;
  if (options.trace) {
    trace_file.emplace(*options.trace);
    trace.emplace(trace_file->stream(), window);
  }

  cmrc::Simulation simulation(config);
  if (trace) simulation.listen(*trace);
  if (options.profile) simulation.profile();
  InstructionFiles instructions(options, window, simulation);
  if (resumed) resume(simulation, *resumed, *options.resume, snapshots);
  if (perfetto) perfetto->record(simulation);

  std::optional<page::Recorder> recorder;
  if (page_file) recorder.emplace(simulation);

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
      snapshot_files.run(simulation, show);
      if (snapshot_files.left().empty() || simulation.ended() || !goes_on) simulation.run(show);
      if (!goes_on || simulation.ended() || io::stop_asked() || !attach.wanted()) break;
      goes_on = attach.serve(simulation);
    }
    if (config.report.reference == cmrc::ReferenceKind::ideal && !config.run.ideal)
      line.show("the run is over; its ideal run is waited for");
    return simulation.report_so_far();
  }();
  if (report_file) {
    report_file->stream() << to_json(report);
    report_file->commit_or_note();
  }
  if (page_file) {
    const std::string title = page_title(options, config);
    page_file->stream() << page::html(recorder->recording(report, title), title);
    page_file->commit_or_note();
  }
  if (trace_file) trace_file->commit_or_note();
  if (perfetto) perfetto->finish();
  instructions.finish();
  if (!options.quiet) io::print("{}", to_text(report));
  if (options.profile) {
    const report::Profile profile = simulation.profile_report();
    if (!profile_file) {
      io::print("{}", to_text(profile));
    } else {
      profile_file->stream() << (options.profile->ends_with(".json") ? to_json(profile) : to_text(profile));
      profile_file->commit_or_note();
    }
  }
  if (options.trace_window && window.from > simulation.time())
    io::print(stderr, "--trace-window: {} has no events; the run ended at {} s, before {} s\n", *options.trace,
              report::seconds(simulation.time()), report::seconds(window.from));
  if (simulation.interrupted()) return signals.status(success);
  for (const SnapshotRequest& missed : snapshot_files.left())
    io::print(stderr, "--snapshot-at: {} is not written; the run ended at {} s, before {} s\n", missed.file,
              report::seconds(simulation.time()), report::seconds(missed.at));
  return snapshot_files.left().empty() ? simulation.exit_status() : run_failed;
}

}  // namespace cli
