#include "report/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "report/text_table.hpp"

namespace report {
namespace {

using Json = nlohmann::ordered_json;

/// The points that were run, the easiest first.
std::vector<const LimitPoint*> by_ease(const LimitScan& scan) {
  std::vector<const LimitPoint*> points;
  for (const LimitPoint& point : scan.points)
    if (point.refused.empty()) points.push_back(&point);
  if (!scan.more_is_harder) std::ranges::reverse(points);
  return points;
}

bool easiest_ran(const LimitScan& scan) {
  const auto points = by_ease(scan);
  return points.empty() || points.front()->ran;
}

std::string outcome(const LimitPoint& point) {
  if (!point.refused.empty()) return "not run: " + point.refused;
  if (!point.ran) return "not run: interrupted";
  if (point.passed) return "no miss";
  if (!point.first_miss.empty()) return fmt::format("{} missed at {:.6f} s", point.first_miss, point.first_miss_s);
  if (point.starved > 0)
    return fmt::format("starved: {} point interval{} without a new point", point.starved,
                       point.starved == 1 ? "" : "s");
  return point.stop_reason;
}

std::string cost(const LimitPoint& point) {
  if (!point.cost) return "";
  const auto rate = [](const char* name, std::optional<double> hertz, std::optional<double> missed) {
    return hertz ? fmt::format("; {} {:.4g} Hz, {} % missed", name, *hertz, percent(missed.value_or(0), 1)) : "";
  };
  const LimitPoint::Cost& of = *point.cost;
  return rate("f_p", of.f_p_hz, of.f_p_missed) + rate("f_t", of.f_t_hz, of.f_t_missed) +
         fmt::format("; load error {:.4g} m RMS, lag {:.3g} s", of.load_rms_m, of.lag_s);
}

Json cost_json(const LimitPoint& point) {
  if (!point.cost) return nullptr;
  const auto optional = [](std::optional<double> value) { return value ? Json(*value) : Json(nullptr); };
  const LimitPoint::Cost& of = *point.cost;
  return {{"f_p_realised_hz", optional(of.f_p_hz)},
          {"f_p_missed_share", optional(of.f_p_missed)},
          {"f_t_realised_hz", optional(of.f_t_hz)},
          {"f_t_missed_share", optional(of.f_t_missed)},
          {"load_rms_m", of.load_rms_m},
          {"lag_s", of.lag_s}};
}

std::string list(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{}{:g}", text.empty() ? "" : ", ", value);
  return text;
}

}  // namespace

std::optional<double> LimitScan::limit() const {
  std::optional<double> found;
  for (const LimitPoint* point : by_ease(*this)) {
    if (!point->ran || !point->passed) break;
    found = point->value;
  }
  return found;
}

std::vector<double> LimitScan::beyond() const {
  std::vector<double> values;
  bool failed = false;
  for (const LimitPoint* point : by_ease(*this)) {
    if (!point->ran) continue;
    if (!point->passed)
      failed = true;
    else if (failed)
      values.push_back(point->value);
  }
  return values;
}

std::string to_text(const Limits& limits) {
  std::string text = fmt::format("Limits, {:g} s simulated for each point{}\n", limits.duration_s,
                                 limits.interrupted ? "; interrupted" : "");
  for (const LimitScan& scan : limits.scans) {
    text += fmt::format("\n{} ({})\n", scan.meaning, scan.key);
    for (const LimitPoint& point : scan.points)
      text += fmt::format("  {:>9g}  {}{}\n", point.value, outcome(point), cost(point));
    const auto limit = scan.limit();
    text += limit               ? fmt::format("  limit: {:g}; {} passes\n", *limit,
                                scan.more_is_harder ? "every point up to it" : "every point from it on")
            : easiest_ran(scan) ? std::string("  no limit: the easiest point does not pass\n")
                                : std::string("  no limit known: the easiest point has not been run\n");
    if (const auto beyond = scan.beyond(); !beyond.empty())
      text += fmt::format("  anomalies, passing beyond a miss: {}\n", list(beyond));
  }
  return text;
}

std::string to_json(const Limits& limits) {
  Json root = {{"duration_s", limits.duration_s},
               {"stop_reason", limits.interrupted ? "interrupted" : "completed"},
               {"scans", Json::object()}};
  for (const LimitScan& scan : limits.scans) {
    Json points = Json::array();
    for (const LimitPoint& point : scan.points) {
      const bool missed = !point.first_miss.empty();
      points.push_back({{"value", point.value},
                        {"ran", point.ran},
                        {"passed", point.passed},
                        {"refused", point.refused.empty() ? Json(nullptr) : Json(point.refused)},
                        {"stop_reason", point.stop_reason.empty() ? Json(nullptr) : Json(point.stop_reason)},
                        {"first_miss", missed ? Json(point.first_miss) : Json(nullptr)},
                        {"first_miss_s", missed ? Json(point.first_miss_s) : Json(nullptr)},
                        {"starved_intervals", point.starved},
                        {"errors", cost_json(point)}});
    }
    const auto limit = scan.limit();
    root["scans"][scan.name] = {{"key", scan.key},
                                {"meaning", scan.meaning},
                                {"limit", limit ? Json(*limit) : Json(nullptr)},
                                {"passing_beyond", scan.beyond()},
                                {"points", std::move(points)}};
  }
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace report
