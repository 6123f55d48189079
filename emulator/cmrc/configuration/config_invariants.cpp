#include "cmrc/configuration/config_invariants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "cmrc/configuration/dock/nominal_dock.hpp"
#include "cmrc/configuration/dock/servo_law.hpp"
#include "cmrc/configuration/machine/machine_topology.hpp"
#include "cmrc/tasks/task_list.hpp"
#include "machine/dsps/slot_links.hpp"
#include "machine/networks/net_description.hpp"
#include "plant/scene/wind.hpp"

namespace cmrc {
namespace {

class Invariants {
 public:
  Invariants(const Config& config, std::map<std::string, Origin, std::less<>> origins)
      : config_(config), n_(intervals(config)), origins_(std::move(origins)) {}

  void check() const {
    rates();
    importance();
    leads();
    errors();
    control();
    const auto& m = config_.machine;
    require(m.slots == 0 || m.slots >= m.dsps, {"machine.slots", "machine.dsps"},
            fmt::format("{} DSPs in {} slots", m.dsps, m.slots), "machine.slots >= machine.dsps is required, or 0");
    try {
      const auto slots = static_cast<unsigned>(m.slots == 0 ? m.dsps : m.slots);
      machine::check(machine::parse_slot_links(m.links), slots);
    } catch (const std::invalid_argument& error) {
      contradiction({"machine.links", "machine.slots", "machine.dsps"}, error.what(),
                    "links as in \"0.1:1.4\" are expected");
    }
    try {
      machine::parse_slot_nets(m.nets, static_cast<std::size_t>(m.slots == 0 ? m.dsps : m.slots));
    } catch (const std::invalid_argument& error) {
      contradiction({"machine.nets", "machine.slots", "machine.dsps"}, error.what(),
                    "nets as in \"0.TCLK0>1.IIOF1\" are expected");
    }
    require(config_.run.duration_s * 1e3 > config_.host.start_ms, {"run.duration_s", "host.start_ms"},
            fmt::format("a run of {:g} ms ends before the first refresh, at {:g} ms", config_.run.duration_s * 1e3,
                        config_.host.start_ms),
            "a longer run or an earlier start is expected");
    require(config_.bus.latency_timer_clocks % 8 == 0, {"bus.latency_timer_clocks"},
            fmt::format("{} is not a multiple of 8", config_.bus.latency_timer_clocks),
            "PCI's latency timer counts in units of 8 clocks");
    require(!config_.bus.prefetch || config_.bus.latency_timer_clocks >= 32,
            {"bus.latency_timer_clocks", "bus.prefetch"},
            fmt::format("a line of 8 words does not fit into {} clocks", config_.bus.latency_timer_clocks),
            "at least 32 is expected, or bus.prefetch = false");
    for (const UserTask& task : config_.tasks) check_period(task, config_.rates.refresh_frequency_hz);
    heartbeats();
    own_dsps();
    const machine::Topology topology =
        topology_of(config_, [this](const auto& keys, const std::string& what, const std::string& right) {
          contradiction(keys, what, right);
        });
    loads();
    plant();
    for (const Subprocess& row : config_.processes.subprocesses) events(row, topology);
    blocks();
  }

 private:
  void require(bool holds, std::initializer_list<std::string_view> involved, const std::string& what,
               const std::string& right) const {
    if (!holds) contradiction(involved, what, right);
  }

  [[noreturn]] void contradiction(const std::vector<std::string_view>& involved, const std::string& what,
                                  const std::string& right) const {
    for (std::string_view key : involved) {
      if (auto at = origins_.find(key); at != origins_.end()) refuse(at->second, key, what, right);
    }
    refuse({}, involved.front(), what, right);
  }

