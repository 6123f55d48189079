#include "machine/devices.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "plant/dock.hpp"

namespace machine {

namespace {

// Signed 12 bits in the low bits of a word, as the drive's converter takes them.
constexpr int torque_code(Word value) { return static_cast<int>(static_cast<std::int32_t>(value << 20) >> 20); }

constexpr Word word(std::int32_t value) { return static_cast<Word>(value); }

}  // namespace

Devices::Devices(const Symbols& symbols, plant::Dock& dock, const std::array<Clock, device_groups>& clocks, const Fence& fence)
    : dock_{dock}, clocks_{clocks}, fence_{fence}, channels_{plant::drive_channels(dock.config().crane.machine)} {
  const Symbols& s = symbols;
  for (unsigned channel = 0; channel < channels_.size(); ++channel) {
    define(s.drive_torque + channel, Kind::drive_torque, static_cast<unsigned>(channels_[channel]));
    define(s.encoder + channel, Kind::encoder, static_cast<unsigned>(channels_[channel]));
    define(s.drive_speed + channel, Kind::drive_speed, static_cast<unsigned>(channels_[channel]));
    define(s.drive_heat + channel, Kind::drive_heat, static_cast<unsigned>(channels_[channel]));
  }
  define(s.drive_status, Kind::drive_status);
  status_bits_ = {{{plant::drive_ready, s.drive_ready}, {plant::drive_fault, s.drive_fault}, {plant::drive_late, s.drive_late}, {plant::drive_brake, s.drive_brake}}};
  define(s.drive_trip, Kind::drive_trip);
  trip_bits_ = {{{plant::trip_overspeed, s.trip_overspeed}, {plant::trip_saturation, s.trip_saturation}, {plant::trip_heat, s.trip_heat}, {plant::trip_warning, s.trip_warning}}};
  define(s.drive_enable, Kind::drive_enable);
  define(s.sway_alpha, Kind::sway, 0);
  define(s.sway_beta, Kind::sway, 1);
  if (dock.config().sensors.second_sway) {
    define(s.sway2_alpha, Kind::second_sway, 0);
    define(s.sway2_beta, Kind::second_sway, 1);
  }
  define(s.load_cell, Kind::load_cell);
  define(s.wind_mean, Kind::wind_mean);
  define(s.spreader_command, Kind::spreader_command);
  define(s.spreader_status, Kind::spreader_status);
  define(s.scan_rows, Kind::scan_rows);
  define(s.scan_row, Kind::scan_row);
  define(s.scan_y, Kind::scan_y);
  define(s.scan_x0, Kind::scan_x0);
  define(s.scan_dx, Kind::scan_dx);
  define(s.scan_deck, Kind::scan_deck);
  for (unsigned i = 0; i < s.scan_count; ++i) define(s.scan_profile + i, Kind::scan_profile, i);
  const auto agvs = static_cast<unsigned>(dock.agv_count());
  commands_.resize(agvs);
  for (unsigned agv = 0; agv < agvs; ++agv) {
    const Offset unit = s.agv_unit + agv * s.agv_unit_words;
    define(unit + s.agv_x, Kind::agv_x, agv);
    define(unit + s.agv_y, Kind::agv_y, agv);
    define(unit + s.agv_heading, Kind::agv_heading, agv);
    define(unit + s.agv_speed, Kind::agv_speed, agv);
    define(unit + s.agv_status, Kind::agv_status, agv);
    define(unit + s.agv_period, Kind::agv_period, agv);
    define(unit + s.agv_speed_command, Kind::agv_speed_command, agv);
    define(unit + s.agv_front_command, Kind::agv_front_command, agv);
    define(unit + s.agv_rear_command, Kind::agv_rear_command, agv);
    const Offset range = s.agv_range + agv * s.agv_range_words;
    define(range + s.range_count, Kind::range_count, agv);
    define(range + s.range_first, Kind::range_first, agv);
    define(range + s.range_step, Kind::range_step, agv);
    define(range + s.range_mount, Kind::range_mount, agv);
    define(range + s.range_scan, Kind::range_scan, agv);
    define(range + s.range_way, Kind::range_way, agv);
    for (unsigned ray = 0; ray < s.range_rays; ++ray) define(range + s.range_ray + ray, Kind::range_ray, agv, ray);
  }
}

void Devices::define(Offset offset, Kind kind, unsigned index, unsigned ray) {
  if (offset > 0xFFFF || index > 255 || ray > 255)
    throw std::invalid_argument{"the DSP program: devices on bus B lie at offsets 0 to FFFFh"};
  if (offset >= registers_.size()) registers_.resize(offset + 1);
  if (registers_[offset].kind != Kind::none)
    throw std::invalid_argument{"the DSP program: two devices share offset " + std::to_string(offset) + " of bus B"};
  registers_[offset] = {kind, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(ray)};
}

pci::Answer Devices::answer(pci::Address offset, unsigned words, bool write, const pci::Access&) {
  for (unsigned i = 0; i < words; ++i)
    if (!answers(offset + i, write)) return pci::Answer::abort;
  return pci::Answer::accept;
}

Word Devices::read(pci::Address offset, const pci::Access& access) {
  const Register& r = registers_[offset];
  const Time t = clocks_[static_cast<std::size_t>(r.group())].at(access.clock);
  const int index = r.index;
  switch (r.kind) {
    case Kind::encoder: return dock_.encoder(index, t);
    case Kind::sway: return word(dock_.sway(index, t));
    case Kind::second_sway: return word(dock_.second_sway(index, t));
    case Kind::load_cell: return word(dock_.load_cell(t));
    case Kind::wind_mean: return word(dock_.wind_mean(t));
    case Kind::drive_status: return drive_status(t);
    case Kind::drive_trip: return drive_trip(t);
    case Kind::drive_heat: return word(dock_.drive_heat(index, t));
    case Kind::drive_speed: return word(dock_.drive_speed(index, t));
    case Kind::spreader_status: return dock_.spreader_status(t);
    case Kind::scan_rows: return word(dock_.scan_rows());
    case Kind::scan_y: return word(dock_.scan_y(t));
    case Kind::scan_x0: return word(dock_.scan_x0());
    case Kind::scan_dx: return word(dock_.scan_dx());
    case Kind::scan_deck: return word(dock_.scan_deck());
    case Kind::scan_profile: return word(dock_.profile(index, t));
    case Kind::agv_x: return word(dock_.agv_x(index, t));
    case Kind::agv_y: return word(dock_.agv_y(index, t));
    case Kind::agv_heading: return word(dock_.agv_heading(index, t));
    case Kind::agv_speed: return word(dock_.agv_speed(index, t));
    case Kind::agv_status: return dock_.agv_status(index, t);
    case Kind::range_count: return plant::range_rays;
    case Kind::range_first: return word(plant::range_first);
    case Kind::range_step: return word(plant::range_step);
    case Kind::range_mount: return word(dock_.range_mount());
    case Kind::range_scan: return dock_.range_scan(index, t);
    case Kind::range_way: return word(dock_.range_way(index, t));
    case Kind::range_ray: return word(dock_.agv_range(index, r.ray, t));
    default: throw std::logic_error{"Devices::read of a register that answer() refuses"};
  }
}

void Devices::write(pci::Address offset, Word value, const pci::Access& access) {
  if (!is_host(access.agent) && fence_.closed(access.agent - 1)) return;
  const Register& r = registers_[offset];
  const Time t = clocks_[static_cast<std::size_t>(r.group())].at(access.clock);
  const int index = r.index;
  const auto number = static_cast<std::int32_t>(value);
  switch (r.kind) {
    case Kind::drive_torque: return dock_.set_torque_code(index, torque_code(value), t);
    case Kind::drive_enable: return dock_.enable_drives(joints_enabled(value), t);
    case Kind::spreader_command: return dock_.spreader_command(value, t);
    case Kind::scan_row: return dock_.select_row(number, t);
    case Kind::agv_period: return dock_.agv_period(index, value, t);
    case Kind::agv_speed_command: commands_[r.index].speed = number; return;
    case Kind::agv_front_command: commands_[r.index].front = number; return;
    case Kind::agv_rear_command:
      return dock_.agv_push(index, commands_[r.index].speed, commands_[r.index].front, number, t);
    default: throw std::logic_error{"Devices::write of a register that answer() refuses"};
  }
}

Word Devices::collected(const std::array<StatusBit, 4>& places, std::uint32_t (plant::Dock::*say)(int, Time), Time t) const {
  Word all = 0;
  for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
    const std::uint32_t said = (dock_.*say)(channels_[channel], t);
    for (const auto& [bit, place] : places)
      if ((said & bit) != 0) all |= Word{1} << (place + channel);
  }
  return all;
}

