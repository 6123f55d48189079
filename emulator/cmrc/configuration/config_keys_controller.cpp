// Keys of the run, the machine and the controller: rates, scheduling, watchdog, host, kernels, load.
#include "cmrc/configuration/config_keys.hpp"

namespace cmrc::schema {

std::vector<Key> controller_keys() {
  return {
      number("run.duration_s", FIELD(run.duration_s), "s", 1e-6, 86400, "simulated time", "ruling 13"),
      integer("run.seed", FIELD(run.seed), "", 0, no_limit, "seed of everything random", "ruling 3"),
      integer("run.turn_order", FIELD(run.turn_order), "", 0, no_limit,
              "shuffles which chip the emulator advances first; must change nothing", "ruling 29"),
      boolean(
          "run.strict", FIELD(run.strict),
          "a missed deadline, an error that had to be handled, or no finished job makes the run fail (exit status 1)",
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
              "instant execution: one DSP (whatever machine.dsps is), a thousand times as fast, buses and host take no "
              "time, nothing of the machine fails (docs/report.md, Ideal)",
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
      path(text("machine.programs", FIELD(machine.programs),
                "directory of the DSP programs' sources, assembled at the start; empty: the built-in image",
                "issue 2")),
      path(text("machine.board", FIELD(machine.board),
                "memories and clock of every DSP's board: default, or a board file (cli.md), whose clock_mhz comes "
                "before dsp_clock",
                "issue 4")),
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
  };
}

}  // namespace cmrc::schema
