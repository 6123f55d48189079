#include "cmrc/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmrc/child_processes.hpp"
#include "cmrc/simulation.hpp"

namespace cmrc {
namespace {

constexpr const char* dsps_key = "machine.dsps";

/// One point of one scan; its result goes back to the parent as text: a line each.
struct Job {
  std::size_t scan, point;
  Config config;
};

std::string run(Config config) {
  config.run.strict = false;
  config.report.misses_max = 1;
  Simulation simulation(config);
  simulation.run([](const Progress& progress) { return progress.misses == 0; });
  const report::RunReport report = simulation.report();
  const bool passed = report.stop_reason == report::StopReason::completed && report.misses() == 0;
  std::string miss = "\n0";
  if (!report.missed.empty()) {
    const report::MissReport& first = report.missed.front();
    miss = fmt::format("{}\n{}", first.kind, first.deadline.value_or(first.released).count());
  }
  return fmt::format("{}\n{}\n{}", passed ? 1 : 0, name(report.stop_reason), miss);
}

void read(const std::string& answer, report::LimitPoint& point) {
  std::vector<std::string> lines(1);
  for (const char c : answer) {
    if (c == '\n') lines.emplace_back();
    else lines.back() += c;
  }
  point.passed = lines.at(0) == "1";
  point.stop_reason = lines.at(1);
  point.first_miss = lines.at(2);
  point.first_miss_s = static_cast<double>(std::stoll(lines.at(3))) * 1e-12;
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

report::Limits find_limits(const Config& config, const LimitGrids& grids, const std::function<void(std::size_t, std::size_t)>& progress) {
  report::Limits limits;
  limits.duration_s = config.run.duration_s;
  std::vector<Job> jobs;
  const auto scan = [&](const char* name, const char* key, const char* meaning, bool more_is_harder, const std::vector<double>& values) {
    if (values.empty()) return;
    report::LimitScan& made = limits.scans.emplace_back(report::LimitScan{name, key, meaning, more_is_harder, {}});
    for (const double value : sorted(values, name)) {
      report::LimitPoint& point = made.points.emplace_back();
      point.value = value;
      if (auto changed = with(config, key, value, point.refused)) jobs.push_back({limits.scans.size() - 1, made.points.size() - 1, *changed});
    }
  };
  scan("cycles", "machine.cycle_time_factor", "Time of an instruction cycle, the buses as they are", true, grids.cycles);
  scan("dsps", dsps_key, "Number of DSPs", false, grids.dsps);
  scan("servo", "rates.servo_frequency_hz", "Servo frequency f_p in Hz", true, grids.servo);
  if (limits.scans.empty()) throw ConfigError("limits: every grid is empty; at least one value of cycles, dsps or servo is expected");

  std::size_t ended = 0;
  const auto answers = in_processes(jobs.size(), processors(), [&](std::size_t i) { return run(jobs[i].config); },
                                    [&](std::size_t, const std::string&) {
                                      if (progress) progress(++ended, jobs.size());
                                    });
  for (std::size_t i = 0; i < jobs.size(); ++i) read(answers[i], limits.scans[jobs[i].scan].points[jobs[i].point]);
  return limits;
}

}  // namespace cmrc
