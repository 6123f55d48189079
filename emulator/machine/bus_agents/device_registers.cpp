#include "machine/bus_agents/device_registers.hpp"

#include <type_traits>

#include "plant/dock/dock.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {
namespace {

using plant::Dock;

constexpr std::int32_t number(Word value) { return static_cast<std::int32_t>(value); }

// The signed torque code in the low bits of a word, in the format of the drive's converter.
constexpr int torque_code(Word value) {
  constexpr unsigned above = 32 - plant::torque_bits;
  return static_cast<int>(number(value << above) >> above);
}

struct NamedBit {
  std::string_view name;  // symbol of its place in the register
  std::uint32_t of_drive;
};
constexpr std::array status_bits{NamedBit{"DRIVE_READY", plant::drive_ready},
                                 NamedBit{"DRIVE_FAULT", plant::drive_fault}, NamedBit{"DRIVE_LATE", plant::drive_late},
                                 NamedBit{"DRIVE_BRAKE", plant::drive_brake}};
constexpr std::array trip_bits{NamedBit{"TRIP_OVERSPEED", plant::trip_overspeed},
                               NamedBit{"TRIP_SATURATION", plant::trip_saturation},
                               NamedBit{"TRIP_HEAT", plant::trip_heat}, NamedBit{"TRIP_WARNING", plant::trip_warning}};

using Bits = std::array<DeviceConnections::Bit, 4>;

Bits placed(const std::array<NamedBit, 4>& names, const toolchain::Image& program) {
  Bits bits{};
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = {names[i].of_drive, program.symbol(names[i].name)};
  return bits;
}

// One bit of each drive, in one word.
Word collected(const DeviceConnections& cards, const Bits& bits, std::uint32_t (Dock::*say)(int, Time), Time t) {
  Word all = 0;
  for (std::size_t channel = 0; channel < cards.joints.size(); ++channel) {
    const std::uint32_t said = (cards.dock.*say)(cards.joints[channel], t);
    for (const auto& [bit, place] : bits)
      if ((said & bit) != 0) all |= Word{1} << (place + channel);
  }
  return all;
}

std::uint32_t joints_enabled(const DeviceConnections& cards, Word channels) {
  std::uint32_t joints = 0;
  for (std::size_t channel = 0; channel < cards.joints.size(); ++channel)
    joints |= (channels >> channel & 1U) << cards.joints[channel];
  return joints;
}

// Reads a value from the dock; passes the register's index, its ray and the time, as far as the function takes them.
template <auto ask>
Word of_dock(const DeviceConnections& cards, DevicePlace at, Time t) {
  using Ask = decltype(ask);
  if constexpr (std::is_invocable_v<Ask, Dock&, int, int, Time>)
    return static_cast<Word>((cards.dock.*ask)(at.index, at.ray, t));
  else if constexpr (std::is_invocable_v<Ask, Dock&, int, Time>)
    return static_cast<Word>((cards.dock.*ask)(at.index, t));
  else if constexpr (std::is_invocable_v<Ask, Dock&, Time>)
    return static_cast<Word>((cards.dock.*ask)(t));
  else
    return static_cast<Word>((cards.dock.*ask)());
}
// The same for an axis with a symbol of its own.
template <auto ask, int axis>
Word of_axis(const DeviceConnections& cards, DevicePlace, Time t) {
  return static_cast<Word>((cards.dock.*ask)(axis, t));
}
template <auto value>
Word constant(const DeviceConnections&, DevicePlace, Time) {
  return static_cast<Word>(value);
}

Word drive_status(const DeviceConnections& c, DevicePlace, Time t) {
  return collected(c, c.status_bits, &Dock::drive_status, t);
}
Word drive_trip(const DeviceConnections& c, DevicePlace, Time t) {
  return collected(c, c.trip_bits, &Dock::drive_trip, t);
}

void set_torque(DeviceConnections& c, DevicePlace at, Word value, Time t) {
  c.dock.set_torque_code(at.index, torque_code(value), t);
}
void enable_drives(DeviceConnections& c, DevicePlace, Word value, Time t) {
  c.dock.enable_drives(joints_enabled(c, value), t);
}
void command_spreader(DeviceConnections& c, DevicePlace, Word value, Time t) { c.dock.spreader_command(value, t); }
void select_row(DeviceConnections& c, DevicePlace, Word value, Time t) { c.dock.select_row(number(value), t); }
void set_agv_period(DeviceConnections& c, DevicePlace at, Word value, Time t) { c.dock.agv_period(at.index, value, t); }
void set_agv_speed(DeviceConnections& c, DevicePlace at, Word value, Time) {
  c.commands[at.index].speed = number(value);
}
void set_agv_front(DeviceConnections& c, DevicePlace at, Word value, Time) {
  c.commands[at.index].front = number(value);
}
void push_agv(DeviceConnections& c, DevicePlace at, Word value, Time t) {
  const DeviceConnections::AgvCommand& command = c.commands[at.index];
  c.dock.agv_push(at.index, command.speed, command.front, number(value), t);
}

bool has_second_sway(const Dock& dock) { return dock.config().sensors.second_sway; }

constexpr auto drives = DeviceGroup::drives, sensors = DeviceGroup::sensors, comm_port = DeviceGroup::comm_port;

constexpr DeviceRegister registers[] = {
    {"DRIVE_TORQUE", drives, Repeated::channel, nullptr, set_torque},
    {"DRIVE_ENABLE", drives, Repeated::once, nullptr, enable_drives},
    {"ENCODER", drives, Repeated::channel, of_dock<&Dock::encoder>, nullptr},
    {"DRIVE_STATUS", drives, Repeated::once, drive_status, nullptr},
    {"DRIVE_TRIP", drives, Repeated::once, drive_trip, nullptr},
    {"DRIVE_SPEED", drives, Repeated::channel, of_dock<&Dock::drive_speed>, nullptr},
    {"DRIVE_HEAT", drives, Repeated::channel, of_dock<&Dock::drive_heat>, nullptr},
    {"SPREADER_COMMAND", drives, Repeated::once, nullptr, command_spreader},
    {"SPREADER_STATUS", drives, Repeated::once, of_dock<&Dock::spreader_status>, nullptr},
    {"SWAY_ALPHA", sensors, Repeated::once, of_axis<&Dock::sway, 0>, nullptr},
    {"SWAY_BETA", sensors, Repeated::once, of_axis<&Dock::sway, 1>, nullptr},
    {"SWAY2_ALPHA", sensors, Repeated::once, of_axis<&Dock::second_sway, 0>, nullptr, has_second_sway},
    {"SWAY2_BETA", sensors, Repeated::once, of_axis<&Dock::second_sway, 1>, nullptr, has_second_sway},
    {"LOAD_CELL", sensors, Repeated::once, of_dock<&Dock::load_cell>, nullptr},
    {"WIND_MEAN", sensors, Repeated::once, of_dock<&Dock::wind_mean>, nullptr},
    {"SCAN_ROWS", sensors, Repeated::once, of_dock<&Dock::scan_rows>, nullptr},
    {"SCAN_ROW", sensors, Repeated::once, nullptr, select_row},
    {"SCAN_Y", sensors, Repeated::once, of_dock<&Dock::scan_y>, nullptr},
    {"SCAN_X0", sensors, Repeated::once, of_dock<&Dock::scan_x0>, nullptr},
    {"SCAN_DX", sensors, Repeated::once, of_dock<&Dock::scan_dx>, nullptr},
    {"SCAN_DECK", sensors, Repeated::once, of_dock<&Dock::scan_deck>, nullptr},
    {"SCAN_PROFILE", sensors, Repeated::sample, of_dock<&Dock::profile>, nullptr},
    {"AGV_X", comm_port, Repeated::agv, of_dock<&Dock::agv_x>, nullptr},
    {"AGV_Y", comm_port, Repeated::agv, of_dock<&Dock::agv_y>, nullptr},
    {"AGV_HEADING", comm_port, Repeated::agv, of_dock<&Dock::agv_heading>, nullptr},
    {"AGV_SPEED", comm_port, Repeated::agv, of_dock<&Dock::agv_speed>, nullptr},
    {"AGV_STATUS", comm_port, Repeated::agv, of_dock<&Dock::agv_status>, nullptr},
    {"AGV_PERIOD", comm_port, Repeated::agv, nullptr, set_agv_period},
    {"AGV_SPEED_COMMAND", comm_port, Repeated::agv, nullptr, set_agv_speed},
    {"AGV_FRONT_COMMAND", comm_port, Repeated::agv, nullptr, set_agv_front},
    {"AGV_REAR_COMMAND", comm_port, Repeated::agv, nullptr, push_agv},
    {"RANGE_COUNT", sensors, Repeated::range, constant<plant::range_rays>, nullptr},
    {"RANGE_FIRST", sensors, Repeated::range, constant<plant::range_first>, nullptr},
    {"RANGE_STEP", sensors, Repeated::range, constant<plant::range_step>, nullptr},
    {"RANGE_MOUNT", sensors, Repeated::range, of_dock<&Dock::range_mount>, nullptr},
    {"RANGE_SCAN", sensors, Repeated::range, of_dock<&Dock::range_scan>, nullptr},
    {"RANGE_WAY", sensors, Repeated::range, of_dock<&Dock::range_way>, nullptr},
    {"RANGE_RAY", sensors, Repeated::ray, of_dock<&Dock::agv_range>, nullptr},
};

}  // namespace

