#include "report/values/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/json/json_values.hpp"
#include "report/text/text_table.hpp"

namespace report {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> mean_of(const std::vector<CycleReport>& cycles, std::optional<Time> CycleReport::* time) {
  double sum = 0;
  int count = 0;
  for (const CycleReport& cycle : cycles)
    if (cycle.*time) sum += seconds(*(cycle.*time)), ++count;
  return count == 0 ? std::nullopt : std::optional(sum / count);
}

std::string shown(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : "-"; }

}  // namespace

std::vector<Metric> metrics(const RunReport& report) {
  std::vector<Metric> all;
  const auto add = [&](std::string name, std::string unit, std::optional<double> value) {
    all.push_back({std::move(name), std::move(unit), value});
  };
  add("missed deadlines", "", report.judged() ? std::optional(static_cast<double>(report.misses())) : std::nullopt);
  static const Errors none;
  const Errors& errors = report.errors ? *report.errors : none;
  for (const char* name : {"f_p", "f_t", "f_a"}) {
    const Rate* rate = errors.rate(name);
    const std::string what = name;
    add(what + " missed", "%",
        rate != nullptr && rate->all.missed() ? std::optional(100 * *rate->all.missed()) : std::nullopt);
    add(what + " realised", "Hz", rate != nullptr ? rate->all.realised_hz : std::nullopt);
    add(what + " realised, worst second", "Hz", rate != nullptr ? rate->all.worst_hz : std::nullopt);
  }
  const auto deviation = [&](const std::string& what, const std::string& unit, const Deviation* of) {
    add(what + " RMS", unit, of != nullptr ? std::optional(of->rms) : std::nullopt);
    add(what + " peak", unit, of != nullptr ? std::optional(of->peak) : std::nullopt);
    add(what + " at the end", unit, of != nullptr ? std::optional(std::abs(of->end)) : std::nullopt);
  };
  const auto joint = [](const std::vector<JointDeviation>& list, const std::string& name) {
    const auto found = std::ranges::find(list, name, &JointDeviation::name);
    return found == list.end() ? nullptr : &*found;
  };
  deviation("load error", "m", report.errors ? &errors.load : nullptr);
  for (const OwnMeasure& of : report.pid_error) {
    const JointDeviation* found = joint(errors.joints, of.name);
    deviation("error " + of.name, of.unit, found != nullptr ? &found->error : nullptr);
    add("path error " + of.name + " RMS", of.unit, found != nullptr ? std::optional(found->path.rms) : std::nullopt);
  }
  for (const OwnMeasure& of : report.sway) {
    const JointDeviation* found = joint(errors.sway, of.name);
    deviation("sway error " + of.name, of.unit, found != nullptr ? &found->error : nullptr);
  }
  add("sway error after arrivals, peak", "rad", errors.residual_sway_rad);
  for (std::size_t agv = 0; agv < report.agvs.size(); ++agv) {
    const std::string name = "agv " + std::to_string(agv);
    const JointDeviation* found = joint(errors.agvs, name);
    deviation(name + " error", "m", found != nullptr ? &found->error : nullptr);
  }
  for (std::size_t robot = 0; robot <= report.agvs.size(); ++robot) {
    const std::string name = robot == 0 ? "crane" : "agv " + std::to_string(robot - 1);
    const auto found = std::ranges::find(errors.lags, name, &Lag::robot);
    const bool any = found != errors.lags.end();
    add("lag " + name + " at the end", "s", any ? std::optional(found->end_s) : std::nullopt);
    add("lag " + name + " peak", "s", any ? std::optional(found->peak_s) : std::nullopt);
  }
  add("control cost", "m2 s", report.control_cost.cost());
  add("control cost, error", "m2 s", report.control_cost.error_m2s);
  add("containers delivered", "", static_cast<double>(report.containers_delivered));
  add("makespan", "s", report.makespan ? std::optional(seconds(*report.makespan)) : std::nullopt);
  add("t_3, mean", "s", mean_of(report.cycles, &CycleReport::t3));
  add("cycle time T_g, mean", "s", mean_of(report.cycles, &CycleReport::T_g));
  add("delivered at, mean", "s", mean_of(report.cycles, &CycleReport::delivered));
  for (const TaskReport& task : report.tasks) {
    const bool any = task.response.count > 0;
    add(task.kind + " response, worst", "us",
        any ? std::optional(static_cast<double>(task.response.worst) * 1e-6) : std::nullopt);
  }
  const auto effort = [&](std::string name, double value) {
    add(std::move(name), "s", value);
    all.back().effort = true;
  };
  effort("drives, squared torque", report.control_cost.drive_s);
  for (const DriveReport& drive : report.drives) effort("drive " + drive.name + " at full torque", drive.saturated_s);
  return all;
}

std::optional<double> Comparison::Row::difference() const {
  return run.value && ideal ? std::optional(*run.value - *ideal) : std::nullopt;
}

std::string to_text(const Comparison& comparison) {
  std::string text = fmt::format("The run and the same run with instant execution, {:g} s simulated{}\n\n",
                                 comparison.duration_s, comparison.interrupted ? "; interrupted" : "");
  TextTable table({"", "unit", "run", "ideal", "difference", "%"});
  for (const Comparison::Row& row : comparison.rows) {
    if (!row.run.value && !row.ideal) continue;
    const auto difference = row.difference();
    const bool relative = difference && *row.ideal != 0;
    table.add({row.run.name + (row.run.effort ? " (effort)" : ""), row.run.unit, shown(row.run.value), shown(row.ideal),
               shown(difference), relative ? fmt::format("{:+.1f}", 100 * *difference / std::abs(*row.ideal)) : "-"});
  }
  return text + table.render() +
         "\n(effort): what the drives did. Not a measure of quality: a crane that does not move needs little.\n";
}

std::string to_json(const Comparison& comparison) {
  Json root = {{"duration_s", comparison.duration_s},
               {"stop_reason", comparison.interrupted ? "interrupted" : "completed"},
               {"metrics", Json::object()}};
  for (const Comparison::Row& row : comparison.rows)
    root["metrics"][row.run.name] = {{"unit", row.run.unit},
                                     {"measures", row.run.effort ? "effort" : "quality"},
                                     {"run", or_null(row.run.value)},
                                     {"ideal", or_null(row.ideal)},
                                     {"difference", or_null(row.difference())}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace report