  void plant() const {
    const auto machine = static_cast<plant::CraneKind>(config_.dock.crane);
    const auto fault = plant_fault(machine, config_.plant, config_.dock.container_mass_kg);
    if (!fault) return;
    std::vector<std::string_view> involved;
    if (fault->of_load) involved.emplace_back("dock.container_mass_kg");
    for (const PlantParameter& row : plant_parameters())
      if (!row.machine || *row.machine == machine) involved.push_back(row.name);
    involved.emplace_back("dock.crane");
    if (!fault->of_load) involved.emplace_back("dock.container_mass_kg");
    contradiction(involved, fault->what, fault->right);
  }

  void control() const {
    const auto fault = control_fault(config_, static_cast<double>(n_.servo) / config_.rates.refresh_frequency_hz);
    if (fault) {
      std::vector<std::string_view> involved(fault->keys.begin(), fault->keys.end());
      involved.emplace_back("rates.servo_frequency_hz");
      contradiction(involved, fault->what, fault->right);
    }
    const double latches = drive_delay_latches(config_);
    require(latches == std::floor(latches), {"dock.drive_delay_us"},
            fmt::format("{:g} us is not a multiple of the latch period", config_.dock.drive_delay_us),
            "a multiple of 125 us is expected: drives take their codes at 8 kHz");
  }

  void loads() const {
    require(config_.dock.wind_gust_m_s == 0 || std::fabs(config_.dock.wind_mean_m_s) >= plant::least_gusty_mean,
            {"dock.wind_gust_m_s", "dock.wind_mean_m_s"}, "gusts are carried by the mean wind",
            fmt::format("without gusts any mean is right; with them a mean of {:g} m/s or more is expected",
                        plant::least_gusty_mean));
    require(!config_.load.driving || !config_.load.parked, {"load.driving", "load.parked"},
            "AGVs cannot both drive and stand", "load.driving or load.parked is expected, not both");
    const auto queues = [](const Process& process) {
      return std::ranges::any_of(process.steps, [](const Step& step) { return step.kind == Step::Kind::queue; });
    };
    require(!config_.load.driving || std::ranges::any_of(config_.processes.processes, queues), {"load.driving"},
            "no process has the step \"queue\", in which an AGV could come back",
            "such a process is expected, or load.driving = false");
  }

  /// A sub-process that is released by event needs sensors that the host can read, and often enough.
  void events(const Subprocess& row, const machine::Topology& topology) const {
    if (!row.by_event()) return;
    const unsigned sensors = topology.devices[static_cast<std::size_t>(machine::DeviceGroup::sensors)];
    const bool reached =
        std::ranges::any_of(topology.host, [&](unsigned bus) { return machine::hops(topology, bus, sensors) >= 0; });
    if (!reached) {
      refuse(
          row.origin, "subprocesses.release",
          fmt::format("sub-process {} is released by event, but the host cannot reach the range sensors on bus {}",
                      row.number, topology.buses[sensors]),
          "release = \"interval\", or bus.topology \"host_on_both\", \"sensors_with_host\" or \"single\", or a bridge "
          "by [topology], is expected");
    }
    const double apart =
        static_cast<double>(config_.scheduling.event_read_refreshes) / config_.rates.refresh_frequency_hz;
    require(apart <= 0.05, {"scheduling.event_read_refreshes", "rates.refresh_frequency_hz"},
            fmt::format("a range sensor is read every {:g} ms", apart * 1e3),
            "at most 50 ms are expected: so that an entering object differs from an approaching one");
  }

  /// The most blocks that can be in the list at once: one for each sub-process of each robot, one for each task with a
  /// period, each process of no robot and an error. Trajectory planning and inverse kinematics are in the list while a
  /// leg is under way, and so is no task that is a step of the same robot.
  void blocks() const {
    const std::int64_t agvs = config_.dock.agvs;
    std::int64_t most = 1;
    for (const UserTask& task : config_.tasks) most += task.period_ms > 0;
    for (const Process& process : config_.processes.processes) most += process.robot == Robots::none;
    for (const Subprocess& row : config_.processes.subprocesses) {
      most += !row.crane.empty();
      most += row.agv.empty() ? 0 : agvs;
      if (most <= usual_block_count) continue;
      refuse(row.origin, "subprocesses.agv",
             fmt::format("with sub-process {} and dock.agvs = {} up to {} or more blocks can be in the list at once, "
                         "which holds {}",
                         row.number, agvs, most, usual_block_count),
             "fewer sub-processes, tasks with a period, or AGVs are expected");
    }
  }

