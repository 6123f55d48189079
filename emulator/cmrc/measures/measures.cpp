#include "cmrc/measures/measures.hpp"

#include <algorithm>
#include <cmath>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/demand.hpp"
#include "cmrc/measures/work_progress.hpp"
#include "plant/parameters/config.hpp"

namespace cmrc {
namespace {

constexpr double residual_seconds = 12;  // time after an arrival in which the load's swing is measured

using report::seconds;

/// Mean square, peak and last value of a sampled quantity.
class Sampled {
 public:
  void add(double value) {
    squares_ += value * value;
    peak_ = std::max(peak_, std::abs(value));
    end_ = value;
    ++count_;
  }
  report::Deviation deviation() const {
    return {count_ == 0 ? 0 : std::sqrt(squares_ / static_cast<double>(count_)), peak_, end_};
  }

 private:
  double squares_ = 0, peak_ = 0, end_ = 0;
  std::size_t count_ = 0;
};

using Row = std::span<const double>;

double distance(Row a, Row b, std::size_t column, std::size_t count) {
  double sum = 0;
  for (std::size_t i = column; i < column + count; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

}  // namespace

// A box of twelve metres turns about its middle. The gantry's psi does not move.
Levers levers(const plant::CraneParameters& crane) {
  const double box = 0.5 * plant::container_length;
  if (crane.machine == plant::CraneKind::gantry) return {1.0, 0.0, 1.0, 1.0, box};
  return {1.0, crane.a0 + crane.jib, crane.jib, 1.0, box};
}

std::size_t rows_of(const Config& config) {
  const auto latches = static_cast<std::size_t>(std::llround(config.run.duration_s / plant::latch_seconds)) + 1;
  return std::min(latches, static_cast<std::size_t>(config.report.error_rows_max));
}

report::Errors measure(const Measured& run, const Course& ideal, const JobsByRobot& demanded) {
  report::Errors errors;
  const Time from = ideal.servo_times().empty() ? Time{} : ideal.servo_times().front();
  errors.from = from;
  errors.to = run.to;
  const auto names = plant::joint_names(run.dock.crane.machine);
  const auto weights = levers(run.dock.crane);
  WorkProgress progress(run.course, ideal, 0, from, run.to, weights);

  Sampled load, nothing, alpha, beta;
  std::array<Sampled, plant::joint_count> error, path;
  std::vector<Sampled> agvs(static_cast<std::size_t>(run.dock.agv_count));
  std::vector<double> arrivals;  // ends of the crane's legs
  for (const Milestone& milestone : run.course.milestones()) {
    if (milestone.robot == 0 && milestone.kind() == Milestone::Kind::leg_ended)
      arrivals.push_back(seconds(milestone.at));
  }
  std::size_t arrival = 0;
  double weighed = 0;
  // Instants at which both courses have a row.
  const Time step = std::max(run.course.step(), ideal.step());
  const bool both = run.course.size() > 0 && ideal.size() > 0;
  for (Time time = (from + step - Time{1}) / step * step; both && time < run.to; time += step) {
    const Row own = run.course.at(time), meant = ideal.at(time);
    const Time there = progress.ideal_time(time);
    load.add(distance(own, meant, load_column, 3));
    nothing.add(distance(meant, ideal.at(from), load_column, 3));
    for (std::size_t j = 0; j < error.size(); ++j) {
      const double off = own[j] - meant[j];
      error[j].add(off);
      path[j].add(own[j] - (there == time ? meant[j] : ideal.at(there, j)));
      weighed += weights[j] * weights[j] * off * off * seconds(step);
    }
    alpha.add(own[sway_column] - meant[sway_column]);
    beta.add(own[sway_column + 1] - meant[sway_column + 1]);
    while (arrival + 1 < arrivals.size() && arrivals[arrival + 1] <= seconds(time)) ++arrival;
    if (!arrivals.empty() && arrivals[arrival] <= seconds(time) &&
        seconds(time) <= arrivals[arrival] + residual_seconds) {
      errors.residual_sway_rad = std::max(errors.residual_sway_rad.value_or(0), distance(own, meant, sway_column, 2));
    }
    for (std::size_t agv = 0; agv < agvs.size(); ++agv) agvs[agv].add(distance(own, meant, agv_column + 2 * agv, 2));
  }

  errors.load = load.deviation();
  errors.doing_nothing_m = nothing.deviation().rms;
  errors.error_m2s = weighed;
  for (std::size_t j = 0; j < error.size(); ++j) {
    if (weights[j] > 0)
      errors.joints.push_back({names[j].name, names[j].unit, error[j].deviation(), path[j].deviation()});
  }
  errors.sway = {{"alpha", "rad", alpha.deviation(), {}}, {"beta", "rad", beta.deviation(), {}}};
  for (std::size_t agv = 0; agv < agvs.size(); ++agv)
    errors.agvs.push_back({"agv " + std::to_string(agv), "m", agvs[agv].deviation(), {}});
  for (Robot robot = 0; robot <= static_cast<Robot>(run.dock.agv_count); ++robot) {
    const WorkProgress of(run.course, ideal, robot, from, run.to, weights);
    if (of.any()) errors.lags.push_back(of.lag(robot == 0 ? "crane" : "agv " + std::to_string(robot - 1)));
  }
  add_demand(run, ideal, demanded, errors);
  return errors;
}

}  // namespace cmrc