std::span<const DeviceRegister> device_registers() { return registers; }

std::vector<std::string_view> device_symbols() {
  std::vector<std::string_view> all;
  for (const DeviceRegister& row : registers) all.push_back(row.name);
  for (const NamedBit& bit : status_bits) all.push_back(bit.name);
  for (const NamedBit& bit : trip_bits) all.push_back(bit.name);
  for (const std::string_view name : {"AGV_UNIT", "AGV_UNIT_WORDS", "AGV_RANGE", "AGV_RANGE_WORDS"})
    all.push_back(name);
  return all;
}

DeviceConnections::DeviceConnections(plant::Dock& the_dock, const toolchain::Image& program)
    : dock{the_dock},
      joints{plant::drive_channels(the_dock.config().crane.machine)},
      status_bits{placed(machine::status_bits, program)},
      trip_bits{placed(machine::trip_bits, program)},
      commands(static_cast<std::size_t>(the_dock.agv_count())) {}

std::vector<PlacedRegister> placed_registers(const DeviceConnections& cards, const toolchain::Image& program) {
  std::vector<PlacedRegister> all;
  const auto agvs = static_cast<unsigned>(cards.commands.size());
  for (const DeviceRegister& row : registers) {
    if (row.fitted != nullptr && !row.fitted(cards.dock)) continue;
    const Offset first = program.symbol(row.name);
    const auto place = [&](Offset offset, unsigned index = 0, unsigned ray = 0) {
      all.push_back({&row, first + offset, index, ray});
    };
    const Offset unit = program.symbol("AGV_UNIT"), unit_words = program.symbol("AGV_UNIT_WORDS");
    const Offset range = program.symbol("AGV_RANGE"), range_words = program.symbol("AGV_RANGE_WORDS");
    switch (row.repeated) {
      case Repeated::once: place(0); break;
      case Repeated::channel:
        for (unsigned channel = 0; channel < cards.joints.size(); ++channel)
          place(channel, static_cast<unsigned>(cards.joints[channel]));
        break;
      case Repeated::sample:
        for (unsigned i = 0; i < plant::scan_count; ++i) place(i, i);
        break;
      case Repeated::agv:
        for (unsigned agv = 0; agv < agvs; ++agv) place(unit + agv * unit_words, agv);
        break;
      case Repeated::range:
        for (unsigned agv = 0; agv < agvs; ++agv) place(range + agv * range_words, agv);
        break;
      case Repeated::ray:
        for (unsigned agv = 0; agv < agvs; ++agv)
          for (unsigned ray = 0; ray < plant::range_rays; ++ray) place(range + agv * range_words + ray, agv, ray);
        break;
    }
  }
  return all;
}

}  // namespace machine
