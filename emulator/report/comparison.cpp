#include "report/comparison.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/text_table.hpp"

namespace report {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> mean_of(const std::vector<CycleReport>& cycles, std::optional<Time> CycleReport::*time) {
  double sum = 0;
  int count = 0;
  for (const CycleReport& cycle : cycles)
    if (cycle.*time) sum += static_cast<double>((cycle.*time)->count()) * 1e-12, ++count;
  return count == 0 ? std::nullopt : std::optional(sum / count);
}

std::string shown(const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : "-"; }

Json optional(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

std::vector<Metric> metrics(const RunReport& report) {
  std::vector<Metric> all;
  all.push_back({"missed deadlines", "", static_cast<double>(report.misses())});
  const auto errors = [&](const std::vector<ErrorReport>& list, const std::string& what) {
    for (const ErrorReport& error : list) {
      all.push_back({what + error.name + " RMS", error.unit, error.rms});
      all.push_back({what + error.name + " peak", error.unit, error.peak});
    }
  };
  errors(report.tracking, "tracking ");
  errors(report.sway, "sway ");
  errors(report.agvs, "");
  all.push_back({"control cost", "m2 s", report.control_cost.cost()});
  all.push_back({"control cost, error", "m2 s", report.control_cost.error_m2s});
  all.push_back({"control cost, drives", "s", report.control_cost.drive_s});
  all.push_back({"containers delivered", "", static_cast<double>(report.containers_delivered)});
  all.push_back({"t_3, mean", "s", mean_of(report.cycles, &CycleReport::t3)});
  all.push_back({"cycle time T_g, mean", "s", mean_of(report.cycles, &CycleReport::T_g)});
  all.push_back({"delivered at, mean", "s", mean_of(report.cycles, &CycleReport::delivered)});
  for (const TaskReport& task : report.tasks) {
    const bool any = task.response.count > 0;
    all.push_back({task.kind + " response, worst", "us", any ? std::optional(static_cast<double>(task.response.worst) * 1e-6) : std::nullopt});
  }
  return all;
}

std::optional<double> Comparison::Row::difference() const {
  return run.value && ideal ? std::optional(*run.value - *ideal) : std::nullopt;
}

std::string to_text(const Comparison& comparison) {
  std::string text = fmt::format("The run beside the same run with instant execution, {:g} s simulated\n\n", comparison.duration_s);
  TextTable table({"", "unit", "run", "ideal", "difference", "%"});
  for (const Comparison::Row& row : comparison.rows) {
    if (!row.run.value && !row.ideal) continue;
    const auto difference = row.difference();
    const bool relative = difference && *row.ideal != 0;
    table.add({row.run.name, row.run.unit, shown(row.run.value), shown(row.ideal), shown(difference),
               relative ? fmt::format("{:+.1f}", 100 * *difference / std::abs(*row.ideal)) : "-"});
  }
  return text + table.render();
}

std::string to_json(const Comparison& comparison) {
  Json root = {{"duration_s", comparison.duration_s}, {"metrics", Json::object()}};
  for (const Comparison::Row& row : comparison.rows)
    root["metrics"][row.run.name] = {{"unit", row.run.unit},
                                     {"run", optional(row.run.value)},
                                     {"ideal", optional(row.ideal)},
                                     {"difference", optional(row.difference())}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace report
