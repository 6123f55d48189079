#include "report/json/measures_json.hpp"

#include "report/json/json_values.hpp"

namespace report {
namespace {

using Json = nlohmann::ordered_json;

Json deviation(const Deviation& of) { return {{"rms", of.rms}, {"peak", of.peak}, {"end", of.end}}; }

Json deviations(const std::vector<JointDeviation>& list, bool path) {
  Json object = Json::object();
  for (const JointDeviation& of : list) {
    Json& one =
        object[of.name] = {{"unit", of.unit}, {"rms", of.error.rms}, {"peak", of.error.peak}, {"end", of.error.end}};
    if (path) one["path"] = deviation(of.path);
  }
  return object;
}

Json own(const std::vector<OwnMeasure>& list) {
  Json object = Json::object();
  for (const OwnMeasure& of : list)
    object[of.name] = {{"unit", of.unit}, {"rms", or_null(of.rms)}, {"peak", or_null(of.peak)}};
  return object;
}

Json demand(const Demand& of) {
  return {{"demanded", of.demanded},
          {"released", of.released},
          {"not_demanded", of.not_demanded},
          {"extra", of.extra},
          {"misses", of.misses},
          {"missed_share", or_null(of.missed())},
          {"finished", of.finished},
          {"demanded_hz", or_null(of.demanded_hz)},
          {"realised_hz", or_null(of.realised_hz)},
          {"realised_worst_hz", or_null(of.worst_hz)}};
}

Json errors(const Errors& of) {
  Json root = {
      {"window_s", {seconds(of.from), seconds(of.to)}},
      {"load_m", deviation(of.load)},
      {"doing_nothing_m", of.doing_nothing_m},
      {"load_of_doing_nothing", of.doing_nothing_m > 0 ? Json(of.load.rms / of.doing_nothing_m) : Json(nullptr)},
      {"joints", deviations(of.joints, true)},
      {"sway", deviations(of.sway, false)},
      {"residual_sway_rad", or_null(of.residual_sway_rad)},
      {"agvs", deviations(of.agvs, false)},
      {"lag", Json::object()},
      {"demand", Json::object()}};
  for (const Lag& lag : of.lags) root["lag"][lag.robot] = {{"end_s", lag.end_s}, {"peak_s", lag.peak_s}};
  for (const Demand& kind : of.demand) root["demand"][kind.kind] = demand(kind);
  return root;
}

}  // namespace

void add_measures(const RunReport& report, Json& root) {
  root["reference"] = report.reference;
  root["reference_problem"] = report.reference_problem.empty() ? Json(nullptr) : Json(report.reference_problem);
  root["reference_elapsed_s"] =
      report.errors && report.errors->reference_elapsed_s ? Json(*report.errors->reference_elapsed_s) : Json(nullptr);
  root["rates"] = nullptr;
  root["errors"] = nullptr;
  if (report.errors) {
    root["rates"] = Json::object();
    for (const Rate& rate : report.errors->rates) {
      Json& one = root["rates"][rate.name] = demand(rate.all);
      one["kinds"] = rate.kinds;
      one["nominal_hz"] = rate.nominal_hz;
    }
    root["errors"] = errors(*report.errors);
  }
  root["starved_intervals"] = Json::object();
  for (const Starved& of : report.starved) root["starved_intervals"][of.robot] = of.intervals;
  root["control_cost"] = {{"cost_m2s", or_null(report.control_cost.cost())},
                          {"error_m2s", or_null(report.control_cost.error_m2s)},
                          {"drive_s", report.control_cost.drive_s},
                          {"rho_m2", report.control_cost.rho_m2}};
  root["pid_error"] = own(report.pid_error);
  root["sway"] = own(report.sway);
  root["agvs"] = own(report.agvs);
  root["drives"] = Json::object();
  for (const DriveReport& drive : report.drives) root["drives"][drive.name] = {{"saturated_s", drive.saturated_s}};
  root["makespan_s"] = report.makespan ? Json(seconds(*report.makespan)) : Json(nullptr);
  root["after_stop"] = nullptr;
  if (const auto& after = report.after_stop) {
    root["after_stop"] = {{"from_s", seconds(after->from)},
                          {"to_s", seconds(after->to)},
                          {"load_moved_m", after->moved_m},
                          {"sway_peak_rad", after->sway_peak_rad},
                          {"sway_end_rad", after->sway_end_rad}};
  }
}

}  // namespace report
