#pragma once
// A run and the same run with instant execution (docs/report.md, Ideal).
#include <optional>
#include <string>
#include <vector>

#include "report/values/run_report.hpp"

namespace report {

/// One number of a run.
struct Metric {
  std::string name;
  std::string unit;
  std::optional<double> value;  ///< none: the event has not happened
  bool effort = false;          ///< what the drives did: not a measure of quality
};

/// The numbers that judge a run: misses, rates, errors, lag, control cost, cycles, the slowest response of every kind;
/// and the drives' effort. The names depend on the configuration only.
std::vector<Metric> metrics(const RunReport& report);

struct Comparison {
  double duration_s = 0;     ///< simulated time
  bool interrupted = false;  ///< the run ended early
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
