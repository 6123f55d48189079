#pragma once
// The outputs of a run of the dock: the files that its options name, and what goes to the terminal.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments/options.hpp"
#include "cli/output_files/perfetto_file.hpp"
#include "cli/output_files/snapshots.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/run/simulation.hpp"
#include "io/output_file.hpp"
#include "machine/program_text/instruction_trace.hpp"
#include "page/recorder.hpp"
#include "report/events/trace_text.hpp"
#include "report/values/run_report.hpp"

namespace cli {

class RunOutputs {
 public:
  /// Opens every file. \throws InputError if the options contradict each other or the run; io::SameFile;
  /// io::CannotOpen
  RunOutputs(const RunOptions& options, const cmrc::Config& config);

  SnapshotFiles& snapshots() { return *snapshots_; }
  /// To be called before the run, or after restore().
  void attach(cmrc::Simulation& simulation);
  /// Everything but the snapshots. To be called after Simulation::report_so_far().
  void write(const report::RunReport& report, const cmrc::Simulation& simulation);

 private:
  const RunOptions& options_;
  std::string page_title_;
  report::Window trace_window_;
  std::optional<SnapshotFiles> snapshots_;
  std::optional<io::OutputFile> report_, page_, profile_, trace_;
  std::optional<PerfettoFile> perfetto_;
  std::vector<std::unique_ptr<io::OutputFile>> instructions_;  // of the DSPs of --trace-instructions

  // What fills the files during the run.
  std::optional<page::Recorder> page_recorder_;
  std::optional<report::EventTextTrace> events_;
  std::vector<std::unique_ptr<machine::InstructionText>> instruction_texts_;
};

}  // namespace cli
