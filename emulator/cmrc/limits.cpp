#include "cmrc/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "cmrc/child_processes.hpp"
#include "cmrc/reference_run.hpp"
#include "cmrc/simulation.hpp"
#include "io/stop.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

constexpr const char* dsps_key = "machine.dsps";

/// One point of one scan.
struct Job {
  std::size_t scan, point;
  Config config;
};

/// Runs to the first miss; where a reference is given, to the end.
std::string run(Config config, double value, const std::shared_ptr<const Reference>& reference) {
  config.run.strict = false;
  config.report.misses_max = 1;
  config.report.reference = reference ? ReferenceKind::ideal : ReferenceKind::none;
  Simulation simulation(config, reference);
  simulation.run([&](const Progress& progress) { return reference || progress.misses == 0; });
  const report::RunReport report = simulation.report();
  report::LimitPoint point;
  point.value = value;
  point.ran = true;
  point.stop_reason = name(report.stop_reason);
  for (const report::Starved& of : report.starved) point.starved += of.intervals;
  const bool whole =
      report.stop_reason == report::StopReason::completed || report.stop_reason == report::StopReason::job_done;
  point.passed = whole && report.misses() == 0 && point.starved == 0;
  if (!report.missed.empty()) {
    const report::MissReport& first = report.missed.front();
    point.first_miss = first.kind;
    point.first_miss_s = report::seconds(first.deadline.value_or(first.released));
  }
  if (report.errors) {
    const report::Demand& f_p = report.errors->rate("f_p")->all;
    const report::Demand& f_t = report.errors->rate("f_t")->all;
    const double lag = report.errors->lags.empty() ? 0 : report.errors->lags.front().end_s;
    point.cost = {f_p.realised_hz, f_t.realised_hz, f_p.missed(), f_t.missed(), report.errors->load.rms, lag};
  }
  return state::save_value(point);
}

/// The ideal runs that the jobs are measured against, one for all that may share it; the runs of a scan follow each
/// other.
std::vector<std::shared_ptr<const Reference>> references_of(const std::vector<Job>& jobs) {
  std::map<std::string, std::shared_ptr<const Reference>> by_key;
  std::vector<std::shared_ptr<const Reference>> all;
  for (const Job& job : jobs) {
    auto& reference = by_key[reference_key(job.config)];
    if (!reference) reference = ReferenceRun(job.config).wait();
    all.push_back(reference);
  }
  return all;
}

std::vector<double> sorted(std::vector<double> values, const char* grid) {
  std::ranges::sort(values);
  if (std::ranges::adjacent_find(values) != values.end()) {
    throw ConfigError(fmt::format("limits: the grid of {} has a value twice; each is run once", grid));
  }
  return values;
}

/// The configuration with one value changed and checked, or what it breaks.
std::optional<Config> with(const Config& config, std::string_view key, double value, std::string& refused) {
  const bool whole = key == dsps_key && value == std::floor(value) && std::abs(value) < 1e9;
  try {
    Config changed = with_key(config, key, whole ? Value{static_cast<std::int64_t>(value)} : Value{value}, {});
    check_events(changed);
    return changed;
  } catch (const ConfigError& error) {
    refused = error.what();
    return std::nullopt;
  }
}

}  // namespace

LimitGrids LimitGrids::standard(const Config& config) {
  LimitGrids grids;
  for (int quarters = 4; quarters <= 12; ++quarters) grids.cycles.push_back(quarters / 4.0);
  for (int dsps = 1; dsps <= 8; ++dsps) grids.dsps.push_back(dsps);
  for (std::int64_t interval = 2 * intervals(config).servo; interval >= 2; --interval) {
    grids.servo.push_back(config.rates.refresh_frequency_hz / static_cast<double>(interval));
  }
  return grids;
}

report::Limits find_limits(const Config& config, const LimitGrids& grids, bool errors,
                           const std::function<void(std::size_t, std::size_t)>& progress) {
  report::Limits limits;
  limits.duration_s = config.run.duration_s;
  std::vector<Job> jobs;
  const auto scan = [&](const char* name, const char* key, const char* meaning, bool more_is_harder,
                        const std::vector<double>& values) {
    if (values.empty()) return;
    report::LimitScan& made = limits.scans.emplace_back(report::LimitScan{name, key, meaning, more_is_harder, {}});
    for (const double value : sorted(values, name)) {
      report::LimitPoint& point = made.points.emplace_back();
      point.value = value;
      if (auto changed = with(config, key, value, point.refused))
        jobs.push_back({limits.scans.size() - 1, made.points.size() - 1, *changed});
    }
  };
  scan("cycles", "machine.cycle_time_factor", "Time of an instruction cycle, the buses as they are", true,
       grids.cycles);
  scan("dsps", dsps_key, "Number of DSPs", false, grids.dsps);
  scan("servo", "rates.servo_frequency_hz", "Servo frequency f_p in Hz", true, grids.servo);
  if (limits.scans.empty())
    throw ConfigError("limits: every grid is empty; at least one value of cycles, dsps or servo is expected");

  std::vector<std::shared_ptr<const Reference>> references(jobs.size());
  try {
    if (errors) references = references_of(jobs);
  } catch (const io::Stopped&) {
    limits.interrupted = true;
    return limits;
  }
  std::size_t ended = 0;
  const auto answers = in_processes(
      jobs.size(), processors(),
      [&](std::size_t i) {
        return run(jobs[i].config, limits.scans[jobs[i].scan].points[jobs[i].point].value, references[i]);
      },
      [&](std::size_t, const std::string&) {
        if (progress) progress(++ended, jobs.size());
      });
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (answers[i])
      limits.scans[jobs[i].scan].points[jobs[i].point] = state::load_value<report::LimitPoint>(*answers[i]);
    else
      limits.interrupted = true;
  }
  return limits;
}

}  // namespace cmrc
