#include "cmrc/timelines/perfetto_plant.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace cmrc {
namespace {

constexpr report::Time plant_sample_period = std::chrono::milliseconds{20};
static_assert(plant_sample_period % plant::latch_period == report::Time{});

}  // namespace

PerfettoPlant::PerfettoPlant(Trace& trace, const plant::Dock& dock, report::Window window)
    : trace_(trace), window_(window) {
  const Trace::Track group = trace_.add_group("plant", 0, "True values, without sensors, each 20 ms");
  const auto add = [&](const std::string& name, const char* unit) {
    signals_.push_back({trace_.add_counter(name, unit, group)});
  };
  for (const plant::JointName& joint : plant::joint_names(dock.config().crane.machine)) add(joint.name, joint.unit);
  for (const char* axis : {"x", "y", "z"}) add(fmt::format("load {}", axis), "m");
  for (const char* axis : {"alpha", "beta"}) add(fmt::format("sway {}", axis), "rad");
  for (int agv = 0; agv < dock.agv_count(); ++agv) {
    add(fmt::format("agv {} x", agv), "m");
    add(fmt::format("agv {} y", agv), "m");
    add(fmt::format("agv {} speed", agv), "m/s");
  }
}

void PerfettoPlant::tell(double value, report::Time now) {
  Signal& signal = signals_.at(next_++);
  constexpr double parts = 1e6;  // parts of a metre or a radian; finer digits cannot be seen
  const double rounded = std::round(value * parts) / parts;
  if (rounded == signal.written) return;
  trace_.count(signal.track, now, rounded);
  signal.written = rounded;
}

void PerfettoPlant::latched(const plant::Dock& dock, report::Time now) {
  if (now % plant_sample_period != report::Time{} || !window_.contains(now)) return;
  next_ = 0;
  const plant::Place place = dock.place();
  for (const double q : place.q) tell(q, now);
  for (const double metres : place.payload) tell(metres, now);
  tell(place.alpha, now);
  tell(place.beta, now);
  for (int agv = 0; agv < dock.agv_count(); ++agv) {
    const plant::AgvSignal signal = dock.agv(agv);
    for (const double value : {signal.x, signal.y, signal.speed}) tell(value, now);
  }
}

}  // namespace cmrc
