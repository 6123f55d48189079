#include "cmrc/configuration/dock/nominal_dock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "plant/parameters/basics.hpp"
#include "plant/parameters/check.hpp"
#include "plant/parameters/layout_file.hpp"

namespace cmrc {
namespace {

void read_layout(plant::DockConfig& dock, const std::string& path) try {
  plant::load_layout(dock, path);
  plant::check(dock);
} catch (const plant::LayoutError& error) {
  throw ConfigError(fmt::format("dock.layout: {}", error.what()));
} catch (const std::invalid_argument& error) {
  throw ConfigError(fmt::format("dock.layout: {}: {}", path, error.what()));
}

// Fills the default bay: tiers 2 to 4 above the six places of the first tier, except occupied places.
void stack_more(plant::Layout& layout) {
  const std::vector<plant::ContainerPlace> places = layout.containers;
  for (int tier = 1; tier < 4; ++tier) {
    for (plant::ContainerPlace place : places) {
      if (place.z != layout.deck) continue;
      place.z += tier * plant::container_height;
      const bool taken = std::ranges::any_of(
          places, [&](const auto& p) { return p.x == place.x && p.y == place.y && p.z == place.z; });
      if (!taken) layout.containers.push_back(place);
    }
  }
}

}  // namespace

double drive_delay_latches(const Config& config) {
  return config.dock.drive_delay_us / std::chrono::duration<double, std::micro>(plant::latch_period).count();
}

plant::DockConfig nominal_dock_of(const Config& config) {
  const int agvs = static_cast<int>(config.dock.agvs);
  plant::DockConfig dock =
      config.dock.crane == CraneMachine::gantry ? plant::gantry_dock(agvs) : plant::default_dock(agvs);
  place_plant_parameters(dock, config.plant);
  dock.agv.protective_field = config.dock.protective_field;
  dock.layout.container_mass = config.dock.container_mass_kg;
  for (auto& container : dock.layout.containers) container.mass = config.dock.container_mass_kg;
  stack_more(dock.layout);  // a layout that lists containers replaces these
  if (!config.dock.layout.empty()) read_layout(dock, config.dock.layout);
  dock.layout.containers.resize(
      std::min<std::size_t>(dock.layout.containers.size(), static_cast<std::size_t>(config.dock.containers)));
  for (auto& leg : dock.layout.legs) {
    for (auto& lane : leg) lane.speed = std::min(lane.speed, config.dock.agv_speed_m_s);
  }
  dock.sensors.second_sway = config.dock.sway_sensors == 2;
  dock.sensors.seed = static_cast<std::uint64_t>(config.run.seed);
  dock.rigid = config.dock.crane_model == CraneModel::rigid;
  dock.method = config.dock.integrator;
  dock.crane.stiction = config.dock.stiction;
  dock.crane.gear_losses = config.dock.gear_losses;
  dock.landing.strict = config.dock.strict_landing;
  dock.landing.guides = config.dock.capture_window_m > 0.0;
  if (dock.landing.guides) dock.landing.guide_window = config.dock.capture_window_m;
  dock.ship.scale = config.dock.ship_motion;
  dock.ship.seed = static_cast<std::uint64_t>(config.run.seed);
  dock.wind.mean = config.dock.wind_mean_m_s;
  dock.wind.gust = config.dock.wind_gust_m_s;
  dock.wind.direction = config.dock.wind_direction_deg * std::numbers::pi / 180.0;
  dock.wind.seed = dock.sensors.seed;
  dock.drive_timeout = config.dock.drive_timeout_ms * 1e-3;
  dock.drive_delay = static_cast<int>(std::lround(drive_delay_latches(config)));
  dock.signal_decimation = static_cast<int>(config.report.signal_decimation);
  dock.signal_rows_max = static_cast<int>(config.report.signal_rows_max);
  return dock;
}

}  // namespace cmrc