Word Devices::drive_status(Time t) const { return collected(status_bits_, &plant::Dock::drive_status, t); }
Word Devices::drive_trip(Time t) const { return collected(trip_bits_, &plant::Dock::drive_trip, t); }

std::uint32_t Devices::joints_enabled(Word channels) const {
  std::uint32_t joints = 0;
  for (std::size_t channel = 0; channel < channels_.size(); ++channel) joints |= (channels >> channel & 1U) << channels_[channel];
  return joints;
}

DeviceGroup Devices::Register::group() const {
  switch (kind) {
    case Kind::drive_torque:
    case Kind::drive_enable:
    case Kind::encoder:
    case Kind::drive_status:
    case Kind::drive_speed:
    case Kind::drive_trip:
    case Kind::drive_heat:
    case Kind::spreader_command:
    case Kind::spreader_status: return DeviceGroup::drives;
    case Kind::agv_period:
    case Kind::agv_speed_command:
    case Kind::agv_front_command:
    case Kind::agv_rear_command:
    case Kind::agv_x:
    case Kind::agv_y:
    case Kind::agv_heading:
    case Kind::agv_speed:
    case Kind::agv_status: return DeviceGroup::comm_port;
    default: return DeviceGroup::sensors;
  }
}

std::vector<Devices::Stretch> Devices::stretches() const {
  std::vector<Stretch> all;
  for (Offset offset = 0; offset < size(); ++offset) {
    const Register& one = registers_[offset];
    if (all.empty()) all.push_back({one.kind == Kind::none ? DeviceGroup::drives : one.group(), offset, offset});
    if (one.kind != Kind::none && one.group() != all.back().group) all.push_back({one.group(), offset, offset});
    all.back().end = offset + 1;
  }
  return all;
}

void Devices::append_state(std::vector<std::uint64_t>& words) const {
  for (const AgvCommand& command : commands_) {
    words.push_back(static_cast<std::uint32_t>(command.speed));
    words.push_back(static_cast<std::uint32_t>(command.front));
  }
}

}  // namespace machine
