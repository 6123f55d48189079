#pragma once
// --perfetto: the file, and the recorder that writes it while the run goes on.
#include <memory>
#include <optional>

#include "cli/options.hpp"
#include "cli/timeline_file.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/timelines/perfetto_recorder.hpp"
#include "report/trace_text.hpp"

namespace cli {

/// What --perfetto-detail and --perfetto-window ask for.
struct PerfettoRequest {
  std::string file;
  cmrc::PerfettoDetail detail = cmrc::PerfettoDetail::tasks;
  report::Window window{};
};

/// None without --perfetto. \throws InputError when the options contradict each other or the run
std::optional<PerfettoRequest> perfetto_request(const RunOptions& options, const cmrc::Config& config);

class PerfettoFile {
 public:
  /// \throws io::CannotOpen
  explicit PerfettoFile(const PerfettoRequest& request);
  /// Before the run, or after restore().
  void record(cmrc::Simulation& simulation);
  /// The file is whole, and takes its place. After Simulation::report_so_far().
  void commit();

 private:
  const PerfettoRequest request_;
  TimelineFile file_;
  std::optional<cmrc::PerfettoRecorder> recorder_;
};

}  // namespace cli
