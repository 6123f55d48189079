#include "cli/output_files/snapshots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "cli/arguments/settings.hpp"
#include "io/input_file.hpp"
#include "report/events/event.hpp"

namespace cli {
namespace {

SnapshotRequest parsed(const std::string& text, double duration_s) {
  const std::size_t colon = text.find(':');
  const std::optional<report::Time> at =
      colon == std::string::npos ? std::nullopt : parse_seconds(std::string_view(text).substr(0, colon));
  if (!at || colon + 1 == text.size())
    throw InputError(fmt::format("--snapshot-at: \"{}\" is not S:FILE, seconds and a file", text));
  if (*at > report::from_seconds(duration_s))
    throw InputError(fmt::format("--snapshot-at: {} s is after the end of the run; it ends at {} s",
                                 report::seconds(*at), duration_s));
  return {*at, text.substr(colon + 1)};
}

}  // namespace

std::vector<SnapshotRequest> snapshot_requests(const RunOptions& options, const cmrc::Config& config) {
  std::vector<SnapshotRequest> all;
  for (const std::string& text : options.snapshots) all.push_back(parsed(text, config.run.duration_s));
  std::ranges::stable_sort(all, {}, &SnapshotRequest::at);
  return all;
}

SnapshotFiles::SnapshotFiles(std::vector<SnapshotRequest> requests) : requests_(std::move(requests)) {
  for (const SnapshotRequest& request : requests_) files_.push_back(std::make_unique<io::OutputFile>(request.file));
}

void SnapshotFiles::run(cmrc::Simulation& simulation, const std::function<bool(const cmrc::Progress&)>& show) {
  for (; !left().empty(); ++reached_) {
    const report::Time at = left().front().at;
    simulation.run(show, cmrc::Simulation::usual_slice, at);
    if (simulation.time() != at) return;
    files_[reached_]->stream() << simulation.snapshot().to_bytes();
    files_[reached_]->commit_or_note();
  }
}

cmrc::Snapshot read_snapshot(const std::string& file) {
  // 16 chips with the most memory of a board, and the plant.
  constexpr std::size_t largest_snapshot = std::size_t{4} << 30;
  std::error_code unreadable;
  const bool has_an_end = std::filesystem::is_regular_file(file, unreadable);
  const std::string bytes =
      io::read_file<InputError>(file, "a snapshot (--snapshot-at)", has_an_end ? largest_snapshot : io::largest_input);
  try {
    return cmrc::Snapshot::from_bytes(bytes);
  } catch (const cmrc::SnapshotError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

void resume(cmrc::Simulation& simulation, const cmrc::Snapshot& snapshot, const std::string& file,
            std::span<const SnapshotRequest> requests) {
  if (!requests.empty() && requests.front().at < snapshot.time())
    throw InputError(fmt::format("--snapshot-at: {} s has passed; {} continues from {} s",
                                 report::seconds(requests.front().at), file, report::seconds(snapshot.time())));
  try {
    simulation.restore(snapshot);
  } catch (const cmrc::SnapshotError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
}

}  // namespace cli
