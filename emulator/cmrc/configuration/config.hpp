#pragma once
// The configuration of a run: every parameter with its default, and the TOML schema of its keys
// (docs/configuration.md).
//
// A configuration has layers; later ones override earlier ones: defaults (the base rates of plant-and-bus.md 2.3), a
// preset, a TOML file, single settings (command-line flags, keyword arguments). Every fault of the user's input is a
// ConfigError, with the place where the value was given.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cmrc/configuration/dock/plant_parameters.hpp"
#include "cmrc/configuration/rows/process_table.hpp"
#include "cmrc/configuration/rows/timed_event.hpp"
#include "cmrc/configuration/rows/user_task.hpp"
#include "cmrc/configuration/rows/value.hpp"
#include "cmrc/tasks/importance.hpp"
#include "plant/numerics/integrator.hpp"

namespace cmrc {

enum class IdlePolicy { doorbell, pause, spin };
/// In the order of machine::Boot.
enum class BootPolicy { preloaded, link };
enum class DspClock { c40_40, c40_50, c40_60 };
enum class Learning { off, proportional, unit };
enum class CraneModel { sway, rigid };
/// In the order of plant::CraneKind.
enum class CraneMachine { slewing, gantry };
enum class ServoReload { locked, inherited };
enum class WorkMode { full_load, slowed_agv, slowed_crane };
enum class TimeAfterDelay { elapsed, one };
enum class TorqueBuild { closed_form, newton_euler };
enum class PidBuild { error_derivative, measurement_derivative };
enum class TrajectoryBuild { blend9, quintic_shaper };
/// The bus of each agent, as in plant-and-bus.md 3.4.
enum class TopologyPreset { dual, host_on_both, sensors_with_host, single };
/// In the order of pci::Arbitration and pci::Parking.
enum class Arbiter { round_robin, fixed, two_level, host_fair };
enum class Parking { none, last_owner, host };
/// Wait states of plant-and-bus.md 3.6.
enum class Card { sram, s5933, drive_card, host_dram };
/// The reference for a run's errors.
enum class ReferenceKind { ideal, none };
enum class RunUntil { duration, job_done };
/// The releases by interval of several AGVs, relative to each other.
enum class AgvPhase { staggered, together };
enum class AvoidanceBuild { none, synthetic, potential_field, vfh, dynamic_window };

/// All parameters of a run. Units are in the names, as in the TOML keys.
struct Config {
  struct Run {
    double duration_s = 180;
    std::int64_t seed = 1;
    std::int64_t turn_order = 0;  ///< shuffles which chip the emulator advances first; changes nothing
    bool strict = false;          ///< a missed deadline makes the run fail
    bool ideal = false;           ///< with instant execution
    RunUntil until = RunUntil::duration;
    double after_stop_s = 10;   ///< how long the plant continues, braked, after the last drive has stopped
    bool phase_jitter = false;  ///< each oscillator has its own phase and frequency
  } run;
  struct Machine {
    std::int64_t dsps = 4;
    std::int64_t slots = 0;  ///< for boards that are plugged in later; 0: as many as DSPs
    DspClock dsp_clock = DspClock::c40_50;
    double cycle_time_factor = 1;
    BootPolicy boot = BootPolicy::link;
    IdlePolicy idle_policy = IdlePolicy::doorbell;
    std::int64_t pause_nops = 125;  ///< 5 us at C40-50
    bool guard = true;
    std::string programs;           ///< directory of the assembly sources; empty: the built-in image
    std::string board = "default";  ///< of every DSP: "default", or a board file
    std::string links;              ///< between ports of two slots
    std::string nets;               ///< between pins of slots
  } machine;
  struct Rates {
    double refresh_frequency_hz = 8000;     ///< f_s
    double servo_frequency_hz = 1000;       ///< f_p
    double crane_point_frequency_hz = 125;  ///< f_t
    double agv_point_frequency_hz = 50;     ///< f_a
  } rates;
  struct Scheduling {
    Equation7 equation = Equation7::restored;
    std::int64_t gamma_refreshes = 0;
    std::int64_t alpha_refreshes = 24;
    std::int64_t beta_refreshes = 12;
    std::int64_t p = 0x4000;
    std::int64_t q = 0x2000;
    std::int64_t b = 0x100;
    std::int64_t a = 0x40;
    std::int64_t agv_interval_refreshes = 0;  ///< N^_a at the start; 0: N_a
    std::int64_t agv_interval_max_refreshes = 320;
    std::int64_t buffer_points = 2;
    std::int64_t agv_buffer_points = 0;  ///< 0: as buffer_points
    WorkMode work_mode = WorkMode::full_load;
    double slow_factor = 1.5;
    bool pid_after_torque = false;
    std::int64_t long_blocks_max = 0;  ///< 0: no cap
    std::int64_t slice_cycles = 0;     ///< 0: long tasks are not split
    TimeAfterDelay time_after_delay = TimeAfterDelay::elapsed;
    ServoReload servo_reload = ServoReload::locked;
    Learning learning = Learning::off;
    double learning_rate = 0.5;
    double learning_dead_band = 0.02;
    double learning_step_max = 0.1;
    double servo_loss_share = 0;          ///< share of servo ticks that are left out, for experiments
    std::int64_t servo_loss_run = 1;      ///< number of them in a row
    std::int64_t servo_served_every = 1;  ///< only every m-th tick is served; this is m
    AgvPhase agv_phase = AgvPhase::staggered;
    double event_field_m = 15;              ///< length of the field ahead of an AGV's range sensor
    std::int64_t event_read_refreshes = 8;  ///< refreshes between two readings of that sensor by the host
  } scheduling;
  struct Watchdog {
    double factor = 3;
    std::int64_t minimum_refreshes = 16;
    std::int64_t recomputations_max = 2;
    std::int64_t retries_max = 2;
    double silence_ms = 50;
    double semaphore_limit_us = 500;
    double boot_limit_ms = 10;
    double servo_run_us = 250;
    double planning_run_us = 250;
    double long_run_us = 15000;
  } watchdog;
  struct Host {
    double refresh_overhead_ns = 1500;
    double per_block_ns = 60;
    double semaphore_retry_ns = 200;
    double start_ms = 20;
    double boot_pause_ns = 2000;
  } host;
  /// The builds of the task programs that the DSPs run.
  struct Kernels {
    TorqueBuild torque = TorqueBuild::closed_form;
    PidBuild pid = PidBuild::error_derivative;
    TrajectoryBuild trajectory = TrajectoryBuild::blend9;
    AvoidanceBuild avoidance = AvoidanceBuild::synthetic;
  } kernels;
  struct Load {
    std::int64_t avoidance_cycles = 0;  ///< length of the synthetic avoidance block; 0: it is not loaded
    bool driving = false;               ///< all AGVs begin with an empty round
    bool parked = false;                ///< no AGV begins one, and avoidance also runs for AGVs that stand
  } load;
  struct Bus {
    double clock_hz = 100e6 / 3;
    std::int64_t latency_timer_clocks = 32;
    bool prefetch = true;
    bool fast_back_to_back = false;
    TopologyPreset topology = TopologyPreset::dual;
    Arbiter arbiter = Arbiter::round_robin;
    std::int64_t first_level_dsps = 0;
    Parking parking = Parking::last_owner;
    std::int64_t grant_clocks = 2;
    std::int64_t multi_transaction_clocks = 0;
    std::int64_t request_off_clocks = 2;
    std::int64_t think_on_retry_clocks = 0;
    std::int64_t max_burst_words = 0;
    std::int64_t post_depth_words = 8;
    Card shared_memory_card = Card::sram;
    Card device_card = Card::drive_card;
    bool delayed_reads = false;
    std::int64_t delayed_read_clocks = 20;
    std::int64_t device_post_words = 0;
  } bus;
  /// Differences from bus.topology; empty: none.
  struct Topology {
    std::string buses, host, boards, shared_memory, drives, sensors, comm_port, bridges;
    std::int64_t drives_at = -1, sensors_at = -1, comm_port_at = -1;
  } topology;
  struct Dock {
    std::int64_t agvs = 1;
    std::int64_t containers = 8;
    CraneMachine crane = CraneMachine::slewing;
    CraneModel crane_model = CraneModel::sway;
    double container_mass_kg = 24000;
    double agv_speed_m_s = 6.0;
    double clearance_m = 0.5;
    double ramp_slack_m = 0.1;
    double ramp_speed_m_s = 0.25;
    double drive_timeout_ms = 100;
    double drive_delay_us = 0;  ///< a drive takes its code later by this time, for experiments
    double settle_limit_s = 20;
    std::int64_t landing_retries_max = 3;
    plant::Method integrator = plant::Method::erk;
    bool stiction = false;
    bool gear_losses = false;
    bool strict_landing = false;
    std::int64_t sway_sensors = 2;
    double capture_window_m = 0.15;
    std::string layout;
    bool protective_field = false;
    double ship_motion = 0;
    double wind_mean_m_s = 0;
    double wind_gust_m_s = 0;
    double wind_limit_m_s = 20;
    double wind_direction_deg = 0;
  } dock;
  /// The servo's loops: docs/control.md.
  struct Control {
    struct Joint {
      double bandwidth_rad_s = 40;    ///< omega: K = M omega^2
      double damping = 1;             ///< T_d = 2 damping / omega
      double integral_time_s = 0;     ///< T_i; 0: 6 / omega
      double derivative_filter = 20;  ///< N
      double feed_forward = 1;        ///< share of torque compensation
      double speed_limit = 1;         ///< m/s or rad/s, of planned motion
    };
    Joint travel{.bandwidth_rad_s = 5, .speed_limit = 0.65};
    Joint slew{.speed_limit = 0.12};
    Joint luff{.speed_limit = 0.05};
    Joint trolley{.speed_limit = 2.3};
    Joint hoist{.speed_limit = 1};
    Joint rotator{.speed_limit = 0.12};
    double sway_gain_m_s_rad = 9;
    double wind_observer_rad_s = 0.5;
    double sway_filter_s = 0.15;
    double sway_limit_mrad = 30;
  } control;
  /// Errors of the crane: docs/controller.md, Errors.
  struct Errors {
    double following_travel_m = 0.1;
    double following_slew_mrad = 5;
    double following_luff_mrad = 5;
    double following_trolley_m = 0.1;  ///< for a gantry
    double following_hoist_m = 0.1;
    double following_rotator_mrad = 20;
    double following_ms = 50;
    double encoder_speed_percent = 2;
    double encoder_ms = 20;
    std::int64_t sway_samples = 64;
    double stop_s = 1;
    double go_on_s = 12;
    std::int64_t timeout_retries_max = 3;
    bool clear = false;  ///< set by the operator; the host resets it
  } errors;
  struct Report {
    ReferenceKind reference = ReferenceKind::ideal;
    std::int64_t signal_decimation = 80;   ///< latches (125 us) per recorded sample
    std::int64_t signal_rows_max = 65536;  ///< beyond this number every second row is removed
    std::int64_t error_rows_max = 524288;  ///< latches kept of a run, and of its ideal run
    std::int64_t samples_max = 65536;      ///< up to this number of samples the percentiles of a summary are exact
    std::int64_t misses_max = 1000;        ///< missed jobs that the report lists one by one
    double control_cost_rho_m2 = 1e-6;     ///< weight of the drives in the control cost
  } report;
  std::vector<double> plant =
      plant_defaults();  ///< of crane, drives, vehicles and landing: in the order and units of plant_parameters()
  std::vector<TimedEvent> events;                 ///< in the order of the input
  std::vector<UserTask> tasks;                    ///< the user's tasks, in the order of KIND_USER + n
  ProcessTable processes = built_in_processes();  ///< the given rows over the built-in ones
};

/// Equations (5) and (6): refreshes between runs.
struct Intervals {
  std::int64_t servo;         ///< N_p
  std::int64_t crane_point;   ///< N_t
  std::int64_t agv_point;     ///< N_a
  std::int64_t agv_slowed;    ///< N^_a at the start
  std::int64_t crane_slowed;  ///< N^_t, N_t unless the crane is slowed
};
Intervals intervals(const Config& config);
/// The parameters of equation (7) at the start.
ImportanceParameters importance_parameters(const Config& config);

/// One key of the schema. The list keys() is the schema: the parser, the documentation and the tests read it.
struct Key {
  enum class Type { boolean, integer, number, text, choice };
  std::string name;  ///< with dots: table.key
  Type type;
  std::string unit;
  double minimum;
  double maximum;
  std::vector<std::string> choices;
  std::string meaning;
  std::string source;
  std::function<void(Config&, const Value&)> assign;  ///< for a value that is already checked
  std::function<Value(const Config&)> read;
  bool live = false;  ///< an operator may change it during a run
  bool path = false;  ///< names a file or a folder, unless it has its default
};
std::span<const Key> keys();
/// What would be right instead of an unknown key: the known key that the user most likely meant (compared by the whole
/// name, and by the part after the table), else those that have its name in theirs, else the keys of the table, else
/// where all keys are listed.
std::string right_key(std::string_view key);
/// A value as 64 bits: an integer, a double's bits, the number of a choice.
struct KeyBits {
  std::uint32_t key;
  std::uint64_t bits;
};
KeyBits bits_of(std::string_view key, const Value& value);
/// \throws ConfigError unless the key may be changed during a run, and the value has its type and is in its range
void check_live(std::string_view key, const Value& value, const Origin& origin);
/// The configuration with one live key changed and every invariant checked. \throws ConfigError
Config with_live(const Config& config, std::string_view key, const Value& value, const Origin& origin);
/// The same for any key, for another run; its events may contradict it (check_events). \throws ConfigError
Config with_key(const Config& config, std::string_view key, const Value& value, const Origin& origin);
std::string_view name(Key::Type type);

/// A preset is a piece of TOML that overrides the defaults.
struct Preset {
  std::string_view name;
  std::string_view meaning;
  std::string_view toml;
};
std::span<const Preset> presets();

/// Collects the layers; every function throws ConfigError on bad input.
class ConfigBuilder {
 public:
  ConfigBuilder& preset(std::string_view name, const Origin& origin);
  /// A path in a regular file is relative to that file's folder; in a text, and read from a pipe, to the current one.
  ConfigBuilder& file(const std::string& path);
  ConfigBuilder& text(std::string_view toml, const std::string& name);
  /// One setting that overrides the file. `key` has dots; a key without its table is accepted if only one table has it.
  ConfigBuilder& set(std::string_view key, const Value& value, const Origin& origin);
  /// An event after those given before. Its fields are those of [[events]].
  ConfigBuilder& event(TimedEvent event);
  /// Applies the layers in order and checks all invariants of plant-and-bus.md 4.5.
  Config build() const;

 private:
  struct Setting {
    std::size_t key;
    Value value;
    Origin origin;
  };
  void parse(std::string_view toml, const std::string& name, std::vector<Setting>& into,
             const std::filesystem::path& folder = {});

  std::optional<std::string> flag_preset_;
  std::optional<std::string> file_preset_;
  std::vector<Setting> file_settings_;
  std::vector<Setting> flag_settings_;
  std::vector<TimedEvent> events_;
  std::vector<UserTask> tasks_;
  ProcessTable processes_ = built_in_processes();
};

/// The configuration as complete TOML, every key with its value.
std::string to_toml(const Config& config);

/// The same configuration; its paths do not depend on the current folder.
Config with_absolute_paths(const Config& config);

}  // namespace cmrc
