#pragma once
// A machine's configuration.
#include <chrono>
#include <cstdint>
#include <vector>

#include "bus_model/config.hpp"
#include "c40/chip/board.hpp"
#include "machine/dsps/slot_links.hpp"
#include "machine/networks/net_description.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/scripted_events.hpp"
#include "machine/time/time.hpp"

namespace machine {

/// Boot method: how a DSP gets its program after reset.
enum class Boot : std::uint8_t {
  preloaded,  ///< the program is in the DSP's memory and is started
  link,       ///< the boot ROM takes the program from the link adapter, to which the host's program has to write it
};

struct Config {
  unsigned dsps = 4;                  ///< DSPs at the start: slots 0 to dsps - 1
  unsigned slots = 0;                 ///< slots in all, at most most_slots; 0: as many as dsps
  std::int64_t chip_hz = 25'000'000;  ///< instruction cycles per second: C40-40 20 M, C40-50 25 M, C40-60 30 M
  std::int64_t chip_hz_denominator = 1;
  c40::Board board =
      c40::Board::default_board();  ///< of every DSP; needs the windows to both buses (BoardError otherwise)
  std::int64_t pci_hz_numerator = 100'000'000;
  std::int64_t pci_hz_denominator = 3;
  std::vector<Skew> chip_skews;  ///< by slot; no skew for slots beyond the list
  std::vector<Skew> bus_skews;   ///< by bus; buses connected by bridges run on one clock, that of the first of them
  Boot boot = Boot::preloaded;
  Word idle_policy = 0;    ///< value of the program's symbol idle_policy: 0 doorbell, 1 pause, 2 spin
  Word pause_count = 125;  ///< value of pause_count
  Topology topology{};
  std::vector<SlotLink> links;       ///< between slots
  std::vector<NetDescription> nets;  ///< between pins of slots
  pci::BusConfig bus{};              ///< of every bus; the names are the topology's
  pci::MasterConfig dsp_master{};
  unsigned first_level_dsps = 0;  ///< with Arbitration::two_level, slots below this share the first level with the host
  pci::MasterConfig host_master{.name = "host"};
  pci::BridgeConfig bridge_a{.prefetch_limit = 0x10000};  ///< from a DSP to shared memory
  pci::BridgeConfig bridge_b{.prefetch_words = 0};        ///< from a DSP to a bus that leads to devices only
  pci::BusBridgeConfig bus_bridge{};
  pci::BridgeConfig host_bridge{.request_sync = 5, .return_sync = 3, .post_depth = 16, .prefetch_words = 0};
  pci::TargetConfig shared_memory = pci::TargetConfig::sram();
  pci::TargetConfig devices = pci::TargetConfig::drive_card();
  pci::Clocks interrupt_clocks =
      2;  ///< 1 to 3 clocks from the end of a doorbell or reset write to the edge on IIOF0 or the reset
  pci::Clocks host_write_clocks = 2;  ///< time of the host's processor to post a word
  bool instant_access = false;  ///< accesses of boards take no time where the target takes them: no bus carries them
  std::int64_t prefetch_hit_cycles = 1;             ///< cycles of a DSP's read that its bridge's line answers
  Time reset_time = std::chrono::microseconds{10};  ///< time for which RESET is low
  std::uint64_t turn_order = 0;  ///< not 0: a seed for the order in which chips run ahead; changes nothing observable
  bool guard = false;  ///< shared memory refuses what a DSP's task may not write (machine/bus_agents/guard.hpp)
  std::vector<ScriptedEvent> script;  ///< in any order
};

/// Completed: with every field set and the script in order of time. \throws std::invalid_argument that says what is
/// wrong
Config checked(Config config);

/// \throws std::invalid_argument for an event that makes no sense at `now`
void require_sense(const ScriptedEvent& event, Time now, const Config& config);

/// The deviations of the clocks of a slot and of a bus.
Skew skew_of_chip(const Config& config, unsigned slot);
Skew skew_of_bus(const Config& config, unsigned bus);
/// By slot; by bus.
std::vector<Clock> clocks_of_chips(const Config& config);
std::vector<Clock> clocks_of_buses(const Config& config);

}  // namespace machine
