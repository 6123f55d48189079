// The signals of a run as arrays.
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <cmath>
#include <memory>
#include <string>

#include "cmrc/measures/course.hpp"
#include "cmrc/run/simulation.hpp"
#include "plant/dock/dock.hpp"
#include "python/bindings/cmrc/cmrc.hpp"

py::dict signals_of(const plant::Dock& dock, const std::shared_ptr<const cmrc::Reference>& reference) {
  const auto& rows = dock.signals();
  py::dict all;
  const auto column = [&](const std::string& name, auto value) {
    py::array_t<double> array(static_cast<py::ssize_t>(rows.size()));
    double* out = array.mutable_data();
    for (std::size_t i = 0; i < rows.size(); ++i) out[i] = static_cast<double>(value(rows[i]));
    all[py::str(name)] = array;
  };
  column("time_s", [](const plant::Signal& s) { return static_cast<double>(s.time.count()) * 1e-12; });
  const auto joints = plant::joint_names(dock.config().crane.machine);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto [name, unit] = joints[j];
    column(fmt::format("{}_{}", name, unit), [j](const plant::Signal& s) { return s.q[j]; });
    column(fmt::format("{}_rate_{}_per_s", name, unit), [j](const plant::Signal& s) { return s.qd[j]; });
    column(fmt::format("{}_torque_Nm", name), [j](const plant::Signal& s) { return s.torque[j]; });
    column(fmt::format("{}_code", name), [j](const plant::Signal& s) { return s.code[j]; });
    column(fmt::format("{}_saturated", name), [j](const plant::Signal& s) { return std::abs(s.code[j]) >= 2047; });
    if (!reference) continue;
    column(fmt::format("{}_reference_{}", name, unit),
           [&, j](const plant::Signal& s) { return reference->course.at(s.time)[j]; });
    column(fmt::format("{}_error_{}", name, unit),
           [&, j](const plant::Signal& s) { return cmrc::Course::to_grid(s.q[j]) - reference->course.at(s.time)[j]; });
  }
  column("sway_alpha_rad", [](const plant::Signal& s) { return s.alpha; });
  column("sway_beta_rad", [](const plant::Signal& s) { return s.beta; });
  static constexpr const char* axes[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    column(fmt::format("tip_{}_m", axes[i]), [i](const plant::Signal& s) { return s.tip[i]; });
    column(fmt::format("payload_{}_m", axes[i]), [i](const plant::Signal& s) { return s.payload[i]; });
    if (!reference) continue;
    column(fmt::format("payload_reference_{}_m", axes[i]),
           [&, i](const plant::Signal& s) { return reference->course.at(s.time)[plant::joint_count + i]; });
  }
  column("payload_yaw_rad", [](const plant::Signal& s) { return s.yaw; });
  column("tension_N", [](const plant::Signal& s) { return s.tension; });
  column("contact", [](const plant::Signal& s) { return s.contact; });
  const auto& fleet = dock.agv_signals();
  for (std::size_t agv = 0; agv < fleet.size(); ++agv) {
    const auto agv_column = [&](const char* name, auto value) {
      py::array_t<double> array(static_cast<py::ssize_t>(fleet[agv].size()));
      double* out = array.mutable_data();
      for (std::size_t i = 0; i < fleet[agv].size(); ++i) out[i] = value(fleet[agv][i]);
      all[py::str(fmt::format("agv{}_{}", agv, name))] = array;
    };
    agv_column("x_m", [](const plant::AgvSignal& s) { return s.x; });
    agv_column("y_m", [](const plant::AgvSignal& s) { return s.y; });
    agv_column("heading_rad", [](const plant::AgvSignal& s) { return s.heading; });
    agv_column("speed_m_per_s", [](const plant::AgvSignal& s) { return s.speed; });
    agv_column("speed_command_m_per_s", [](const plant::AgvSignal& s) { return s.speed_command; });
    agv_column("front_rad", [](const plant::AgvSignal& s) { return s.front; });
    agv_column("rear_rad", [](const plant::AgvSignal& s) { return s.rear; });
  }
  return all;
}
