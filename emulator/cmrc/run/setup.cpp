#include "cmrc/run/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "cmrc/configuration/clock_deviations.hpp"
#include "cmrc/configuration/dock_job.hpp"
#include "cmrc/configuration/machine_topology.hpp"
#include "cmrc/programs/kernels.hpp"
#include "cmrc/programs/servo_law.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "machine/boards/board_file.hpp"
#include "plant/parameters/check.hpp"
#include "plant/parameters/layout_file.hpp"

namespace cmrc {

namespace {

std::int64_t instruction_cycles_per_second(DspClock clock) {
  switch (clock) {
    case DspClock::c40_40: return 20'000'000;
    case DspClock::c40_50: return 25'000'000;
    case DspClock::c40_60: return 30'000'000;
  }
  return 25'000'000;
}

}  // namespace

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
  dock.drive_delay = static_cast<int>(std::lround(config.dock.drive_delay_us / 125));
  dock.signal_decimation = static_cast<int>(config.report.signal_decimation);
  dock.signal_rows_max = static_cast<int>(config.report.signal_rows_max);
  return dock;
}

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

namespace {

pci::TargetConfig target_of(Card card) {
  switch (card) {
    case Card::sram: return pci::TargetConfig::sram();
    case Card::s5933: return pci::TargetConfig::s5933();
    case Card::drive_card: return pci::TargetConfig::drive_card();
    case Card::host_dram: return pci::TargetConfig::host_dram();
  }
  return {};
}

void set_buses(const Config& config, machine::Config& machine) {
  const Config::Bus& bus = config.bus;
  machine.topology = topology_of(config);
  machine.links = machine::parse_slot_links(config.machine.links);
  machine.nets = machine::parse_slot_nets(config.machine.nets, machine.slots != 0 ? machine.slots : machine.dsps);
  machine.bus.fast_back_to_back = bus.fast_back_to_back;
  machine.bus.arbitration = static_cast<pci::Arbitration>(bus.arbiter);
  machine.bus.parking = static_cast<pci::Parking>(bus.parking);
  machine.bus.grant_clocks = bus.grant_clocks;
  machine.bus.multi_transaction_timer = bus.multi_transaction_clocks;
  machine.first_level_dsps = static_cast<unsigned>(bus.first_level_dsps);
  for (pci::MasterConfig* master : {&machine.dsp_master, &machine.host_master}) {
    master->latency_timer = bus.latency_timer_clocks;
    master->request_off_after_stop = bus.request_off_clocks;
    master->think_on_retry = bus.think_on_retry_clocks;
    master->max_burst = static_cast<unsigned>(bus.max_burst_words);
  }
  machine.bridge_a.post_depth = machine.bridge_b.post_depth = static_cast<unsigned>(bus.post_depth_words);
  if (!bus.prefetch) machine.bridge_a.prefetch_words = 0;
  machine.shared_memory = target_of(bus.shared_memory_card);
  machine.devices = target_of(bus.device_card);
  machine.devices.delayed_read = bus.delayed_reads;
  machine.devices.fetch = bus.delayed_read_clocks;
  machine.devices.post_words = static_cast<unsigned>(bus.device_post_words);
}

}  // namespace

machine::Config nominal_machine_of(const Config& config) {
  machine::Config machine;
  machine.dsps = static_cast<unsigned>(config.machine.dsps);
  machine.slots = static_cast<unsigned>(std::max(config.machine.dsps, config.machine.slots));
  const machine::BoardDescription board = machine::read_board(config.machine.board);
  machine::refuse_devices(board, "the dock");
  machine::refuse_ignored(board);
  machine.board = board.board;
  machine.chip_hz = board.clock_mhz ? machine::instruction_cycles_per_second(*board.clock_mhz)
                                    : instruction_cycles_per_second(config.machine.dsp_clock);
  // An ideal run of a slow board is as instant as any other.
  if (config.run.ideal) machine.chip_hz = std::max(machine.chip_hz, instruction_cycles_per_second(DspClock::c40_40));
  const std::int64_t thousandths = std::llround(config.machine.cycle_time_factor * 1000);
  const std::int64_t divisor = std::gcd(machine.chip_hz * 1000, thousandths);
  machine.chip_hz = machine.chip_hz * 1000 / divisor;
  machine.chip_hz_denominator = thousandths / divisor;
  // Thirds of a hertz represent PCI's 33 1/3 MHz exactly.
  machine.pci_hz_numerator = std::llround(config.bus.clock_hz * 3);
  machine.pci_hz_denominator = 3;
  if (config.run.ideal) machine.chip_hz *= ideal_speed, machine.pci_hz_numerator *= ideal_speed;
  machine.instant_access = config.run.ideal;
  machine.boot = static_cast<machine::Boot>(config.machine.boot);
  machine.idle_policy = static_cast<machine::Word>(config.machine.idle_policy);
  machine.pause_count = static_cast<machine::Word>(config.machine.pause_nops);
  set_buses(config, machine);
  machine.guard = config.machine.guard;
  machine.turn_order = static_cast<std::uint64_t>(config.run.turn_order);
  for (const TimedEvent& event : config.events) {
    if (const auto scripted = scripted_event(event)) machine.script.push_back(*scripted);
  }
  return machine;
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
