#include "cli/output_files/run_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>
#include <filesystem>
#include <ostream>

#include "c40/values/types.hpp"
#include "cli/arguments/settings.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "io/file_roles.hpp"
#include "io/print.hpp"
#include "io/reason.hpp"
#include "machine/system/machine.hpp"
#include "page/html.hpp"

namespace cli {
namespace {

using report::Time;

std::string instruction_file(const RunOptions& options, unsigned slot) {
  return fmt::format("{}.dsp{}", *options.trace, slot);
}

void check_options(const RunOptions& options, const cmrc::Config& config) {
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

report::Window trace_window(const RunOptions& options, const cmrc::Config& config) {
  const report::Window window =
      options.trace_window ? parse_window("--trace-window", *options.trace_window) : report::Window{};
  if (report::seconds(window.from) >= config.run.duration_s)
    throw InputError(fmt::format("--trace-window: it begins at {} s, and the run ends at {} s",
                                 report::seconds(window.from), config.run.duration_s));
  return window;
}

/// The title of the page: configuration file, DSPs and load.
std::string page_title(const RunOptions& options, const cmrc::Config& config) {
  const std::string name =
      options.config ? std::filesystem::path(*options.config).stem().string() : options.preset.value_or("base");
  return fmt::format("{}: {} DSP{}, {:g} s", io::printable(name), config.machine.dsps,
                     config.machine.dsps == 1 ? "" : "s", config.run.duration_s);
}

/// Makes one output. An error in it loses this output, and not the others.
template <class Make>
void alone(const std::string& name, const Make& make) {
  try {
    make();
  } catch (const std::exception& error) {
    io::note_lost(fmt::format("{}: not written: {}", name, io::reason(error)));
  }
}

}  // namespace

RunOutputs::RunOutputs(const RunOptions& options, const cmrc::Config& config)
    : options_(options), page_title_(page_title(options, config)) {
  check_options(options, config);
  const std::optional<PerfettoRequest> timeline = perfetto_request(options, config);
  std::vector<SnapshotRequest> snapshots = snapshot_requests(options, config);
  struct Row {
    const char* option;
    const std::optional<std::string>& name;
    std::optional<io::OutputFile>& file;
  };
  const auto profile = options.profile == "" ? std::nullopt : options.profile;  // empty: on the terminal
  const std::array<Row, 4> rows{{{"--report", options.report, report_},
                                 {"--page", options.page, page_},
                                 {"--profile", profile, profile_},
                                 {"--trace", options.trace, trace_}}};
  io::FileRoles files = files_read(options, config);
  files.reads("--resume", options.resume.value_or(""));
  for (const SnapshotRequest& snapshot : snapshots) files.writes("--snapshot-at", snapshot.file);
  for (const Row& row : rows) files.writes(row.option, row.name.value_or(""));
  files.writes("--perfetto", options.perfetto.value_or(""));
  for (const unsigned slot : options.trace_instructions)
    files.writes("--trace-instructions", instruction_file(options, slot));
  trace_window_ = trace_window(options, config);

  snapshots_.emplace(std::move(snapshots));
  for (const Row& row : rows)
    if (row.name) row.file.emplace(*row.name);
  if (timeline) perfetto_.emplace(*timeline);
  for (const unsigned slot : options.trace_instructions)
    instructions_.push_back(std::make_unique<io::OutputFile>(instruction_file(options, slot)));
}

void RunOutputs::attach(cmrc::Simulation& simulation) {
  if (trace_) simulation.listen(events_.emplace(trace_->stream(), trace_window_));
  if (options_.profile) simulation.profile();
  for (std::size_t i = 0; i < instructions_.size(); ++i) {
    std::ostream& out = instructions_[i]->stream();
    out << (options_.trace_labels ? report::labelled_trace_header : report::instruction_trace_header) << '\n';
    const unsigned slot = options_.trace_instructions[i];
    instruction_texts_.push_back(std::make_unique<machine::InstructionText>(
        slot, [&out](const std::string& line) { out << line << '\n'; },
        [&machine = simulation.machine(), slot, window = trace_window_](c40::Cycles cycle) {
          return window.contains(machine.time_of(slot, cycle));
        },
        options_.trace_labels ? std::optional(machine::Labels::of_dock(simulation.image())) : std::nullopt));
    simulation.trace(slot, *instruction_texts_.back());
  }
  if (perfetto_) perfetto_->record(simulation);
  if (page_) page_recorder_.emplace(simulation);
}

void RunOutputs::write(const report::RunReport& report, const cmrc::Simulation& simulation) {
  if (report_) {
    report_->stream() << to_json(report);
    report_->commit_or_note();
  }
  if (page_) {
    alone(*options_.page, [&] {
      page_->stream() << page::html(page_recorder_->recording(report, page_title_), page_title_);
      page_->commit_or_note();
    });
  }
  if (trace_) trace_->commit_or_note();
  if (perfetto_) alone(*options_.perfetto, [&] { perfetto_->finish(); });
  for (const auto& file : instructions_) file->commit_or_note();
  if (!options_.quiet) io::print("{}", to_text(report));
  if (options_.profile) {
    alone(profile_ ? *options_.profile : "--profile", [&] {
      const report::Profile profile = simulation.profile_report();
      if (!profile_) return io::print("{}", to_text(profile));
      profile_->stream() << (options_.profile->ends_with(".json") ? to_json(profile) : to_text(profile));
      profile_->commit_or_note();
    });
  }
  if (options_.trace_window && trace_window_.from > simulation.time())
    io::print(stderr, "--trace-window: {} has no events; the run ended at {} s, before {} s\n", *options_.trace,
              report::seconds(simulation.time()), report::seconds(trace_window_.from));
}

}  // namespace cli
