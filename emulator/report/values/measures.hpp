#pragma once
// Measures of a run from outside: against its ideal run, from the plant and in virtual time (docs/report.md, Errors).
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/events/event.hpp"

namespace report {

/// A distance from the ideal run over the window.
struct Deviation {
  double rms = 0;
  double peak = 0;
  double end = 0;
};

struct JointDeviation {
  std::string name;  ///< "s", "psi", ...
  std::string unit;  ///< "m", "rad"
  Deviation error;   ///< from the ideal run at the same instant
  Deviation path;    ///< from the ideal run at the same progress
};

/// How far a robot's work is behind the ideal run's.
struct Lag {
  std::string robot;  ///< "crane", "agv 0", ...
  double peak_s = 0;
  double end_s = 0;
};

/// Jobs of one kind, compared with the jobs that the ideal run released.
struct Demand {
  std::string kind;
  std::uint64_t demanded = 0, released = 0, misses = 0;
  std::uint64_t not_demanded = 0;  ///< demanded but never released, over all robots
  std::uint64_t extra = 0;         ///< released beyond what was demanded
  std::uint64_t finished = 0;
  std::optional<double>
      demanded_hz;  ///< jobs per second of the time in which the kind is demanded; none: a kind without a rate
  std::optional<double> realised_hz;  ///< finished jobs per second of that time
  std::optional<double> worst_hz;     ///< the same in the second with the fewest

  /// Share of the demand that was missed, 0 to 1; none without demand.
  std::optional<double> missed() const;
};

/// f_p, f_t or f_a: the demanded and the realised rate.
struct Rate {
  std::string name;                ///< "f_p", "f_t", "f_a"
  std::vector<std::string> kinds;  ///< realised is the slower of them
  double nominal_hz = 0;
  Demand all;  ///< of all its kinds
};

/// Everything that needs the ideal run.
struct Errors {
  Time from{}, to{};                          ///< the window
  std::optional<double> reference_elapsed_s;  ///< wall-clock time of the ideal run; none: the run itself is ideal
  Deviation load;                             ///< m, of the load's place
  double doing_nothing_m = 0;  ///< RMS distance of the ideal run's load from where it was at the window's start
  std::vector<JointDeviation> joints;
  std::vector<JointDeviation> sway;         ///< rad; without `path`
  std::optional<double> residual_sway_rad;  ///< largest sway error in the 12 s after an arrival; none: no arrival
  std::vector<JointDeviation> agvs;         ///< m, of each AGV's place; without `path`
  std::vector<Lag> lags;
  double error_m2s = 0;  ///< integral of the squared joint errors, weighted by how they move the spreader
  std::vector<Rate> rates;
  std::vector<Demand> demand;  ///< by kind: all kinds that either run released

  const Rate* rate(const std::string& name) const;
};

}  // namespace report
