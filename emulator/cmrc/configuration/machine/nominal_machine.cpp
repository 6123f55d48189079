#include "cmrc/configuration/machine/nominal_machine.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cmrc/configuration/machine/machine_topology.hpp"
#include "machine/boards/board_file.hpp"

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

}  // namespace cmrc
