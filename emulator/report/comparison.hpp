#pragma once
// A run beside the same run with instant execution (docs/report.md, Ideal).
#include <optional>
#include <string>
#include <vector>

#include "report/run_report.hpp"

namespace report {

/// One number of a run.
struct Metric {
  std::string name;
  std::string unit;
  std::optional<double> value;  ///< none: has not happened
  bool effort = false;          ///< what the drives were made to do: no measure of quality
};

/// What a run is judged by: misses, rates, errors, lag, control cost, cycles, every kind's slowest response; and the
/// drives' effort. The names depend on the configuration only.
std::vector<Metric> metrics(const RunReport& report);

struct Comparison {
  double duration_s = 0;     ///< that was simulated
  bool interrupted = false;  ///< before its end
  struct Row {
    Metric run;
    std::optional<double> ideal;
    std::optional<double> difference() const;
  };
  std::vector<Row> rows;
};

std::string to_text(const Comparison& comparison);
std::string to_json(const Comparison& comparison);

}  // namespace report
