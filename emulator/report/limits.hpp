#pragma once
// How far a configuration is from its first missed deadline, on stated grids (docs/report.md, Limits).
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace report {

/// One run of the scan.
struct LimitPoint {
  double value = 0;
  std::string refused;  ///< not run: the configuration that it makes breaks this rule
  bool ran = false;     ///< to its end or first miss; not if refused, nor what was left when the scan was interrupted
  bool passed = false;  ///< ran to its end without a missed deadline and without a starved interval
  std::string stop_reason;    ///< why it ended, "interrupted" at its first miss
  std::string first_miss;     ///< kind of the first missed job
  double first_miss_s = 0;    ///< its deadline, or its release where it has none
  std::uint64_t starved = 0;  ///< whole point intervals in which a robot got no new point
  /// What it cost, where errors are asked for: against the ideal run, over the whole duration.
  struct Cost {
    std::optional<double> f_p_hz, f_t_hz;          ///< realised
    std::optional<double> f_p_missed, f_t_missed;  ///< share of the demand
    double load_rms_m = 0, lag_s = 0;              ///< lag of the crane at the end
  };
  std::optional<Cost> cost;
};

/// One quantity that was scanned, the others as configured.
struct LimitScan {
  std::string name;  ///< "cycles", "dsps", "servo"
  std::string key;   ///< of the configuration
  std::string meaning;
  bool more_is_harder =
      true;  ///< the limit is the largest value below which all passes; else the smallest above which all passes
  std::vector<LimitPoint> points;  ///< by rising value

  /// The last value such that it and every point on its easy side that was run passes; none: the easiest does not.
  std::optional<double> limit() const;
  /// Points that pass beyond one that does not: scheduling without preemption has anomalies.
  std::vector<double> beyond() const;
};

struct Limits {
  double duration_s = 0;     ///< of each run
  bool interrupted = false;  ///< points are missing
  std::vector<LimitScan> scans;
};

std::string to_text(const Limits& limits);
std::string to_json(const Limits& limits);

}  // namespace report
