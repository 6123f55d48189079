#pragma once
// Everything that a run reports, as plain structs (docs/report.md). The controller fills them; this room makes text and
// JSON.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "report/events/event.hpp"
#include "report/values/handled_error.hpp"
#include "report/values/measures.hpp"
#include "report/values/statistics.hpp"
#include "report/values/why_late.hpp"

namespace report {

inline constexpr int schema_version = 4;

/// The jobs of one task kind (ruling 16). released = on_time + late + unfinished + never_started + lost + dropped,
/// always.
struct TaskReport {
  std::string kind;  ///< key of ruling 29: "pid", "trajectory_planning.crane", ...
  std::uint64_t released = 0;
  std::uint64_t on_time = 0;
  std::uint64_t late = 0;
  std::uint64_t unfinished = 0;
  std::uint64_t never_started = 0;
  std::uint64_t lost = 0;
  std::uint64_t dropped = 0;
  std::uint64_t misses = 0;  ///< late + lost + dropped + those unfinished or never started whose deadline has passed
  std::uint64_t longest_miss_streak = 0;  ///< misses in a row
  Summary response;                       ///< ps from release to the end, finished jobs
  Summary waiting;                        ///< ps from release to the claim, claimed jobs
  Summary execution;                      ///< ps from the claim to the end, finished jobs
  Summary lateness;                       ///< ps after the deadline, late jobs
  Jitter start_jitter;                    ///< ps, periodic kinds only
  std::vector<Share> execution_causes;    ///< ps by the chips' causes, all finished jobs; sums to the sum of execution
  std::vector<Share> execution_cycles;    ///< the same in cycles of the DSPs
  WhyLate why_late;                       ///< of the missed jobs
};

/// The boot of a DSP, from reset to its running program.
struct BootReport {
  Time reset{};                ///< RESET goes low; 0 at power-on
  std::optional<Time> booted;  ///< the program has answered over the link; absent: it never did
};

struct DspReport {
  unsigned slot = 0;
  std::string state;           ///< "running", "idle", "halted: <fault>", "unplugged"
  double clock_hz = 0;         ///< nominal
  std::int64_t clock_ppm = 0;  ///< what its oscillator deviates from that
  std::int64_t cycles = 0;
  std::uint64_t instructions = 0;
  std::vector<Share> causes;  ///< cycles by cause; sums to cycles
  std::uint64_t claims = 0;   ///< blocks claimed
  std::vector<Share> tasks;   ///< ps occupied, by task kind
  std::uint64_t faults = 0;
  std::uint64_t resets = 0;          ///< by the watchdog
  std::uint64_t dropped_writes = 0;  ///< while fenced
  std::vector<BootReport> boots;
  std::uint64_t link_words_in = 0, link_words_out = 0, link_words_lost = 0;  ///< between the link adapter and the DSP
};

/// A link between ports of two slots.
struct LinkReport {
  struct Direction {
    std::string from, to;  ///< "0.1": slot and port
    std::uint64_t sent = 0, arrived = 0;
    std::uint64_t lost = 0;       ///< lost on the wires
    std::uint64_t discarded = 0;  ///< discarded by ports that were reset
  };
  std::array<Direction, 2> directions;
  std::uint64_t joined = 0;  ///< how often its wires were connected
  bool is_cut = false;       ///< at the end
};

/// A net between pins of slots.
struct NetReport {
  std::string name, pins;   ///< "0.TCLK0>1.IIOF1"
  std::uint64_t edges = 0;  ///< changes of its level
  std::uint64_t missed =
      0;             ///< changes that a receiver did not see: shorter than the time between two looks at the pin
  bool high = true;  ///< at the end
};

struct MasterReport {
  std::string name;  ///< "host", "dsp 0", ...
  std::uint64_t transactions = 0;
  std::uint64_t words_read = 0;
  std::uint64_t words_written = 0;
  Summary wait;  ///< bus clocks from the request to the first FRAME#
  std::uint64_t retries = 0;
  std::uint64_t disconnects = 0;
};

struct TargetReport {
  std::string name;
  std::uint64_t words_read = 0;
  std::uint64_t words_written = 0;
};

/// One bus; the five shares of its clocks sum to clocks.
struct BusReport {
  std::string name;            ///< "A", "B"
  double clock_hz = 0;         ///< nominal
  std::int64_t clock_ppm = 0;  ///< what its oscillator deviates from that
  std::int64_t clocks = 0;
  std::int64_t data = 0;
  std::int64_t wait = 0;
  std::int64_t turnaround = 0;
  std::int64_t idle_requested = 0;  ///< no master on the bus although a master requested it
  std::int64_t idle = 0;
  std::vector<MasterReport> masters;
  std::vector<TargetReport> targets;
};

/// The cycle of one container (equations 2 to 4). Absent: has not happened by the end of the run.
struct CycleReport {
  unsigned number = 0;                 ///< from 1
  std::optional<unsigned> agv;         ///< from the start of t4 on
  std::optional<Time> t3, t4, t5, t6;  ///< duration of the process
  std::optional<Time> t_v;             ///< the crane waited above the spot for an AGV
  std::optional<Time> t_w;     ///< the AGV waited, from leaving the lane to the start of the t4 that loads it again
  std::optional<Time> t_wait;  ///< t_w + that t4
  std::optional<Time> T_g;     ///< t3 + t4 + t_v
  std::optional<Time> T_a;     ///< t5 + t6 + t_wait
  std::optional<std::int64_t> agv_interval;  ///< N^_a on the AGV's way to the warehouse, refreshes
  unsigned landings_missed = 0;              ///< how often the container had to be lifted, aligned and lowered again
  std::optional<Time> delivered;             ///< time of delivery
};

/// RMS and peak of a quantity that the run itself measured; none if the quantity never had a value.
struct OwnMeasure {
  std::string name;  ///< "s", "psi", "phi", "l", "kappa"; "alpha", "beta"; "agv 0 lateral"
  std::string unit;  ///< "m", "rad"
  std::optional<double> rms, peak;
};

/// What a drive of the crane did.
struct DriveReport {
  std::string name;        ///< name of its joint
  double saturated_s = 0;  ///< time at full torque: the drive is on, and |code| = 2047
};

/// Quadratic control cost: the integral of e^2 + rho u^2, e being the error against the ideal run.
struct ControlCost {
  std::optional<double> error_m2s;  ///< Errors::error_m2s; none without a reference
  double drive_s = 0;  ///< integral of the squared torque codes, 1 at full torque, of the drives that are on, s
  double rho_m2 = 0;
  std::optional<double> cost() const { return error_m2s ? std::optional(*error_m2s + rho_m2 * drive_s) : std::nullopt; }
};

/// The plant after all drives had stopped.
struct AfterStop {
  Time from{}, to{};
  double moved_m = 0;        ///< largest distance of the load from its place at the beginning
  double sway_peak_rad = 0;  ///< largest sway
  double sway_end_rad = 0;   ///< the same in the last two seconds
};

/// Intervals inside a robot's legs in which the robot got no new point.
struct Starved {
  std::string robot;
  std::uint64_t intervals = 0;
};

struct HostReport {
  std::uint64_t refreshes = 0;
  std::uint64_t skipped_refreshes = 0;
  Summary semaphore_hold;    ///< ps for which the host held the list, per refresh
  Summary refresh_duration;  ///< ps from the host's tick until the host is done and the list is released
  Summary list_length;       ///< blocks, per refresh
  std::uint64_t doorbells = 0;
  std::uint64_t recomputed = 0;  ///< blocks put back by the watchdog
  std::uint64_t semaphores_freed = 0;
};

/// The wind, and the lifts that it delayed (docs/report.md, Wind).
struct WindReport {
  double limit_m_s = 0;     ///< no lift begins above this wind speed
  Time watched{};           ///< measured part of the run
  Time above{};             ///< part of it with a 3-s mean above the limit
  Time waited{};            ///< time for which lifts waited for less wind
  std::uint64_t waits = 0;  ///< number of such waits
};

/// A timed event, requested by the configuration or the operator.
struct TimedEventReport {
  Time time{};
  std::string what;
};

/// The checks of every task block's life during the run (docs/controller.md).
struct AuditReport {
  std::uint64_t checks = 0;
  std::vector<std::string> violations;
};

/// A failure during the run, contained or not.
struct FailureReport {
  Time time{};
  std::optional<unsigned> dsp;
  std::string kind;  ///< "fault", "watchdog", "semaphore", "dropped block", "no dsp left", "plant"
  std::string message;
};

/// A setting of the run, from the configuration and the defaults.
struct Setting {
  std::string key;
  std::variant<std::int64_t, double, bool, std::string> value;
};

/// Why the run ended.
enum class StopReason : std::uint8_t {
  under_way,
  completed,
  interrupted,
  no_dsp_left,
  plant_fault,
  drives_stopped,
  job_done
};
std::string name(StopReason reason);

struct RunReport {
  StopReason stop_reason = StopReason::completed;
  Time simulated{};
  Time account_end{};    ///< deadlines are counted until this time
  double elapsed_s = 0;  ///< wall clock; not in the hash
  std::string hash;      ///< 64 hexadecimal digits (ruling 4)
  std::uint64_t events = 0;
  std::vector<Setting> configuration;
  std::string configuration_toml;     ///< all of it, with events, tasks and processes: makes the run again
  std::vector<TaskReport> tasks;      ///< every kind of ruling 29 in its order, also those never released
  std::vector<MissReport> missed;     ///< the first report.misses_max missed jobs, one by one
  std::uint64_t misses_left_out = 0;  ///< missed jobs that are not in this list
  std::uint64_t boot_words = 0;       ///< words that each DSP gets over its link to boot; 0: its program is preloaded
  std::vector<DspReport> dsps;
  std::vector<LinkReport> links;  ///< between slots
  std::vector<NetReport> nets;    ///< between pins of slots
  std::vector<BusReport> buses;
  std::vector<CycleReport> cycles;
  unsigned cycles_completed = 0;
  unsigned containers_delivered = 0;
  std::optional<Time> makespan;   ///< first refresh to last delivery; none: the job did not end
  std::string reference;          ///< "ideal", "none"
  std::string reference_problem;  ///< why a requested ideal run does not exist
  std::optional<Errors> errors;   ///< none without a reference, and until the run is over
  std::vector<Starved> starved;
  std::vector<OwnMeasure> pid_error;  ///< errors that PID itself computed
  std::vector<OwnMeasure> sway;       ///< angle of the rope
  std::vector<OwnMeasure> agvs;       ///< distance from the lane while driving
  std::vector<DriveReport> drives;
  std::optional<AfterStop> after_stop;
  ControlCost control_cost;
  HostReport host;
  WindReport wind;
  std::vector<TimedEventReport> timed_events;
  std::size_t timed_events_to_come = 0;  ///< events whose time is after the end of the run
  AuditReport audit;
  bool braked = false;  ///< at the end all drives are off
  std::vector<FailureReport> failures;
  std::vector<HandledError> errors_handled;  ///< in the order in which they were noticed

  /// A job was finished on time, or missed. Until then a run says nothing about deadlines: a controller that still
  /// boots releases no job, so it misses none.
  bool judged() const;
  /// Missed deadlines of all kinds.
  std::uint64_t misses() const;
};

/// The report for a terminal, in at most 100 columns. Ends with a line feed.
std::string to_text(const RunReport& report);
/// Only the key "tasks" of the JSON report.
std::string tasks_to_json(const std::vector<TaskReport>& tasks);
/// The report as JSON (docs/report.md), indented by two. Ends with a line feed.
std::string to_json(const RunReport& report);

}  // namespace report
