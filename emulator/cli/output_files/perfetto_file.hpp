#pragma once
// --perfetto: the file, and the recorder that writes the file during the run.
#include <optional>

#include "cli/arguments/options.hpp"
#include "cli/output_files/timeline_file.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/timelines/perfetto_recorder.hpp"
#include "report/events/trace_text.hpp"

namespace cli {

/// The values of --perfetto-detail and --perfetto-window.
struct PerfettoRequest {
  std::string file;
  cmrc::PerfettoDetail detail = cmrc::PerfettoDetail::tasks;
  report::Window window{};
};

/// Nothing without --perfetto. \throws InputError if the options contradict each other or the run
std::optional<PerfettoRequest> perfetto_request(const RunOptions& options, const cmrc::Config& config);

class PerfettoFile {
 public:
  /// \throws io::CannotOpen
  explicit PerfettoFile(const PerfettoRequest& request);
  /// To be called before the run, or after restore().
  void record(cmrc::Simulation& simulation);
  /// Completes the file and puts it in its place. To be called after Simulation::report_so_far().
  void finish();

 private:
  const PerfettoRequest request_;
  TimelineFile file_;
  std::optional<cmrc::PerfettoRecorder> recorder_;
};

}  // namespace cli
