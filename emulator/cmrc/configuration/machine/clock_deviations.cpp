#include "cmrc/configuration/machine/clock_deviations.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "cmrc/configuration/dock/nominal_dock.hpp"
#include "cmrc/configuration/machine/nominal_machine.hpp"
#include "plant/dock/sensors.hpp"

namespace cmrc {
namespace {

// FNV-1a over seed and name, then splitmix64's mixing: the bits of one draw.
std::uint64_t bits_of_name(std::uint64_t seed, std::string_view name, std::uint64_t draw) {
  std::uint64_t h = 0xCBF29CE484222325ULL;
  const auto eat = [&h](std::uint64_t byte) { h = (h ^ byte) * 0x100000001B3ULL; };
  for (int i = 0; i < 8; ++i) eat(seed >> (8 * i) & 0xFF);
  for (const char c : name) eat(static_cast<unsigned char>(c));
  h += 0x9E3779B97F4A7C15ULL * (draw + 1);
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
  return h ^ (h >> 31);
}

class Draw {
 public:
  explicit Draw(const Config& config)
      : on_(config.run.phase_jitter), seed_(static_cast<std::uint64_t>(config.run.seed)) {}

  static Oscillator nominal(std::string name, std::int64_t hertz, std::int64_t per) {
    return {std::move(name), hertz, per, {}};
  }

  Oscillator operator()(std::string name, std::int64_t hertz, std::int64_t per = 1) const {
    Oscillator one = nominal(std::move(name), hertz, per);
    if (!on_) return one;
    one.skew.ppm = static_cast<std::int64_t>(bits_of_name(seed_, one.name, 0) % (2 * most_ppm + 1)) - most_ppm;
    try {
      const machine::Time period = machine::Skew{one.skew.ppm, machine::Time{0}}.clock(hertz, per).at(1);
      const std::uint64_t bits = bits_of_name(seed_, one.name, 1);
      one.skew.phase = machine::Time{static_cast<std::int64_t>(bits % static_cast<std::uint64_t>(period.count()))};
    } catch (const std::invalid_argument&) {
      throw ConfigError(
          fmt::format("run.phase_jitter: {} at {}/{} Hz and {} ppm cannot be represented exactly; "
                      "run.phase_jitter = false, or a frequency in whole hertz, is expected",
                      one.name, hertz, per, one.skew.ppm));
    }
    return one;
  }

 private:
  bool on_;
  std::uint64_t seed_;
};

}  // namespace

std::vector<Oscillator> Oscillators::all() const {
  std::vector<Oscillator> list{host};
  const auto add = [&](const std::vector<Oscillator>& more) { list.insert(list.end(), more.begin(), more.end()); };
  add(buses);
  add(dsps);
  list.push_back(sway);
  add(range);
  add(units);
  return list;
}

Oscillators oscillators_of(const Config& config) {
  const Draw draw(config);
  const machine::Config machine = nominal_machine_of(config);
  const plant::SensorParameters sensors = nominal_dock_of(config).sensors;
  // Millihertz are fine enough for any typed rate, and keep the timer's clock rational (ruling 1).
  Oscillators all{.host = draw("host timer", std::llround(config.rates.refresh_frequency_hz * 1000), 1000),
                  .buses = {},
                  .dsps = {},
                  .sway = draw("sway sensor", 100),
                  .range = {},
                  .units = {}};
  // In the ideal run the machine's clocks have no deviation; releases and samples keep the clocks of the run.
  const auto of_machine = [&](std::string name, std::int64_t hertz, std::int64_t per) {
    return config.run.ideal ? Draw::nominal(std::move(name), hertz, per) : draw(std::move(name), hertz, per);
  };
  for (const std::string& bus : machine.topology.buses) {
    all.buses.push_back(of_machine("PCI " + bus, machine.pci_hz_numerator, machine.pci_hz_denominator));
  }
  for (unsigned slot = 0; slot < machine.slots; ++slot) {
    all.dsps.push_back(of_machine(fmt::format("DSP {}", slot), machine.chip_hz, machine.chip_hz_denominator));
  }
  for (std::int64_t agv = 0; agv < config.dock.agvs; ++agv) {
    if (sensors.range_rate > 0) {
      all.range.push_back(draw(fmt::format("range sensor {}", agv), plant::range_millihertz(sensors), 1000));
    }
    all.units.push_back(draw(fmt::format("AGV unit {}", agv), 100));
  }
  return all;
}

double unit_draw(std::uint64_t seed, std::string_view name, std::uint64_t count) {
  return static_cast<double>(bits_of_name(seed, name, count) >> 11) * 0x1p-53;
}

}  // namespace cmrc
