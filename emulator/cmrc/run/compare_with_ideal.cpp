#include "cmrc/run/compare_with_ideal.hpp"

#include <stdexcept>
namespace cmrc {
report::Comparison compare_with_ideal(const Config& given, const std::function<bool(const Progress&)>& on_progress) {
  if (given.run.ideal)
    throw ConfigError("run.ideal: the run itself is ideal; false is expected for a comparison with the ideal run");
  Config config = given;
  config.report.reference = ReferenceKind::ideal;
  Simulation simulation(config);
  simulation.run(on_progress);
  report::Comparison comparison;
  comparison.duration_s = report::seconds(simulation.time());
  const report::RunReport report = simulation.report_so_far();
  comparison.interrupted = simulation.interrupted();
  if (!report.reference_problem.empty())
    throw std::runtime_error("compare: there is no ideal run: " + report.reference_problem);
  const auto ideal = simulation.reference();
  for (report::Metric& metric : metrics(report)) {
    const std::size_t index = comparison.rows.size();
    comparison.rows.push_back({std::move(metric), ideal->metrics.at(index)});
  }
  return comparison;
}

}  // namespace cmrc
