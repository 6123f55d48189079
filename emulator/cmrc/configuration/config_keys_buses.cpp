// Keys of the buses, and of which device is on which.
#include "cmrc/configuration/config_keys.hpp"

namespace cmrc::schema {

std::vector<Key> bus_keys() {
  return {
      number("bus.clock_hz", FIELD(bus.clock_hz), "Hz", 1e6, 133e6, "PCI clock of all buses", "plant-and-bus.md 3.1"),
      integer("bus.latency_timer_clocks", FIELD(bus.latency_timer_clocks), "clocks", 8, 248,
              "latency timer of every master, a multiple of 8", "plant-and-bus.md 3.6"),
      boolean("bus.prefetch", FIELD(bus.prefetch),
              "bridges of the DSPs fill a line of 8 words when they read shared memory", "ruling 25"),
      boolean("bus.fast_back_to_back", FIELD(bus.fast_back_to_back),
              "no turnaround clock between two transactions of one master", "plant-and-bus.md 3.6"),
      choice(
          "bus.topology", FIELD(bus.topology), {"dual", "host_on_both", "sensors_with_host", "single"},
          "the bus of each device: list on A and devices on B; the host on both; sensors and comm port on A; one bus",
          "plant-and-bus.md 3.4"),
      choice("bus.arbiter", FIELD(bus.arbiter), {"round_robin", "fixed", "two_level", "host_fair"},
             "arbitration: round robin; the lowest number first; host and first DSPs before the others; host every "
             "other turn",
             "plant-and-bus.md 3.6"),
      integer("bus.first_level_dsps", FIELD(bus.first_level_dsps), "", 0, 16,
              "with arbiter \"two_level\": DSPs in slots below this share the first level with the host",
              "plant-and-bus.md 3.6"),
      choice("bus.parking", FIELD(bus.parking), {"none", "last_owner", "host"},
             "master that holds the grant on an idle bus", "plant-and-bus.md 3.6"),
      integer("bus.grant_clocks", FIELD(bus.grant_clocks), "clocks", 1, 16, "from request to grant on an idle bus",
              "plant-and-bus.md 3.1"),
      integer("bus.multi_transaction_clocks", FIELD(bus.multi_transaction_clocks), "clocks", 0, 2048,
              "multi-transaction timer: for this time an owner that requests the bus again goes first; 0: none",
              "plant-and-bus.md 3.1"),
      integer("bus.request_off_clocks", FIELD(bus.request_off_clocks), "clocks", 2, 64,
              "time for which a stopped master withdraws its request", "plant-and-bus.md 3.1"),
      integer("bus.think_on_retry_clocks", FIELD(bus.think_on_retry_clocks), "clocks", 0, 1024,
              "further time before a master repeats a refused transaction", "plant-and-bus.md 3.6"),
      integer("bus.max_burst_words", FIELD(bus.max_burst_words), "words", 0, 256,
              "a master ends its bursts after this number of words; 0: never", "plant-and-bus.md 3.6"),
      integer("bus.post_depth_words", FIELD(bus.post_depth_words), "words", 1, 64,
              "posted-write FIFO of a DSP's bridge", "plant-and-bus.md 3.6"),
      choice("bus.shared_memory_card", FIELD(bus.shared_memory_card), {"sram", "s5933", "drive_card", "host_dram"},
             "wait states of shared memory", "plant-and-bus.md 3.6"),
      choice("bus.device_card", FIELD(bus.device_card), {"sram", "s5933", "drive_card", "host_dram"},
             "wait states of the devices", "plant-and-bus.md 3.6"),
      boolean("bus.delayed_reads", FIELD(bus.delayed_reads),
              "delayed reads: devices retry a read until they have fetched the word", "plant-and-bus.md 3.1"),
      integer("bus.delayed_read_clocks", FIELD(bus.delayed_read_clocks), "clocks", 0, 1024,
              "length of a delayed read's fetch", "plant-and-bus.md 3.6"),
      integer("bus.device_post_words", FIELD(bus.device_post_words), "words", 0, 64,
              "length of the devices' queue of posted writes, which refuses writes when full; 0: writes go straight "
              "through",
              "plant-and-bus.md 3.6"),

      text("topology.buses", FIELD(topology.buses),
           "the buses: \"A\" to \"A B C D\"; empty, here and below: as bus.topology says", "plant-and-bus.md 3.4"),
      text("topology.host", FIELD(topology.host), "buses of the host", "plant-and-bus.md 3.4"),
      text("topology.boards", FIELD(topology.boards), "buses of every DSP", "plant-and-bus.md 3.4"),
      text("topology.shared_memory", FIELD(topology.shared_memory), "bus of the shared memory", "plant-and-bus.md 3.4"),
      text("topology.drives", FIELD(topology.drives), "bus of the crane's drives, encoders and spreader",
           "plant-and-bus.md 3.4"),
      text("topology.sensors", FIELD(topology.sensors), "bus of sway, bay and range sensors", "plant-and-bus.md 3.4"),
      text("topology.comm_port", FIELD(topology.comm_port), "bus of the port to the AGVs", "plant-and-bus.md 3.4"),
      text("topology.bridges", FIELD(topology.bridges), "bridges between buses, as in \"A-B, B-C\"",
           "plant-and-bus.md 3.4"),
      integer("topology.drives_at", FIELD(topology.drives_at), "", -1, 0x7FFFFFFF,
              "bus address of window B's offset 0 for the drives; -1: 0, or 100000h beside shared memory",
              "plant-and-bus.md 3.4"),
      integer("topology.sensors_at", FIELD(topology.sensors_at), "", -1, 0x7FFFFFFF,
              "bus address of window B's offset 0 for the sensors; -1: as for the drives", "plant-and-bus.md 3.4"),
      integer("topology.comm_port_at", FIELD(topology.comm_port_at), "", -1, 0x7FFFFFFF,
              "bus address of window B's offset 0 for the comm port; -1: as for the drives", "plant-and-bus.md 3.4"),
  };
}

}  // namespace cmrc::schema
