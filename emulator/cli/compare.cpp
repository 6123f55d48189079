// emulator compare: a run and its ideal run.
#include "cmrc/run/compare_with_ideal.hpp"

#include <optional>

#include "cli/options.hpp"
#include "cli/settings.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"

namespace cli {

int compare(const CompareOptions& options) {
  const cmrc::Config config = build_config(options.run);
  files_read(options.run, config).writes("--json", options.json.value_or(""));
  std::optional<io::OutputFile> file;
  if (options.json) file.emplace(*options.json);
  const io::StopBySignal signals;
  const report::Comparison comparison = cmrc::compare_with_ideal(config);
  io::print("{}", to_text(comparison));
  if (file) {
    file->stream() << to_json(comparison);
    file->commit();
  }
  return comparison.interrupted ? signals.status(success) : success;
}

}  // namespace cli
