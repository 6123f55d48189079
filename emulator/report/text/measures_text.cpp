#include "report/text/measures_text.hpp"

#include <fmt/format.h>

#include "report/text/text_table.hpp"

namespace report {
namespace {

std::string number(const std::optional<double>& value, const char* format = "{:.4g}") {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

std::string share(const std::optional<double>& part) { return part ? percent(*part, 1.0) + " %" : "-"; }

/// 0.00061 m as "0.61 mm".
std::string length(double metres) {
  if (metres == 0) return "0 m";
  if (metres < 1e-3) return fmt::format("{:.3g} um", metres * 1e6);
  if (metres < 1) return fmt::format("{:.3g} mm", metres * 1e3);
  return fmt::format("{:.4g} m", metres);
}

std::string of_doing_nothing(const Errors& errors) {
  return errors.doing_nothing_m > 0
             ? fmt::format(" ({} % of a crane that does nothing)", percent(errors.load.rms, errors.doing_nothing_m))
             : "";
}

}  // namespace

std::string headline(const RunReport& report) {
  if (!report.reference_problem.empty())
    return fmt::format("No ideal run to measure against: {}.\n", report.reference_problem);
  if (!report.errors) {
    return fmt::format("{}\n",
                       report.reference == "none"
                           ? "No reference (report.reference = \"none\"): demand, errors and lag are not measured."
                           : "Demand, errors and lag are reported when the run is over.");
  }
  const Errors& errors = *report.errors;
  TextTable table({"against", "nominal", "demanded", "not released", "missed", "missed %", "realised", "worst second"});
  for (const Rate& rate : errors.rates) {
    if (rate.all.demanded + rate.all.released == 0) continue;
    table.add({rate.name, fmt::format("{:g} Hz", rate.nominal_hz), fmt::format("{}", rate.all.demanded),
               fmt::format("{}", rate.all.not_demanded), fmt::format("{}", rate.all.misses), share(rate.all.missed()),
               number(rate.all.realised_hz) + " Hz", number(rate.all.worst_hz) + " Hz"});
  }
  std::string lags;
  for (const Lag& lag : errors.lags)
    lags += fmt::format("{}{} {:.3f} s", lags.empty() ? "" : ", ", lag.robot, lag.end_s);
  return table.render() +
         fmt::format("  load error: {} RMS, {} peak, {} at the end{}\n", length(errors.load.rms),
                     length(errors.load.peak), length(errors.load.end), of_doing_nothing(errors)) +
         (lags.empty() ? "" : fmt::format("  lag at the end: {}\n", lags));
}

std::string errors_section(const RunReport& report) {
  std::string text;
  if (report.errors) {
    const Errors& errors = *report.errors;
    TextTable table({"error", "unit", "RMS", "peak", "at the end", "path RMS", "path peak"});
    const auto value = [](double x) { return fmt::format("{:.6f}", x); };
    const auto add = [&](const std::vector<JointDeviation>& list, std::string_view what, bool path) {
      for (const JointDeviation& of : list)
        table.add({std::string(what) + of.name, of.unit, value(of.error.rms), value(of.error.peak), value(of.error.end),
                   path ? value(of.path.rms) : "-", path ? value(of.path.peak) : "-"});
    };
    table.add({"load", "m", value(errors.load.rms), value(errors.load.peak), value(errors.load.end), "-", "-"});
    add(errors.joints, "joint ", true);
    add(errors.sway, "sway ", false);
    add(errors.agvs, "", false);
    text += fmt::format("\nErrors against the ideal run, {:g} to {:g} s (path: with the lag taken out)\n",
                        seconds(errors.from), seconds(errors.to)) +
            table.render();
    if (errors.residual_sway_rad)
      text += fmt::format("  sway error in the 12 s after an arrival: at most {:.6f} rad\n", *errors.residual_sway_rad);
    for (const Lag& lag : errors.lags)
      text += fmt::format("  lag of {}: {:.4f} s at the end, {:.4f} s at most\n", lag.robot, lag.end_s, lag.peak_s);
    text += fmt::format("  control cost: {:.6g} m2 s, of it {:.6g} by the drives (rho {:g} m2)\n",
                        report.control_cost.cost().value_or(0),
                        report.control_cost.rho_m2 * report.control_cost.drive_s, report.control_cost.rho_m2);
  }
  for (const Starved& of : report.starved)
    if (of.intervals > 0)
      text += fmt::format("  {}: {} point interval{} without a new point\n", of.robot, of.intervals,
                          of.intervals == 1 ? "" : "s");
  std::string saturated;
  for (const DriveReport& drive : report.drives)
    if (drive.saturated_s > 0)
      saturated += fmt::format("{}{} {:.4g} s", saturated.empty() ? "" : ", ", drive.name, drive.saturated_s);
  if (!saturated.empty()) text += fmt::format("  drives at full torque: {}\n", saturated);
  TextTable own({"the run's own", "unit", "RMS", "peak"});
  for (const OwnMeasure& of : report.pid_error)
    own.add({"PID error " + of.name, of.unit, number(of.rms, "{:.6f}"), number(of.peak, "{:.6f}")});
  for (const OwnMeasure& of : report.sway)
    own.add({"sway " + of.name, of.unit, number(of.rms, "{:.6f}"), number(of.peak, "{:.6f}")});
  for (const OwnMeasure& of : report.agvs)
    own.add({of.name, of.unit, number(of.rms, "{:.6f}"), number(of.peak, "{:.6f}")});
  if (!own.empty()) text += "\nWhat controller and sensors saw\n" + own.render();
  return text;
}

std::string after_stop_section(const RunReport& report) {
  if (!report.after_stop || report.after_stop->to <= report.after_stop->from) return "";
  const AfterStop& after = *report.after_stop;
  return fmt::format(
      "\nAfter the stop, braked, {:.3f} to {:.3f} s\n  load: moved up to {}; sway {:.4f} rad at most, "
      "{:.4f} rad in the last 2 s\n",
      seconds(after.from), seconds(after.to), length(after.moved_m), after.sway_peak_rad, after.sway_end_rad);
}

}  // namespace report