  void heartbeats() const {
    const double limit_ms =
        static_cast<double>(config_.watchdog.minimum_refreshes) / config_.rates.refresh_frequency_hz * 1e3;
    for (const UserTask& task : config_.tasks) {
      if (task.heartbeat_ms <= limit_ms) continue;
      refuse(task.origin, "tasks.heartbeat_ms",
             fmt::format("{:g} ms of \"{}\" are longer than the watchdog's limit, {} refreshes: {:g} ms",
                         task.heartbeat_ms, task.name, config_.watchdog.minimum_refreshes, limit_ms),
             "a shorter heartbeat, none (0), or more watchdog.minimum_refreshes is expected");
    }
  }

  void own_dsps() const {
    const std::int64_t slots = std::max(config_.machine.dsps, config_.machine.slots);
    for (const UserTask& task : config_.tasks) {
      if (!task.dsp || *task.dsp < slots) continue;
      refuse(task.dsp_origin, "tasks.dsp",
             fmt::format("\"{}\" is for DSP {}, and there is no such slot", task.name, *task.dsp),
             slots == 1 ? "0 is expected: there is one slot"
                        : fmt::format("0 to {} is expected, or more machine.dsps or machine.slots", slots - 1));
    }
  }

  void rates() const {
    const auto& r = config_.rates;
    require(r.refresh_frequency_hz >= 2 * r.servo_frequency_hz,
            {"rates.servo_frequency_hz", "rates.refresh_frequency_hz"},
            fmt::format("f_s = {} Hz is less than 2 f_p = {} Hz", r.refresh_frequency_hz, 2 * r.servo_frequency_hz),
            "f_s >= 2 f_p is required, f_s >= 8 f_p is better: a release can be late by 1 / f_s");
    require(r.crane_point_frequency_hz <= r.servo_frequency_hz,
            {"rates.crane_point_frequency_hz", "rates.servo_frequency_hz"},
            fmt::format("f_t = {} Hz is above f_p = {} Hz", r.crane_point_frequency_hz, r.servo_frequency_hz),
            "PID interpolates between points: f_t <= f_p is required");
    require(r.agv_point_frequency_hz <= r.refresh_frequency_hz / 2,
            {"rates.agv_point_frequency_hz", "rates.refresh_frequency_hz"},
            fmt::format("f_a = {} Hz is above f_s / 2 = {} Hz", r.agv_point_frequency_hz, r.refresh_frequency_hz / 2),
            "f_a <= f_s / 2 is required");
  }

  void errors() const {
    const auto& e = config_.errors;
    for (auto [key, limit] : {std::pair{"errors.following_travel_m", e.following_travel_m},
                              std::pair{"errors.following_slew_mrad", e.following_slew_mrad},
                              std::pair{"errors.following_luff_mrad", e.following_luff_mrad},
                              std::pair{"errors.following_trolley_m", e.following_trolley_m},
                              std::pair{"errors.following_hoist_m", e.following_hoist_m},
                              std::pair{"errors.following_rotator_mrad", e.following_rotator_mrad},
                              std::pair{"errors.encoder_speed_percent", e.encoder_speed_percent}}) {
      require(limit > 0, {key}, "a limit of 0 makes an error of every tick", "a limit above 0 is required");
    }
    const double servo_ms = static_cast<double>(n_.servo) / config_.rates.refresh_frequency_hz * 1e3;
    for (auto [key, ms] :
         {std::pair{"errors.following_ms", e.following_ms}, std::pair{"errors.encoder_ms", e.encoder_ms},
          std::pair{"errors.stop_s", e.stop_s * 1e3}, std::pair{"errors.go_on_s", e.go_on_s * 1e3}}) {
      require(ms >= servo_ms, {key, "rates.servo_frequency_hz", "rates.refresh_frequency_hz"},
              fmt::format("{:g} ms is shorter than a servo period, {:g} ms", ms, servo_ms),
              "PID sees an error once per servo period: at least one is required");
    }
  }

