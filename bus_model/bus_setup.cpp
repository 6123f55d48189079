// What is on a bus: cards, masters, targets.
#include <bit>
#include <stdexcept>

#include "bus_model/bus.hpp"
#include "bus_model/bus_parts.hpp"

namespace pci {
namespace {

void require(bool good, const std::string& what) {
  if (!good) throw std::invalid_argument{what};
}

}  // namespace

TargetConfig TargetConfig::sram() { return {}; }

TargetConfig TargetConfig::s5933() {
  TargetConfig config;
  config.read_initial = 8, config.write_initial = 2, config.read_step = config.write_step = 1;
  return config;
}

TargetConfig TargetConfig::drive_card() {
  TargetConfig config;
  config.read_initial = 6, config.write_initial = 2, config.max_burst = 8;
  return config;
}

TargetConfig TargetConfig::host_dram() {
  TargetConfig config;
  config.read_initial = 12, config.write_initial = 3, config.max_burst = 8;
  return config;
}

Bus::Bus(BusConfig config) : config_{std::move(config)}, arbiter_{config_} {
  require(config_.grant_clocks >= 1, "bus " + config_.name + ": grant_clocks is at least 1");
  require(config_.multi_transaction_timer >= 0 && config_.multi_transaction_timer <= 2048,
          "bus " + config_.name + ": multi_transaction_timer is 0 to 2048 clocks");
  require(std::has_single_bit(config_.line_words), "bus " + config_.name + ": line_words is a power of two");
}

Bus::~Bus() = default;

unsigned Bus::add_master(const MasterConfig& config, Initiator& initiator) {
  require(ports_.size() < most_masters, "bus " + config_.name + ": at most 32 masters");
  require(config.latency_timer >= 8 && config.latency_timer <= 248 && config.latency_timer % 8 == 0,
          "master " + config.name + ": latency_timer is 8 to 248 clocks, a multiple of 8");
  require(config.request_off_after_stop >= 2,
          "master " + config.name + ": PCI 2.1 has REQ# dropped for at least 2 clocks after a stop");
  require(config.think_on_retry >= 0, "master " + config.name + ": think_on_retry is at least 0");
  Port port;
  port.config = config;
  port.initiator = &initiator;
  port.data.resize(most_words);
  ports_.push_back(std::move(port));
  requests_.push_back(never);
  arbiter_.add_master(config.first_level);
  return static_cast<unsigned>(ports_.size() - 1);
}

unsigned Bus::add_target(const TargetConfig& config, Target& target, Address base, std::uint64_t words) {
  const std::string who = "target " + config.name + ": ";
  require(config.devsel >= 1 && config.devsel <= 3, who + "devsel is 1 (fast), 2 (medium) or 3 (slow)");
  require(config.read_initial >= 0 && config.devsel + config.read_initial <= 16,
          who + "PCI 2.1 wants the first data phase within 16 clocks: devsel + read_initial <= 16");
  require(config.write_initial >= 0 && config.devsel + config.write_initial <= 16,
          who + "PCI 2.1 wants the first data phase within 16 clocks: devsel + write_initial <= 16");
  require(config.read_step >= 0 && config.read_step <= 7 && config.write_step >= 0 && config.write_step <= 7,
          who + "PCI 2.1 wants later data phases within 8 clocks: read_step and write_step <= 7");
  require(config.fetch >= 0 && config.post_drain >= 1, who + "fetch is at least 0 and post_drain at least 1");
  require(words > 0 && base + words <= (std::uint64_t{1} << 32), who + "a window lies within 2^32 words");
  for (const Window& other : windows_)
    require(base + words <= other.base || other.base + other.words <= base,
            who + "its window overlaps that of " + other.config.name);
  const bool takes_all = target.takes_all() && config.max_burst == 0 && config.post_words == 0 && !config.delayed_read;
  windows_.push_back(Window{
      .config = config, .target = &target, .base = base, .words = words, .takes_all = takes_all, .statistics = {}});
  return static_cast<unsigned>(windows_.size() - 1);
}

std::span<Word> Bus::buffer(unsigned master) { return ports_.at(master).data; }
bool Bus::busy(unsigned master) const { return ports_.at(master).active; }
unsigned Bus::masters() const { return static_cast<unsigned>(ports_.size()); }
unsigned Bus::targets() const { return static_cast<unsigned>(windows_.size()); }
const MasterConfig& Bus::master_config(unsigned master) const { return ports_.at(master).config; }
const std::string& Bus::master_name(unsigned master) const { return ports_.at(master).config.name; }
const std::string& Bus::target_name(unsigned target) const { return windows_.at(target).config.name; }
const MasterStatistics& Bus::master_statistics(unsigned master) const { return ports_.at(master).statistics; }
const TargetStatistics& Bus::target_statistics(unsigned target) const { return windows_.at(target).statistics; }

}  // namespace pci
