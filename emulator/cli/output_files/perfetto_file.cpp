#include "cli/output_files/perfetto_file.hpp"

#include <fmt/format.h>

#include "cli/arguments/settings.hpp"

namespace cli {
namespace {

cmrc::PerfettoDetail parse_detail(const std::string& text) {
  if (text == "tasks") return cmrc::PerfettoDetail::tasks;
  if (text == "bus") return cmrc::PerfettoDetail::bus;
  if (text == "all") return cmrc::PerfettoDetail::all;
  throw InputError(fmt::format("--perfetto-detail: \"{}\" is unknown; tasks, bus or all is expected", text));
}

}  // namespace

std::optional<PerfettoRequest> perfetto_request(const RunOptions& options, const cmrc::Config& config) {
  if (!options.perfetto) {
    if (options.perfetto_detail) throw InputError("--perfetto-detail: needs --perfetto FILE");
    if (options.perfetto_window) throw InputError("--perfetto-window: needs --perfetto FILE");
    return std::nullopt;
  }
  PerfettoRequest request{.file = *options.perfetto};
  if (options.perfetto_detail) request.detail = parse_detail(*options.perfetto_detail);
  if (options.perfetto_window) {
    request.window = parse_window("--perfetto-window", *options.perfetto_window);
    if (report::seconds(request.window.from) >= config.run.duration_s)
      throw InputError(fmt::format("--perfetto-window: it begins at {} s, and the run ends at {} s",
                                   report::seconds(request.window.from), config.run.duration_s));
  } else if (request.detail != cmrc::PerfettoDetail::tasks) {
    throw InputError(
        fmt::format("--perfetto-detail {}: a second has 200,000 bus transactions; choose a part with --perfetto-window "
                    "A:B, in simulated seconds, e.g. 2:2.1",
                    *options.perfetto_detail));
  }
  return request;
}

PerfettoFile::PerfettoFile(const PerfettoRequest& request) : request_(request), file_(request.file) {}

void PerfettoFile::record(cmrc::Simulation& simulation) {
  recorder_.emplace(simulation, file_.stream(), request_.detail, request_.window);
}

void PerfettoFile::finish() {
  recorder_->finish();
  file_.finish();
}

}  // namespace cli