  void importance() const {
    const auto& s = config_.scheduling;
    require(s.q < s.p, {"scheduling.q", "scheduling.p"}, fmt::format("q = {:#x} is not below p = {:#x}", s.q, s.p),
            "0 < q < p is required (8)");
    require(s.p + s.b < 0x7FFF, {"scheduling.p", "scheduling.b"}, fmt::format("p + b = {:#x}", s.p + s.b),
            "p + b < 0x7fff is required (8)");
    const std::int64_t oldest = s.q + s.b + s.a * (s.agv_interval_max_refreshes - s.beta_refreshes - 1);
    require(oldest < 0x7FFF, {"scheduling.a", "scheduling.agv_interval_max_refreshes", "scheduling.q", "scheduling.b"},
            fmt::format("an ageing AGV block reaches q + b + a (N^_a,max - beta - 1) = {:#x}", oldest),
            fmt::format("it must stay below 0x7fff: a <= {} with these q, b and N^_a,max",
                        (0x7FFE - s.q - s.b) / s.agv_interval_max_refreshes));
    require(s.p - s.q >= s.a, {"scheduling.a", "scheduling.p", "scheduling.q"},
            fmt::format("ageing overtakes the crane's planning after (p - q) / a = {:.3g} refreshes",
                        static_cast<double>(s.p - s.q) / static_cast<double>(s.a)),
            "at least 1 is required, about half of N^_a is good");
  }

  void leads() const {
    const auto& s = config_.scheduling;
    require(s.gamma_refreshes < n_.servo, {"scheduling.gamma_refreshes", "rates.servo_frequency_hz"},
            fmt::format("gamma = {} is not below N_p = {}", s.gamma_refreshes, n_.servo),
            "0 <= gamma < N_p is required");
    require(n_.agv_point <= n_.agv_slowed, {"scheduling.agv_interval_refreshes", "rates.agv_point_frequency_hz"},
            fmt::format("N^_a = {} is below N_a = {}", n_.agv_slowed, n_.agv_point),
            "N_a <= N^_a <= N^_a,max is required; 0 means N_a");
    require(n_.agv_slowed <= s.agv_interval_max_refreshes,
            {"scheduling.agv_interval_refreshes", "scheduling.agv_interval_max_refreshes", "scheduling.slow_factor",
             "scheduling.work_mode", "rates.agv_point_frequency_hz", "rates.refresh_frequency_hz"},
            fmt::format("N^_a = {} is above N^_a,max = {}", n_.agv_slowed, s.agv_interval_max_refreshes),
            "N_a <= N^_a <= N^_a,max is required");
    const std::int64_t shortest = std::min(n_.crane_point, n_.agv_slowed);
    for (auto [key, symbol, value] : {std::tuple{"scheduling.alpha_refreshes", "alpha", s.alpha_refreshes},
                                      std::tuple{"scheduling.beta_refreshes", "beta", s.beta_refreshes}}) {
      require(value < shortest,
              {key, "rates.crane_point_frequency_hz", "rates.agv_point_frequency_hz", "rates.refresh_frequency_hz"},
              fmt::format("{} = {} is not below min(N_t, N^_a) = {}", symbol, value, shortest),
              fmt::format("0 <= {} < {} is required", symbol, shortest));
    }
  }

  const Config& config_;
  Intervals n_;
  const std::map<std::string, Origin, std::less<>> origins_;
};

}  // namespace

void check_invariants(const Config& config, std::map<std::string, Origin, std::less<>> origins) {
  Invariants(config, std::move(origins)).check();
}

}  // namespace cmrc
