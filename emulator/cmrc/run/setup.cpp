#include "cmrc/run/setup.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "cmrc/configuration/dock/dock_job.hpp"
#include "cmrc/configuration/dock/nominal_dock.hpp"
#include "cmrc/configuration/machine/clock_deviations.hpp"
#include "cmrc/configuration/machine/nominal_machine.hpp"
#include "cmrc/processes/control_block.hpp"
#include "cmrc/programs/kernels.hpp"
#include "cmrc/programs/straight_ways.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "plant/parameters/check.hpp"

namespace cmrc {

plant::DockConfig dock_of(const Config& config, const toolchain::Image& image, const Words& words) {
  plant::DockConfig dock = nominal_dock_of(config);
  const Oscillators clocks = oscillators_of(config);
  const auto sampled = [](const Oscillator& one) { return plant::SampleClock{one.skew.ppm, one.skew.phase.count()}; };
  dock.sensors.sway_clock = sampled(clocks.sway);
  for (const Oscillator& one : clocks.range) dock.sensors.range_clocks.push_back(sampled(one));
  for (const Oscillator& one : clocks.units) dock.unit_clocks.push_back(sampled(one));
  try {
    plant::check(dock);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(fmt::format("dock.crane: {}", error.what()));
  }
  try {
    check_job(dock, words);
    check_speeds(dock, config, image);
  } catch (const std::invalid_argument& error) {
    const std::string& layout = config.dock.layout;
    throw ConfigError(layout.empty() ? fmt::format("dock.crane: {}", error.what())
                                     : fmt::format("dock.layout: {}: {}", layout, error.what()));
  }
  return dock;
}

CraneJob crane_of(const Config& config, const plant::DockConfig& layout, plant::Dock& dock) {
  const Intervals n = intervals(config);
  CraneJob job;
  job.clearance = config.dock.clearance_m;
  job.slack = config.dock.ramp_slack_m;
  job.ramp_speed = config.dock.ramp_speed_m_s;
  job.settle_limit = config.dock.settle_limit_s;
  job.landing_retries = config.dock.landing_retries_max;
  job.speeds = speed_words(config.control, layout.crane.machine);
  job.refresh_frequency = config.rates.refresh_frequency_hz;
  job.servo_interval = n.servo;
  job.point_interval = n.crane_point;
  job.slowed_interval = n.crane_slowed;
  job.buffer_points = config.scheduling.buffer_points;
  job.too_windy = std::abs(dock.wind_mean(machine::Time{0})) > wind_limit_mm_s(config);
  return job;
}

FleetJob fleet_of(const Config& config, const plant::DockConfig& dock, const Words& words) {
  const Intervals n = intervals(config);
  const auto lanes = [](const std::vector<plant::LaneSegment>& leg) {
    std::vector<Lane> all;
    for (const auto& s : leg) all.push_back({s.x, s.y, s.heading, s.length, s.curvature, s.speed});
    return all;
  };
  FleetJob job;
  job.agvs = static_cast<unsigned>(config.dock.agvs);
  job.to_warehouse = lanes(dock.layout.legs[0]);
  job.to_spot = lanes(dock.layout.legs[1]);
  job.spot_x = dock.layout.spot.x;
  job.spot_y = dock.layout.spot.y;
  job.spot_heading = dock.layout.spot.heading;
  job.slot_spacing = dock.layout.slot_spacing;
  job.warehouse_take = dock.layout.warehouse_take;
  job.point_frequency = config.rates.refresh_frequency_hz / static_cast<double>(n.agv_point);
  job.refresh_frequency = config.rates.refresh_frequency_hz;
  job.interval = n.agv_slowed;
  job.buffer_points =
      config.scheduling.agv_buffer_points != 0 ? config.scheduling.agv_buffer_points : config.scheduling.buffer_points;
  job.avoidance_cycles = config.load.avoidance_cycles;
  job.driving = config.load.driving;
  job.parked = config.load.parked;
  for (unsigned slot = 0; job.driving && slot < job.agvs; ++slot) {
    if (const std::size_t pieces = round_from(job, slot).size(); pieces > words.segments_max) {
      throw ConfigError(
          fmt::format("load.driving: the round from slot {} past the warehouse and back has {} pieces of lane; at most "
                      "{} are expected, or load.driving = false",
                      slot, pieces, words.segments_max));
    }
  }
  const AvoidanceBuild build = config.kernels.avoidance;
  job.avoidance = build != AvoidanceBuild::none && (build != AvoidanceBuild::synthetic || job.avoidance_cycles > 0);
  return job;
}

machine::Config machine_of(const Config& config) {
  machine::Config machine = nominal_machine_of(config);
  const Oscillators clocks = oscillators_of(config);
  for (const Oscillator& one : clocks.dsps) machine.chip_skews.push_back(one.skew);
  for (const Oscillator& one : clocks.buses) machine.bus_skews.push_back(one.skew);
  return machine;
}

std::vector<AreaWord> initial_words(const Config& config, const plant::DockConfig& layout, const Words& w,
                                    plant::Dock& dock) {
  const Intervals n = intervals(config);
  const double f_s = config.rates.refresh_frequency_hz;
  std::vector<AreaWord> all;
  const auto put = [&](Word offset, Word value) { all.push_back({w.cr_base + offset, value}); };
  const auto put_float = [&](Word offset, double value) { put(offset, ti_float(value)); };
  put_float(w.cr_point_period, static_cast<double>(n.crane_point) / f_s);
  put_float(w.cr_servo_period, static_cast<double>(n.servo) / f_s);
  put(w.cr_point_ticks, static_cast<Word>(n.crane_point));
  put(w.cr_servo_ticks, static_cast<Word>(n.servo));
  ControlBlock(config, w).initial(put);
  for (Word i = 0; const Word word : speed_words(config.control, layout.crane.machine)) put(w.cr_speed + i++, word);
  put_float(w.cr_load, layout.crane.spreader_mass);
  put(w.cr_agv, w.agv_unit);
  put_float(w.cr_clearance, config.dock.clearance_m);
  put_float(w.cr_agv_deck, layout.agv.deck_height);
  put_float(w.cr_box_height, plant::container_height);
  put_float(w.cr_ramp_start + 2, 0);
  put_float(w.cr_ramp_start + 3, 0);
  const double home[] = {layout.home.x, layout.home.y, layout.home.z, layout.home.yaw};
  for (Word i = 0; i < 4; ++i) put_float(w.cr_home + i, home[i]);
  const double spot[] = {layout.layout.spot.x, layout.layout.spot.y, layout.layout.spot.heading};
  for (Word i = 0; i < 3; ++i) put_float(w.cr_spot + i, spot[i]);
  Word channel = 0;
  for (const int joint : plant::drive_channels(layout.crane.machine)) {
    put(w.cr_encoder_last + channel, dock.encoder(joint, plant::Time{}));
    put(w.cr_encoder_total + channel, static_cast<Word>(dock.encoder_total(joint, plant::Time{})));
    ++channel;
  }
  for (std::size_t i = 0; i < config.tasks.size(); ++i) {
    const auto& parameters = config.tasks[i].parameters;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const auto* real = std::get_if<double>(&parameters[k]);
      all.push_back({w.us_base + static_cast<Word>(i) * w.us_words + static_cast<Word>(k),
                     real != nullptr ? ti_float(*real) : static_cast<Word>(std::get<std::int64_t>(parameters[k]))});
    }
  }
  if (config.scheduling.slice_cycles > 0)
    all.push_back({w.slice_cycles, static_cast<Word>(config.scheduling.slice_cycles)});
  put(w.cr_box_count, static_cast<Word>(layout.layout.no_go.size()));
  Word side = w.cr_box;
  for (const plant::Box& box : layout.layout.no_go)
    for (const double place : {box.x_min, box.x_max, box.y_min, box.y_max, box.z_min, box.z_max})
      put_float(side++, place);
  return all;
}

}  // namespace cmrc
