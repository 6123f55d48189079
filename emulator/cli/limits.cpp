// emulator limits and emulator compare: what is derived from several runs.
#include "cmrc/limits.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "cli/grid.hpp"
#include "cli/options.hpp"
#include "cli/settings.hpp"
#include "cmrc/compare.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"

namespace cli {

int limits(const LimitsOptions& options) {
  const cmrc::Config config = build_config(options.run);
  cmrc::LimitGrids grids;
  if (options.cycles) grids.cycles = parse_grid(*options.cycles, "--cycles");
  if (options.dsps) grids.dsps = parse_grid(*options.dsps, "--dsps-grid");
  if (options.servo) grids.servo = parse_grid(*options.servo, "--servo");
  if (!options.cycles && !options.dsps && !options.servo) grids = cmrc::LimitGrids::standard(config);
  files_read(options.run, config).writes("--json", options.json.value_or(""));
  std::optional<io::OutputFile> file;
  if (options.json) file.emplace(*options.json);
  const io::StopBySignal signals;
  const bool line = ::isatty(STDERR_FILENO) == 1;
  const report::Limits limits =
      cmrc::find_limits(config, grids, options.errors, [line](std::size_t done, std::size_t points) {
        fmt::print(stderr, "{}{} of {} runs done{}", line ? "\r" : "", done, points, line && done < points ? "" : "\n");
        std::fflush(stderr);
      });
  io::print("{}", to_text(limits));
  if (file) {
    file->stream() << to_json(limits);
    file->commit();
  }
  return limits.interrupted ? signals.status(success) : success;
}

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
