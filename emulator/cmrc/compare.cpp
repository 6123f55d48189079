#include "cmrc/compare.hpp"

#include <cstring>
#include <limits>
#include <stdexcept>

#include "cmrc/child_processes.hpp"
#include "cmrc/ideal.hpp"
#include "cmrc/simulation.hpp"

namespace cmrc {
namespace {

std::vector<report::Metric> metrics_of(const Config& config) {
  Simulation simulation(config);
  simulation.run();
  return metrics(simulation.report());
}

/// Values as bytes, in the order of the metrics; NaN: none.
std::string packed(const std::vector<report::Metric>& metrics) {
  std::string bytes;
  for (const report::Metric& metric : metrics) {
    const double value = metric.value.value_or(std::numeric_limits<double>::quiet_NaN());
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

std::optional<double> unpacked(const std::string& bytes, std::size_t index) {
  double value = 0;
  std::memcpy(&value, bytes.data() + index * sizeof value, sizeof value);
  return value == value ? std::optional(value) : std::nullopt;
}

}  // namespace

report::Comparison compare_with_ideal(const Config& config) {
  if (config.run.ideal) throw ConfigError("run.ideal: the run itself is ideal; false is expected where it is compared with its ideal");
  const std::vector<Config> configs = {config, ideal(config)};
  const auto answers = in_processes(configs.size(), processors(), [&](std::size_t i) { return packed(metrics_of(configs[i])); }, {});
  report::Comparison comparison;
  comparison.duration_s = config.run.duration_s;
  for (report::Metric& metric : metrics(Simulation(config).report())) {  // not run: for the names
    const std::size_t index = comparison.rows.size();
    if ((index + 1) * sizeof(double) > std::min(answers[0].size(), answers[1].size())) throw std::logic_error("compare: metrics are missing");
    metric.value = unpacked(answers[0], index);
    comparison.rows.push_back({std::move(metric), unpacked(answers[1], index)});
  }
  return comparison;
}

}  // namespace cmrc
