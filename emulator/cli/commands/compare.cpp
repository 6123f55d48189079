// emulator compare: a run and its ideal run.
#include "cmrc/run/compare_with_ideal.hpp"

#include <optional>

#include "cli/arguments/options.hpp"
#include "cli/arguments/settings.hpp"
#include "cli/output_files/progress_line.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "report/events/event.hpp"

namespace cli {

int compare(const CompareOptions& options) {
  const cmrc::Config config = build_config(options.run);
  files_read(options.run, config).writes("--json", options.json.value_or(""));
  std::optional<io::OutputFile> file;
  if (options.json) file.emplace(*options.json);
  const io::StopBySignal signals;
  const report::Comparison comparison = [&] {
    ProgressLine line(report::from_seconds(config.run.duration_s), true);
    return cmrc::compare_with_ideal(config, [&](const cmrc::Progress& progress) {
      line.show(progress.simulated, progress.misses);
      return true;
    });
  }();
  io::print("{}", to_text(comparison));
  if (file) {
    file->stream() << to_json(comparison);
    file->commit_or_note();
  }
  return comparison.interrupted ? signals.status(success) : success;
}

}  // namespace cli
