// The schema: one entry per key. docs/configuration.md lists the same keys, and a test compares the two.
#include <limits>

#include "cmrc/configuration/config.hpp"

namespace cmrc {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// Gives the member of Config, so that one entry can both read and write it.
template <class T>
using Member = T& (*)(Config&);

/// \param get a Member, or the like with a state of its own
template <class T, class Get>
Key entry(Key::Type type, std::string name, Get get, std::string unit, double minimum, double maximum,
          std::string meaning, std::string source) {
  return {std::move(name),
          type,
          std::move(unit),
          minimum,
          maximum,
          {},
          std::move(meaning),
          std::move(source),
          [get](Config& config, const Value& value) { get(config) = std::get<T>(value); },
          [get](const Config& config) { return Value{get(const_cast<Config&>(config))}; }};
}

// No templates: a key has many neighbours, and each would be compiled anew.
Key integer(std::string name, Member<std::int64_t> get, std::string unit, double minimum, double maximum,
            std::string meaning, std::string source) {
  return entry<std::int64_t>(Key::Type::integer, std::move(name), get, std::move(unit), minimum, maximum,
                             std::move(meaning), std::move(source));
}

Key number(std::string name, Member<double> get, std::string unit, double minimum, double maximum, std::string meaning,
           std::string source) {
  return entry<double>(Key::Type::number, std::move(name), get, std::move(unit), minimum, maximum, std::move(meaning),
                       std::move(source));
}

Key boolean(std::string name, Member<bool> get, std::string meaning, std::string source) {
  return entry<bool>(Key::Type::boolean, std::move(name), get, "", 0, 1, std::move(meaning), std::move(source));
}

Key text(std::string name, Member<std::string> get, std::string meaning, std::string source) {
  return entry<std::string>(Key::Type::text, std::move(name), get, "", 0, 0, std::move(meaning), std::move(source));
}

/// `choices` in the order of the enumeration's values.
template <class Get>
Key choice(std::string name, Get get, std::vector<std::string> choices, std::string meaning, std::string source) {
  using Enum = std::remove_reference_t<decltype(get(std::declval<Config&>()))>;
  auto assign = [get, choices](Config& config, const Value& value) {
    for (std::size_t i = 0; i < choices.size(); ++i) {
      if (choices[i] == std::get<std::string>(value)) get(config) = static_cast<Enum>(i);
    }
  };
  auto read = [get, choices](const Config& config) {
    return Value{choices[static_cast<std::size_t>(get(const_cast<Config&>(config)))]};
  };
  return {std::move(name),   Key::Type::choice, "", 0, 0, std::move(choices), std::move(meaning), std::move(source),
          std::move(assign), std::move(read)};
}

/// The same key, marked as changeable by an operator during a run.
Key live(Key key) {
  key.live = true;
  return key;
}

#define FIELD(path) [](Config& c) -> auto& { return c.path; }

std::vector<Key> make_keys() {
  return {
      number("run.duration_s", FIELD(run.duration_s), "s", 1e-6, 86400, "simulated time", "ruling 13"),
      integer("run.seed", FIELD(run.seed), "", 0, no_limit, "seed of everything random", "ruling 3"),
      integer("run.turn_order", FIELD(run.turn_order), "", 0, no_limit,
              "shuffles which chip the emulator advances first; must change nothing", "ruling 29"),
      boolean("run.strict", FIELD(run.strict),
              "a missed deadline, or an error that had to be handled, makes the run fail (exit status 1)",
              "rulings 24, 36"),
      choice("run.until", FIELD(run.until), {"duration", "job_done"},
             "end of the run: after duration_s, or when processes 7 and 8 of all robots have ended (at the latest "
             "after duration_s)",
             "docs/report.md"),
      number("run.after_stop_s", FIELD(run.after_stop_s), "s", 0, 3600,
             "when the last DSP has failed, the plant has a fault, or all drives of the crane have been off for this "
             "time, deadlines are no longer counted; the plant then continues, braked, for this time, but not beyond "
             "duration_s",
             "docs/report.md"),
      boolean("run.ideal", FIELD(run.ideal),
              "instant execution: DSPs and buses a thousand times as fast, no host time, nothing of the machine fails "
              "(docs/report.md, Ideal)",
              "plant-and-bus.md 5"),

      boolean("run.phase_jitter", FIELD(run.phase_jitter),
              "host's timer, PCI buses, DSPs, sway and range sensors and AGV units each have a clock of their own: a "
              "phase and whole ppm up to 100, drawn by run.seed (docs/architecture.md)",
              "ruling 40"),

      integer("machine.dsps", FIELD(machine.dsps), "", 1, 16, "number of DSPs, in slots 0 upwards", "paper 1"),
      integer("machine.slots", FIELD(machine.slots), "", 0, 16,
              "number of slots for DSP boards, so that boards can be plugged in later; 0: as many as DSPs", "paper 1"),
      choice("machine.dsp_clock", FIELD(machine.dsp_clock), {"C40-40", "C40-50", "C40-60"},
             "speed grade: instruction cycles of 50, 40 or 33.3 ns", "C40 data sheet SPRS038"),
      number("machine.cycle_time_factor", FIELD(machine.cycle_time_factor), "", 0.01, 100,
             "factor on the length of an instruction cycle; the buses' clocks do not change; exact to thousandths",
             "issue 6"),
      choice("machine.boot", FIELD(machine.boot), {"preloaded", "link"},
             "boot method: the program is in the DSP's memory, or the host sends it through the link adapter to the "
             "boot ROM",
             "ruling 27"),
      choice("machine.idle_policy", FIELD(machine.idle_policy), {"doorbell", "pause", "spin"},
             "how a DSP without work waits: IDLE until its doorbell rings, reading the list again after a pause, or "
             "reading it at once",
             "ruling 23"),
      integer("machine.pause_nops", FIELD(machine.pause_nops), "cycles", 1, 1000000,
              "length of the pause of idle_policy \"pause\"", "plant-and-bus.md 3.5"),
      boolean("machine.guard", FIELD(machine.guard),
              "shared memory refuses a DSP's write outside the area of the task that it has claimed; false: it takes "
              "every write",
              "docs/add-a-task.md"),
      text("machine.programs", FIELD(machine.programs),
           "directory of the DSP programs' sources, assembled at the start; empty: the built-in image", "issue 2"),
      text("machine.board", FIELD(machine.board),
           "memories and clock of every DSP's board: default, or a board file (cli.md), whose clock_mhz comes before "
           "dsp_clock",
           "issue 4"),
      text("machine.links", FIELD(machine.links),
           "links between communication ports of two slots, as in \"0.1:1.4, 1.0:2.5\": one of ports 0, 1, 2 with one "
           "of 4, 5",
           "docs/add-a-task.md"),
      text("machine.nets", FIELD(machine.nets),
           "nets between pins of slots, as in \"0.TCLK0>1.IIOF1, 1.IIOF2>0.TCLK1+2.NMI\": drivers, then receivers",
           "docs/add-a-task.md"),

      number("rates.refresh_frequency_hz", FIELD(rates.refresh_frequency_hz), "Hz", 100, 200000,
             "f_s, refreshes of the task-block list", "plant-and-bus.md 2.3"),
      number("rates.servo_frequency_hz", FIELD(rates.servo_frequency_hz), "Hz", 10, 100000,
             "f_p, torque compensation and PID", "plant-and-bus.md 2.3"),
      number("rates.crane_point_frequency_hz", FIELD(rates.crane_point_frequency_hz), "Hz", 1, 10000,
             "f_t, interpolation points of the crane", "plant-and-bus.md 2.3"),
      number("rates.agv_point_frequency_hz", FIELD(rates.agv_point_frequency_hz), "Hz", 1, 10000,
             "f_a, set-points of an AGV at top speed", "plant-and-bus.md 2.3"),

      live(choice("scheduling.equation", FIELD(scheduling.equation), {"restored", "as_printed"},
                  "which reading of equation (7) computes the importance", "paper 6")),
      live(integer("scheduling.gamma_refreshes", FIELD(scheduling.gamma_refreshes), "refreshes", 0, 65535,
                   "gamma: torque compensation and PID become due this much before their tick", "ruling 15")),
      live(integer("scheduling.alpha_refreshes", FIELD(scheduling.alpha_refreshes), "refreshes", 0, 65535,
                   "alpha: trajectory planning becomes due this much before its interval ends", "ruling 15")),
      live(integer("scheduling.beta_refreshes", FIELD(scheduling.beta_refreshes), "refreshes", 0, 65535,
                   "beta: inverse kinematics becomes due this much before its interval ends", "ruling 15")),
      live(integer("scheduling.p", FIELD(scheduling.p), "", 1, 0x7FFE,
                   "p: importance of the crane's planning not yet due", "ruling 15")),
      live(integer("scheduling.q", FIELD(scheduling.q), "", 1, 0x7FFE,
                   "q: importance of the AGV's planning not yet due", "ruling 15")),
      live(integer("scheduling.b", FIELD(scheduling.b), "", 1, 0x7FFE,
                   "b: inverse kinematics above trajectory planning", "ruling 15")),
      live(integer("scheduling.a", FIELD(scheduling.a), "per refresh", 1, 0x7FFE,
                   "a: ageing of the AGV's waiting blocks", "ruling 15")),
      live(integer("scheduling.agv_interval_refreshes", FIELD(scheduling.agv_interval_refreshes), "refreshes", 0, 65535,
                   "N^_a at the start; 0: N_a", "paper 5")),
      live(integer("scheduling.agv_interval_max_refreshes", FIELD(scheduling.agv_interval_max_refreshes), "refreshes",
                   1, 65535, "upper bound of N^_a", "ruling 15")),
      integer("scheduling.buffer_points", FIELD(scheduling.buffer_points), "points", 1, 2,
              "depth of the interpolation buffer", "ruling 15"),
      live(choice("scheduling.servo_reload", FIELD(scheduling.servo_reload), {"locked", "inherited"},
                  "t of a servo block that is put back: counted from the nominal tick, or from its last claim (then "
                  "gamma > 0 speeds the servo up)",
                  "plant-and-bus.md 4.6 item 1")),
      integer("scheduling.agv_buffer_points", FIELD(scheduling.agv_buffer_points), "points", 0, 4,
              "depth of an AGV's interpolation buffer, at most its drive's FIFO of 4; 0: as buffer_points",
              "plant-and-bus.md 4.6"),
      live(choice("scheduling.work_mode", FIELD(scheduling.work_mode), {"full_load", "slowed_agv", "slowed_crane"},
                  "paper 4: both robots at full speed; AGVs slowed (case A), N^_a = slow_factor N_a; or the crane "
                  "slowed (case B), N^_t = slow_factor N_t. Takes effect from a robot's next leg on",
                  "paper 4")),
      live(number("scheduling.slow_factor", FIELD(scheduling.slow_factor), "", 1, 10,
                  "factor on a slowed robot's interval, unless agv_interval_refreshes gives it", "paper 5")),
      live(boolean("scheduling.pid_after_torque", FIELD(scheduling.pid_after_torque),
                   "PID of a tick waits until torque compensation of that tick is done; false, as printed: both run at "
                   "the same time",
                   "plant-and-bus.md 4.6 item 2")),
      live(integer("scheduling.long_blocks_max", FIELD(scheduling.long_blocks_max), "blocks", 0, 64,
                   "limit of claimed blocks that may run longer than half a servo period, without those of tasks with "
                   "a dsp of their own; 0, as printed: no limit",
                   "plant-and-bus.md 4.6 item 4")),
      integer("scheduling.slice_cycles", FIELD(scheduling.slice_cycles), "cycles", 0, 1e7,
              "identify, grab path, synthetic and dynamic-window avoidance are split into successor blocks of about "
              "this length; 0, as printed: they are not split",
              "plant-and-bus.md 4.6 item 4"),
      live(choice("scheduling.time_after_delay", FIELD(scheduling.time_after_delay), {"elapsed", "one"},
                  "growth of t at a late refresh: the number of elapsed periods, or 1, the literal reading",
                  "plant-and-bus.md 4.4 item 27")),
      live(choice("scheduling.learning", FIELD(scheduling.learning), {"off", "proportional", "unit"},
                  "adaptation of N^_a after each AGV cycle: none, by 4.7, or by one as printed",
                  "plant-and-bus.md 4.7")),
      live(number("scheduling.learning_rate", FIELD(scheduling.learning_rate), "", 0, 1, "eta of proportional learning",
                  "plant-and-bus.md 4.7")),
      live(number("scheduling.learning_dead_band", FIELD(scheduling.learning_dead_band), "", 0, 1,
                  "no change while the waiting is below this share of T_g", "plant-and-bus.md 4.7")),
      live(number("scheduling.learning_step_max", FIELD(scheduling.learning_step_max), "", 0, 1,
                  "largest change of N^_a per cycle, as a share of it", "plant-and-bus.md 4.7")),

      live(number("scheduling.servo_loss_share", FIELD(scheduling.servo_loss_share), "", 0, 1,
                  "for experiments: share of the nominal ticks of torque compensation and PID that are left out, drawn "
                  "by run.seed; they count as dropped. Not in the ideal run",
                  "docs/control.md")),
      live(integer("scheduling.servo_loss_run", FIELD(scheduling.servo_loss_run), "ticks", 1, 100000,
                   "number of such ticks in a row; 1: scattered", "docs/control.md")),
      live(integer("scheduling.servo_served_every", FIELD(scheduling.servo_served_every), "ticks", 1, 100000,
                   "for experiments: only every m-th nominal tick of torque compensation and PID is served; this is m. "
                   "The others count as dropped. Not in the ideal run",
                   "docs/control.md")),
      live(choice("scheduling.agv_phase", FIELD(scheduling.agv_phase), {"staggered", "together"},
                  "refreshes at which sub-processes of AGV i of n are released by interval: floor(i N^_a / n) modulo "
                  "N^_a, or 0 for all, the worst case (docs/processes.md)",
                  "ruling 39")),
      live(number("scheduling.event_field_m", FIELD(scheduling.event_field_m), "m", 0.1, 30,
                  "length of the field ahead of an AGV's range sensor; an object that enters it releases sub-processes "
                  "(docs/processes.md)",
                  "assumed")),
      live(integer("scheduling.event_read_refreshes", FIELD(scheduling.event_read_refreshes), "refreshes", 1, 65535,
                   "refreshes between two readings of the range sensor by the host", "assumed")),

      live(number("watchdog.factor", FIELD(watchdog.factor), "", 1, 1000,
                  "the limit of a kind is its longest measured run times this factor, or, if it has a heartbeat, the "
                  "longest gap between two beats times this factor",
                  "rulings 15, 37")),
      live(integer("watchdog.minimum_refreshes", FIELD(watchdog.minimum_refreshes), "refreshes", 2, 65535,
                   "no limit is below this", "ruling 15")),
      live(integer("watchdog.recomputations_max", FIELD(watchdog.recomputations_max), "", 0, 100,
                   "number of times that a block may hang; if it hangs again, it is dropped and becomes an error",
                   "ruling 24")),
      live(integer("watchdog.retries_max", FIELD(watchdog.retries_max), "", 0, 1000,
                   "how often in a row the work of a dropped block is requested again; then it stops", "issue 6")),
      live(number(
          "watchdog.silence_ms", FIELD(watchdog.silence_ms), "ms", 0, 1e6,
          "a DSP without a sign of life for this time is reset, and after the same time again considered dead; 0: "
          "never (idle_policy \"doorbell\" only)",
          "docs/controller.md")),
      live(number("watchdog.semaphore_limit_us", FIELD(watchdog.semaphore_limit_us), "us", 1, 1e6,
                  "the host releases a semaphore that one DSP has held for this time", "ruling 24")),
      number("watchdog.boot_limit_ms", FIELD(watchdog.boot_limit_ms), "ms", 0.01, 1e4,
             "a DSP that takes no word of its boot stream for this time is given up until its next reset",
             "docs/controller.md"),
      number("watchdog.servo_run_us", FIELD(watchdog.servo_run_us), "us", 1, 1e6,
             "longest run of torque compensation and PID before a longer one is measured",
             "measured, docs/controller.md"),
      number("watchdog.planning_run_us", FIELD(watchdog.planning_run_us), "us", 1, 1e6,
             "longest run of trajectory planning and inverse kinematics before a longer one is measured",
             "measured, docs/controller.md"),
      number("watchdog.long_run_us", FIELD(watchdog.long_run_us), "us", 1, 1e7,
             "longest run of all other kinds before a longer one is measured; for kinds with a heartbeat it only "
             "decides whether they count as long (long_blocks_max)",
             "plant-and-bus.md 2.2"),

      live(number("host.refresh_overhead_ns", FIELD(host.refresh_overhead_ns), "ns", 0, 1e6,
                  "the host's own work in each refresh: timer interrupt, bookkeeping", "assumed, Pentium II")),
      live(number("host.per_block_ns", FIELD(host.per_block_ns), "ns", 0, 1e5,
                  "the host's own work per block and refresh: t, J, order", "assumed, Pentium II")),
      live(number("host.semaphore_retry_ns", FIELD(host.semaphore_retry_ns), "ns", 0, 1e6,
                  "the host's pause before it tries again to acquire a semaphore", "assumed")),
      number("host.start_ms", FIELD(host.start_ms), "ms", 0, 1e5,
             "time of the first refresh; with boot = \"link\" not before the DSPs plugged in at the start have booted, "
             "and then at a whole ms",
             "ruling 27"),
      number("host.boot_pause_ns", FIELD(host.boot_pause_ns), "ns", 0, 1e6,
             "the host's pause between two accesses to the port of a DSP that it boots", "assumed"),

      choice("kernels.torque", FIELD(kernels.torque), {"closed_form", "newton_euler"},
             "torque compensation: closed form of the crane's equations, or recursive Newton-Euler over its links",
             "plant-and-bus.md 2.1"),
      choice("kernels.pid", FIELD(kernels.pid), {"error_derivative", "measurement_derivative"},
             "PID: derivative of the error and a cubic between points, or of the measurement and straight between "
             "points as 2.1 prints it",
             "plant-and-bus.md 2.1"),
      choice("kernels.trajectory", FIELD(kernels.trajectory), {"blend9", "quintic_shaper"},
             "the crane's trajectory: blends of degree 9 of the load itself, or quintics through an input shaper",
             "plant-and-bus.md 2.1"),
      choice("kernels.avoidance", FIELD(kernels.avoidance),
             {"none", "synthetic", "potential_field", "vfh", "dynamic_window"},
             "obstacle avoidance of each AGV and planning point: none, a load of load.avoidance_cycles, or one "
             "of the methods",
             "plant-and-bus.md 2.1"),

      integer("load.avoidance_cycles", FIELD(load.avoidance_cycles), "cycles", 0, 100000000,
              "length of the avoidance block if kernels.avoidance is \"synthetic\"; 0: none is loaded", "ruling 14"),
      boolean(
          "load.driving", FIELD(load.driving),
          "every AGV begins with an empty round past the warehouse, back to its place in the queue (docs/processes.md)",
          "ruling 39"),
      boolean("load.parked", FIELD(load.parked),
              "AGVs do not move (overrides a preset's load.driving), and avoidance is released for those that "
              "stand, too",
              "ruling 39"),

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

      integer("dock.agvs", FIELD(dock.agvs), "", 1, 8, "number of AGVs", "ruling 11"),
      integer("dock.containers", FIELD(dock.containers), "", 1, 24,
              "containers on the ship: eight in one and a half tiers, more in up to four; with a layout file at most "
              "those that it lists",
              "paper 3"),
      choice("dock.crane", FIELD(dock.crane), {"slewing", "gantry"},
             "the hoisting machine: slewing, luffing jib crane, or ship-to-shore gantry with a layout and DSP programs "
             "of its own (docs/plant.md)",
             "plant-and-bus.md 1.1"),
      choice("dock.crane_model", FIELD(dock.crane_model), {"sway", "rigid"},
             "the load swings on its rope (L1), or hangs vertically below the jib's tip or the trolley (L0)",
             "plant-and-bus.md 1.3"),
      number("dock.container_mass_kg", FIELD(dock.container_mass_kg), "kg", 1000, 1e6,
             "gross mass of a container, at most the crane's rated load and what its drives can hold",
             "plant-and-bus.md 1.4"),
      number("dock.agv_speed_m_s", FIELD(dock.agv_speed_m_s), "m/s", 0.5, 6,
             "upper bound of an AGV's speed on its lanes", "plant-and-bus.md 1.4"),
      number("dock.clearance_m", FIELD(dock.clearance_m), "m", 0.1, 5,
             "height of a route's end above its target surface", "contract of the job areas"),
      number("dock.ramp_slack_m", FIELD(dock.ramp_slack_m), "m", 0, 0.5,
             "distance by which a lowering ramp goes beyond the surface", "contract of the job areas"),
      number("dock.ramp_speed_m_s", FIELD(dock.ramp_speed_m_s), "m/s", 0.01, 1,
             "peak speed of lowering and raising ramps", "plant-and-bus.md 1.5 (0.25 m/s at touch)"),
      number("dock.drive_timeout_ms", FIELD(dock.drive_timeout_ms), "ms", 0, 1e5,
             "a crane drive brakes when it has had no torque code for this time; 0: never", "assumed"),
      number("dock.drive_delay_us", FIELD(dock.drive_delay_us), "us", 0, 100000,
             "for experiments: the crane's drives take each torque code later by this time, in whole latches of 125 "
             "us; not in the ideal run",
             "control-notes.md 2"),
      number("dock.settle_limit_s", FIELD(dock.settle_limit_s), "s", 0.1, 600,
             "longest time that the crane waits for its load to come to rest", "assumed"),
      integer("dock.landing_retries_max", FIELD(dock.landing_retries_max), "", 0, 100,
              "how often a load that has not landed is lifted, aligned and lowered again; then the crane stops",
              "plant-and-bus.md 1.5"),
      choice("dock.integrator", FIELD(dock.integrator), {"erk", "adams", "bdf"},
             "integrator of the crane: ARKODE's explicit Runge-Kutta, CVODES' Adams or BDF", "plant-and-bus.md 1.6"),
      boolean("dock.stiction", FIELD(dock.stiction),
              "the crane's joints stick and break away; false: dry friction is smoothed", "plant-and-bus.md 1.3"),
      boolean("dock.gear_losses", FIELD(dock.gear_losses),
              "gears also have losses when the load drives them; false: the motor's torque is always multiplied by the "
              "efficiency",
              "docs/plant.md"),
      boolean("dock.strict_landing", FIELD(dock.strict_landing),
              "a touch that is too fast or turned too far closes no corner switch, and is repeated",
              "plant-and-bus.md 1.5"),
      integer(
          "dock.sway_sensors", FIELD(dock.sway_sensors), "", 1, 2,
          "number of sway sensors of the crane, each with its own noise; the second is used when the first has failed",
          "measures.md 6"),
      number("dock.capture_window_m", FIELD(dock.capture_window_m), "m", 0, 0.3,
             "lateral error that flipper guides catch; 0: no guides", "plant-and-bus.md 1.5"),
      text("dock.layout", FIELD(dock.layout), "TOML file with your own layout (docs/plant.md); empty: the default one",
           "plant-and-bus.md 1.5"),
      boolean("dock.protective_field", FIELD(dock.protective_field),
              "AGVs slow down by themselves for objects that their range sensor sees in their way", "assumed"),
      number("dock.ship_motion", FIELD(dock.ship_motion), "", 0, 10,
             "the moored ship surges, sways, heaves, rolls and pitches, by run.seed: 1 is 0.2 m, 0.1 m, 0.1 m, 0.5 and "
             "0.1 degrees",
             "plant-and-bus.md 1.5"),
      number("dock.wind_mean_m_s", FIELD(dock.wind_mean_m_s), "m/s", -50, 50, "mean wind on the load",
             "plant-and-bus.md 1.3"),
      number("dock.wind_gust_m_s", FIELD(dock.wind_gust_m_s), "m/s", 0, 50,
             "standard deviation of the gusts, by run.seed; with a mean of 1 or more", "control-notes.md 3"),
      number("dock.wind_limit_m_s", FIELD(dock.wind_limit_m_s), "m/s", 1, 100,
             "no lift begins while the anemometer's mean over 3 s is above this", "control-notes.md 3"),
      number("dock.wind_direction_deg", FIELD(dock.wind_direction_deg), "deg", -360, 360,
             "direction the wind blows towards: 0 along the quay, 90 towards the ship", "assumed"),

      live(number("control.travel_bandwidth_rad_s", FIELD(control.travel.bandwidth_rad_s), "rad/s", 0.5, 6,
                  "bandwidth of the travel's loop, omega: a double pole of the rigid joint; soft ground and a large "
                  "mass limit the crossover to 2 Hz",
                  "control-notes.md 1")),
      live(number("control.travel_damping", FIELD(control.travel.damping), "", 0.1, 5,
                  "damping of the travel's loop: the derivative time is 2 damping / omega", "control-notes.md 1")),
      live(number("control.travel_integral_time_s", FIELD(control.travel.integral_time_s), "s", 0, 1000,
                  "integral time of the travel's loop; 0: 6 / omega", "control-notes.md 1")),
      live(number("control.travel_derivative_filter", FIELD(control.travel.derivative_filter), "", 1, 100,
                  "the derivative of the travel's loop acts up to N / derivative time; this is N",
                  "control-notes.md 1")),
      live(number("control.travel_feed_forward", FIELD(control.travel.feed_forward), "", 0, 2,
                  "share of torque compensation that PID adds", "docs/control.md")),
      live(number("control.travel_speed_limit_m_s", FIELD(control.travel.speed_limit), "m/s", 0.001, 2,
                  "greatest speed of the travel in a leg, from the next leg on", "plant-and-bus.md 1.4")),
      live(number("control.slew_bandwidth_rad_s", FIELD(control.slew.bandwidth_rad_s), "rad/s", 0.5, 200,
                  "the same of slewing", "control-notes.md 1")),
      live(number("control.slew_damping", FIELD(control.slew.damping), "", 0.1, 5, "the same of slewing",
                  "control-notes.md 1")),
      live(number("control.slew_integral_time_s", FIELD(control.slew.integral_time_s), "s", 0, 1000,
                  "the same of slewing", "control-notes.md 1")),
      live(number("control.slew_derivative_filter", FIELD(control.slew.derivative_filter), "", 1, 100,
                  "the same of slewing", "control-notes.md 1")),
      live(number("control.slew_feed_forward", FIELD(control.slew.feed_forward), "", 0, 2, "the same of slewing",
                  "docs/control.md")),
      live(number("control.slew_speed_limit_rad_s", FIELD(control.slew.speed_limit), "rad/s", 0.001, 1,
                  "the same of slewing", "plant-and-bus.md 1.4")),
      live(number("control.luff_bandwidth_rad_s", FIELD(control.luff.bandwidth_rad_s), "rad/s", 0.5, 200,
                  "the same of luffing", "control-notes.md 1")),
      live(number("control.luff_damping", FIELD(control.luff.damping), "", 0.1, 5, "the same of luffing",
                  "control-notes.md 1")),
      live(number("control.luff_integral_time_s", FIELD(control.luff.integral_time_s), "s", 0, 1000,
                  "the same of luffing", "control-notes.md 1")),
      live(number("control.luff_derivative_filter", FIELD(control.luff.derivative_filter), "", 1, 100,
                  "the same of luffing", "control-notes.md 1")),
      live(number("control.luff_feed_forward", FIELD(control.luff.feed_forward), "", 0, 2, "the same of luffing",
                  "docs/control.md")),
      live(number("control.luff_speed_limit_rad_s", FIELD(control.luff.speed_limit), "rad/s", 0.001, 1,
                  "the same of luffing", "plant-and-bus.md 1.4")),
      live(number("control.trolley_bandwidth_rad_s", FIELD(control.trolley.bandwidth_rad_s), "rad/s", 0.5, 200,
                  "the same of a gantry's trolley", "control-notes.md 1")),
      live(number("control.trolley_damping", FIELD(control.trolley.damping), "", 0.1, 5,
                  "the same of a gantry's trolley", "control-notes.md 1")),
      live(number("control.trolley_integral_time_s", FIELD(control.trolley.integral_time_s), "s", 0, 1000,
                  "the same of a gantry's trolley", "control-notes.md 1")),
      live(number("control.trolley_derivative_filter", FIELD(control.trolley.derivative_filter), "", 1, 100,
                  "the same of a gantry's trolley", "control-notes.md 1")),
      live(number("control.trolley_feed_forward", FIELD(control.trolley.feed_forward), "", 0, 2,
                  "the same of a gantry's trolley", "docs/control.md")),
      live(number("control.trolley_speed_limit_m_s", FIELD(control.trolley.speed_limit), "m/s", 0.001, 5,
                  "the same of a gantry's trolley", "plant-and-bus.md 1.4")),
      live(number("control.hoist_bandwidth_rad_s", FIELD(control.hoist.bandwidth_rad_s), "rad/s", 0.5, 200,
                  "the same of the hoist", "control-notes.md 1")),
      live(number("control.hoist_damping", FIELD(control.hoist.damping), "", 0.1, 5, "the same of the hoist",
                  "control-notes.md 1")),
      live(number("control.hoist_integral_time_s", FIELD(control.hoist.integral_time_s), "s", 0, 1000,
                  "the same of the hoist", "control-notes.md 1")),
      live(number("control.hoist_derivative_filter", FIELD(control.hoist.derivative_filter), "", 1, 100,
                  "the same of the hoist", "control-notes.md 1")),
      live(number("control.hoist_feed_forward", FIELD(control.hoist.feed_forward), "", 0, 2, "the same of the hoist",
                  "docs/control.md")),
      live(number("control.hoist_speed_limit_m_s", FIELD(control.hoist.speed_limit), "m/s", 0.001, 5,
                  "the same of the hoist", "plant-and-bus.md 1.4")),
      live(number("control.rotator_bandwidth_rad_s", FIELD(control.rotator.bandwidth_rad_s), "rad/s", 0.5, 200,
                  "the same of the rotator", "control-notes.md 1")),
      live(number("control.rotator_damping", FIELD(control.rotator.damping), "", 0.1, 5, "the same of the rotator",
                  "control-notes.md 1")),
      live(number("control.rotator_integral_time_s", FIELD(control.rotator.integral_time_s), "s", 0, 1000,
                  "the same of the rotator", "control-notes.md 1")),
      live(number("control.rotator_derivative_filter", FIELD(control.rotator.derivative_filter), "", 1, 100,
                  "the same of the rotator", "control-notes.md 1")),
      live(number("control.rotator_feed_forward", FIELD(control.rotator.feed_forward), "", 0, 2,
                  "the same of the rotator", "docs/control.md")),
      live(number("control.rotator_speed_limit_rad_s", FIELD(control.rotator.speed_limit), "rad/s", 0.001, 1,
                  "the same of the rotator", "plant-and-bus.md 1.4")),
      live(number("control.sway_gain_m_s_rad", FIELD(control.sway_gain_m_s_rad), "m/s per rad", 0, 30,
                  "against sway the suspension moves with this speed towards the side to which the load hangs",
                  "docs/kernels.md")),
      live(number("control.wind_observer_rad_s", FIELD(control.wind_observer_rad_s), "rad/s", 0.05, 2,
                  "bandwidth of the observer that separates wind from sway; the suspension moves upwind by the "
                  "observer's estimate",
                  "docs/kernels.md")),
      live(number("control.sway_filter_s", FIELD(control.sway_filter_s), "s", 0, 10, "low-pass of the measured sway",
                  "docs/kernels.md")),
      live(number("control.sway_limit_mrad", FIELD(control.sway_limit_mrad), "mrad", 0, 170,
                  "larger sway counts as this much", "docs/kernels.md")),

      number("errors.following_travel_m", FIELD(errors.following_travel_m), "m", 0, 100,
             "a following error of the travel above this counts as an error if it lasts errors.following_ms",
             "measures.md 6"),
      number("errors.following_slew_mrad", FIELD(errors.following_slew_mrad), "mrad", 0, 1e4, "the same of slewing",
             "measures.md 6"),
      number("errors.following_luff_mrad", FIELD(errors.following_luff_mrad), "mrad", 0, 1e4, "the same of luffing",
             "measures.md 6"),
      number("errors.following_trolley_m", FIELD(errors.following_trolley_m), "m", 0, 100,
             "the same of a gantry's trolley", "as the travel's"),
      number("errors.following_hoist_m", FIELD(errors.following_hoist_m), "m", 0, 100, "the same of the hoist",
             "measures.md 6"),
      number("errors.following_rotator_mrad", FIELD(errors.following_rotator_mrad), "mrad", 0, 1e4,
             "the same of the rotator", "measures.md 6"),
      number("errors.following_ms", FIELD(errors.following_ms), "ms", 0, 1e5,
             "a following error counts when it is above its limit for this time without a break", "measures.md 6"),
      number("errors.encoder_speed_percent", FIELD(errors.encoder_speed_percent), "% of rated speed", 0, 100,
             "an encoder whose count does not change is an error while its drive reports a higher speed than this",
             "measures.md 6"),
      number("errors.encoder_ms", FIELD(errors.encoder_ms), "ms", 0, 1e5, "time for which that must last",
             "measures.md 6"),
      integer("errors.sway_samples", FIELD(errors.sway_samples), "samples", 2, 10000,
              "a sway sensor counts as stuck after this number of equal samples, 10 ms each: a working sensor changes "
              "by its noise",
              "measures.md 6"),
      number("errors.stop_s", FIELD(errors.stop_s), "s", 0, 60,
             "stopping along the path: time in which the set-point's rate along the path falls from 1 to 0",
             "measures.md 6"),
      number("errors.go_on_s", FIELD(errors.go_on_s), "s", 0, 600,
             "continuing along the path: time in which the rate rises from 0 to 1; if it is the period of the load's "
             "swing (12 s on 36 m of rope), it adds no swing",
             "docs/controller.md"),
      integer("errors.timeout_retries_max", FIELD(errors.timeout_retries_max), "", 0, 1000,
              "how often the crane continues by itself after a time-out of its drives; then it waits for the operator",
              "assumed"),
      live(boolean("errors.clear", FIELD(errors.clear),
                   "when the operator sets it to true, all errors are cleared, and what they have stopped continues "
                   "where that is possible; the host then resets it",
                   "issue 14")),

      choice("report.reference", FIELD(report.reference), {"ideal", "none"},
             "reference for errors, lag and demand: the ideal run, which runs at the same time in a process of its "
             "own; or none, and then they are not reported",
             "docs/report.md"),
      integer("report.misses_max", FIELD(report.misses_max), "jobs", 0, 100000000,
              "number of missed jobs that the report lists one by one with their causes: the first ones; the others "
              "are counted",
              "docs/report.md"),
      integer("report.error_rows_max", FIELD(report.error_rows_max), "rows", 16, 100000000,
              "errors are sampled at each latch of the drives; when this number is recorded, every second one is "
              "removed, and the interval doubles",
              "docs/report.md"),
      integer("report.samples_max", FIELD(report.samples_max), "samples", 0, 100000000,
              "up to this number of samples the percentiles of a summary are exact; beyond, within 0.1 %",
              "docs/report.md"),
      number("report.control_cost_rho_m2", FIELD(report.control_cost_rho_m2), "m2", 0, 1e6,
             "rho of the control cost: weight of a drive at full torque relative to the squared error of the spreader",
             "plant-and-bus.md 5"),
      integer("report.signal_decimation", FIELD(report.signal_decimation), "latches", 1, 80000,
              "latches of 125 us per recorded row of the plant's signals", "ruling 5"),
      integer("report.signal_rows_max", FIELD(report.signal_rows_max), "rows", 16, 100000000,
              "when this number of rows is recorded, every second one is removed, and the interval doubles",
              "docs/report.md"),
  };
}

#undef FIELD

}  // namespace

std::span<const Key> keys() {
  static const std::vector<Key> all = [] {
    std::vector<Key> keys = make_keys();
    for (std::size_t i = 0; i < plant_parameters().size(); ++i) {
      const PlantParameter& row = plant_parameters()[i];
      keys.push_back(entry<double>(
          Key::Type::number, row.name, [i](Config& c) -> double& { return c.plant[i]; }, row.unit, row.minimum,
          row.maximum, row.meaning, row.source));
    }
    return keys;
  }();
  return all;
}

std::string_view name(Key::Type type) {
  switch (type) {
    case Key::Type::boolean: return "boolean";
    case Key::Type::integer: return "integer";
    case Key::Type::number: return "number";
    case Key::Type::text: return "string";
    case Key::Type::choice: return "choice";
  }
  return "";
}

}  // namespace cmrc
