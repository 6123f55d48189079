#include "cmrc/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <sstream>
#include <toml++/toml.h>

#include "cmrc/control.hpp"
#include "cmrc/process_rows.hpp"
#include "cmrc/topology.hpp"

namespace cmrc {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

std::string_view leaf(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? key : key.substr(dot + 1);
}

/// The known key that the user most likely meant: by the whole name, and by the part after the table.
std::string_view nearest(std::string_view key) {
  std::string_view best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const Key& known : keys()) {
    const std::size_t distance =
        std::min(edit_distance(key, known.name), edit_distance(leaf(key), leaf(known.name)) + 1);
    if (distance < least) {
      least = distance;
      best = known.name;
    }
  }
  return best;
}

std::optional<std::size_t> find(std::string_view key) {
  const auto all = keys();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == key) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> find_leaf(std::string_view key) {
  const auto all = keys();
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (leaf(all[i].name) != key) continue;
    if (found) return std::nullopt;
    found = i;
  }
  return found;
}

std::string what_is_right(const Key& key) {
  switch (key.type) {
    case Key::Type::boolean: return "true or false is expected";
    case Key::Type::text: return "a string is expected";
    case Key::Type::choice: return quoted_list(key.choices) + " is expected";
    default: break;
  }
  const std::string_view noun = key.type == Key::Type::integer ? "an integer" : "a number";
  const std::string unit = key.unit.empty() ? "" : " (" + key.unit + ")";
  if (std::isinf(key.maximum)) return fmt::format("{} of at least {} is expected{}", noun, key.minimum, unit);
  return fmt::format("{} from {} to {} is expected{}", noun, key.minimum, key.maximum, unit);
}

/// The value in the key's own type, range checked.
Value checked(const Key& key, const Value& value, const Origin& origin) {
  const auto ill_typed = [&]() -> Value { refuse(origin, key.name, fmt::format("{} is {}", show(value), noun(value)),
                                               what_is_right(key)); };
  const auto out_of_range = [&]() -> Value { refuse(origin, key.name, fmt::format("{} is out of range", show(value)),
                                                  what_is_right(key)); };
  switch (key.type) {
    case Key::Type::boolean: return std::holds_alternative<bool>(value) ? value : ill_typed();
    case Key::Type::text: return std::holds_alternative<std::string>(value) ? value : ill_typed();
    case Key::Type::choice: {
      const auto* word = std::get_if<std::string>(&value);
      if (word == nullptr) return ill_typed();
      if (std::find(key.choices.begin(), key.choices.end(), *word) == key.choices.end()) {
        refuse(origin, key.name, fmt::format("{} is not known", show(value)), what_is_right(key));
      }
      return value;
    }
    case Key::Type::integer: {
      const auto* integer = std::get_if<std::int64_t>(&value);
      if (integer == nullptr) return ill_typed();
      const auto wide = static_cast<double>(*integer);
      return wide < key.minimum || wide > key.maximum ? out_of_range() : value;
    }
    case Key::Type::number: {
      double number = 0;
      if (const auto* real = std::get_if<double>(&value)) number = *real;
      else if (const auto* integer = std::get_if<std::int64_t>(&value)) number = static_cast<double>(*integer);
      else return ill_typed();
      if (!(number >= key.minimum && number <= key.maximum)) return out_of_range();
      return number;
    }
  }
  return value;
}

Origin origin_of(const toml::source_region& region, const std::string& name) {
  return {name, static_cast<std::int64_t>(region.begin.line), static_cast<std::int64_t>(region.begin.column)};
}

Value value_of(const toml::node& node, std::string_view key, const Origin& origin) {
  if (const auto* v = node.as_boolean()) return v->get();
  if (const auto* v = node.as_integer()) return v->get();
  if (const auto* v = node.as_floating_point()) return v->get();
  if (const auto* v = node.as_string()) return v->get();
  refuse(origin, key, "arrays, tables and dates are not used here", "a boolean, a number or a string is expected");
}

/// The tables of [[events]] or [[tasks]], as fields with their places.
std::vector<std::pair<std::map<std::string, Field>, Origin>> tables_of(const toml::node& node, const std::string& kind, const std::string& name) {
  const toml::array* list = node.as_array();
  if (list == nullptr || !list->is_homogeneous<toml::table>()) {
    refuse(origin_of(node.source(), name), kind, "is no list of tables", fmt::format("[[{}]] begins each of them", kind));
  }
  std::vector<std::pair<std::map<std::string, Field>, Origin>> all;
  for (const toml::node& element : *list) {
    std::map<std::string, Field> fields;
    for (const auto& [key, field] : *element.as_table()) {
      const Origin origin = origin_of(field.source(), name);
      fields[std::string(key.str())] = {value_of(field, kind + "." + std::string(key.str()), origin), origin};
    }
    all.emplace_back(std::move(fields), origin_of(element.source(), name));
  }
  return all;
}

bool is_table(std::string_view key) {
  return std::any_of(keys().begin(), keys().end(), [&](const Key& known) {
    return known.name.size() > key.size() && known.name.starts_with(key) && known.name[key.size()] == '.';
  });
}

void check_preset(std::string_view name, const Origin& origin) {
  std::vector<std::string> names;
  for (const Preset& known : presets()) {
    if (known.name == name) return;
    names.emplace_back(known.name);
  }
  refuse(origin, "preset", fmt::format("\"{}\" is not known", name), quoted_list(names) + " is expected");
}

/// The invariants of plant-and-bus.md 4.5; an error names the place of the key that was set, if any was.
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
    require(m.slots == 0 || m.slots >= m.dsps, {"machine.slots", "machine.dsps"}, fmt::format("{} DSPs in {} slots", m.dsps, m.slots),
            "machine.slots >= machine.dsps is required, or 0");
    require(config_.run.duration_s * 1e3 > config_.host.start_ms, {"run.duration_s", "host.start_ms"},
            fmt::format("a run of {:g} ms ends before the first refresh, at {:g} ms", config_.run.duration_s * 1e3, config_.host.start_ms),
            "a longer run or an earlier start is expected");
    require(config_.bus.latency_timer_clocks % 8 == 0, {"bus.latency_timer_clocks"},
            fmt::format("{} is not a multiple of 8", config_.bus.latency_timer_clocks), "PCI's latency timer counts in units of 8 clocks");
    require(!config_.bus.prefetch || config_.bus.latency_timer_clocks >= 32, {"bus.latency_timer_clocks", "bus.prefetch"},
            fmt::format("a line of 8 words does not fit into {} clocks", config_.bus.latency_timer_clocks),
            "at least 32 is expected, or bus.prefetch = false");
    heartbeats();
    const machine::Topology topology =
        topology_of(config_, [this](const auto& keys, const std::string& what, const std::string& right) { contradiction(keys, what, right); });
    loads();
    plant();
    for (const Subprocess& row : config_.processes.subprocesses) events(row, topology);
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
    const auto machine = static_cast<plant::Machine>(config_.dock.crane);
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

  void loads() const {
    require(!config_.load.driving || !config_.load.parked, {"load.driving", "load.parked"}, "AGVs cannot drive and stand",
            "load.driving or load.parked is expected, not both");
    const auto queues = [](const Process& process) {
      return std::ranges::any_of(process.steps, [](const Step& step) { return step.kind == Step::Kind::queue; });
    };
    require(!config_.load.driving || std::ranges::any_of(config_.processes.processes, queues), {"load.driving"},
            "no process has the step \"queue\", in which an AGV could come back", "such a process is expected, or load.driving = false");
  }

  /// A sub-process that is released by event needs sensors that the host can read, often enough.
  void events(const Subprocess& row, const machine::Topology& topology) const {
    if (!row.by_event()) return;
    const unsigned sensors = topology.devices[static_cast<std::size_t>(machine::DeviceGroup::sensors)];
    const bool reached = std::ranges::any_of(topology.host, [&](unsigned bus) { return machine::hops(topology, bus, sensors) >= 0; });
    if (!reached) {
      refuse(row.origin, "subprocesses.release",
             fmt::format("sub-process {} is released by event, but the host cannot reach the range sensors on bus {}", row.number, topology.buses[sensors]),
             "release = \"interval\", or bus.topology \"host_on_both\", \"sensors_with_host\" or \"single\", or a way by [topology], is expected");
    }
    const double apart = static_cast<double>(config_.scheduling.event_read_refreshes) / config_.rates.refresh_frequency_hz;
    require(apart <= 0.05, {"scheduling.event_read_refreshes", "rates.refresh_frequency_hz"},
            fmt::format("a range sensor is read every {:g} ms", apart * 1e3), "at most 50 ms are expected: objects that enter are told from those that come closer");
  }

  void heartbeats() const {
    const double limit_ms = static_cast<double>(config_.watchdog.minimum_refreshes) / config_.rates.refresh_frequency_hz * 1e3;
    for (const UserTask& task : config_.tasks) {
      if (task.heartbeat_ms <= limit_ms) continue;
      refuse(task.origin, "tasks.heartbeat_ms", fmt::format("{:g} ms of \"{}\" are longer than the watchdog's limit, {} refreshes: {:g} ms", task.heartbeat_ms, task.name,
                                                            config_.watchdog.minimum_refreshes, limit_ms),
             "a shorter heartbeat, none (0), or more watchdog.minimum_refreshes is expected");
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
    for (auto [key, limit] : {std::pair{"errors.following_travel_m", e.following_travel_m}, std::pair{"errors.following_slew_mrad", e.following_slew_mrad},
                              std::pair{"errors.following_luff_mrad", e.following_luff_mrad}, std::pair{"errors.following_trolley_m", e.following_trolley_m},
                              std::pair{"errors.following_hoist_m", e.following_hoist_m}, std::pair{"errors.following_rotator_mrad", e.following_rotator_mrad},
                              std::pair{"errors.encoder_speed_percent", e.encoder_speed_percent}}) {
      require(limit > 0, {key}, "a limit of 0 makes an error of every tick", "a limit above 0 is required");
    }
    const double servo_ms = static_cast<double>(n_.servo) / config_.rates.refresh_frequency_hz * 1e3;
    for (auto [key, ms] : {std::pair{"errors.following_ms", e.following_ms}, std::pair{"errors.encoder_ms", e.encoder_ms}, std::pair{"errors.stop_s", e.stop_s * 1e3}, std::pair{"errors.go_on_s", e.go_on_s * 1e3}}) {
      require(ms >= servo_ms, {key, "rates.servo_frequency_hz", "rates.refresh_frequency_hz"},
              fmt::format("{:g} ms is shorter than a servo period, {:g} ms", ms, servo_ms), "PID sees an error once per servo period: at least one is required");
    }
  }

  void control() const {
    const auto fault = control_fault(config_, static_cast<double>(n_.servo) / config_.rates.refresh_frequency_hz);
    if (fault) contradiction({fault->key, "rates.servo_frequency_hz"}, fault->what, fault->right);
    const double latches = config_.dock.drive_delay_us / 125;
    require(latches == std::floor(latches), {"dock.drive_delay_us"}, fmt::format("{:g} us are no whole number of latches", config_.dock.drive_delay_us),
            "a multiple of 125 us is expected: drives take their codes at 8 kHz");
  }

  void importance() const {
    const auto& s = config_.scheduling;
    require(s.q < s.p, {"scheduling.q", "scheduling.p"}, fmt::format("q = {:#x} is not below p = {:#x}", s.q, s.p),
            "0 < q < p is required (8)");
    require(s.p + s.b < 0x7FFF, {"scheduling.p", "scheduling.b"}, fmt::format("p + b = {:#x}", s.p + s.b),
            "p + b < 0x7fff is required (8)");
    const std::int64_t oldest = s.q + s.b + s.a * (s.agv_interval_max_refreshes - s.beta_refreshes - 1);
    require(oldest < 0x7FFF,
            {"scheduling.a", "scheduling.agv_interval_max_refreshes", "scheduling.q", "scheduling.b"},
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
            fmt::format("gamma = {} is not below N_p = {}", s.gamma_refreshes, n_.servo), "0 <= gamma < N_p is required");
    require(n_.agv_point <= n_.agv_slowed, {"scheduling.agv_interval_refreshes", "rates.agv_point_frequency_hz"},
            fmt::format("N^_a = {} is below N_a = {}", n_.agv_slowed, n_.agv_point),
            "N_a <= N^_a <= N^_a,max is required; 0 means N_a");
    require(n_.agv_slowed <= s.agv_interval_max_refreshes,
            {"scheduling.agv_interval_refreshes", "scheduling.agv_interval_max_refreshes", "scheduling.slow_factor", "scheduling.work_mode",
             "rates.agv_point_frequency_hz", "rates.refresh_frequency_hz"},
            fmt::format("N^_a = {} is above N^_a,max = {}", n_.agv_slowed, s.agv_interval_max_refreshes),
            "N_a <= N^_a <= N^_a,max is required");
    const std::int64_t shortest = std::min(n_.crane_point, n_.agv_slowed);
    for (auto [key, symbol, value] : {std::tuple{"scheduling.alpha_refreshes", "alpha", s.alpha_refreshes},
                                      std::tuple{"scheduling.beta_refreshes", "beta", s.beta_refreshes}}) {
      require(value < shortest, {key, "rates.crane_point_frequency_hz", "rates.agv_point_frequency_hz",
                                 "rates.refresh_frequency_hz"},
              fmt::format("{} = {} is not below min(N_t, N^_a) = {}", symbol, value, shortest),
              fmt::format("0 <= {} < {} is required", symbol, shortest));
    }
  }

  const Config& config_;
  Intervals n_;
  const std::map<std::string, Origin, std::less<>> origins_;
};

}  // namespace

Intervals intervals(const Config& config) {
  const auto& r = config.rates;
  const auto floor_of = [&](double frequency) {
    // A ratio that is whole but for the rounding of the division counts as whole.
    return static_cast<std::int64_t>(std::floor(r.refresh_frequency_hz / frequency * (1 + 1e-12)));
  };
  const auto& s = config.scheduling;
  const auto slowed = [&](std::int64_t n, WorkMode mode) {
    return s.work_mode == mode ? static_cast<std::int64_t>(std::llround(static_cast<double>(n) * s.slow_factor)) : n;
  };
  Intervals n{floor_of(r.servo_frequency_hz), floor_of(r.crane_point_frequency_hz), floor_of(r.agv_point_frequency_hz), 0, 0};
  n.agv_slowed = s.agv_interval_refreshes == 0 ? slowed(n.agv_point, WorkMode::slowed_agv) : s.agv_interval_refreshes;
  n.crane_slowed = slowed(n.crane_point, WorkMode::slowed_crane);
  return n;
}

ConfigBuilder& ConfigBuilder::preset(std::string_view name, const Origin& origin) {
  check_preset(name, origin);
  flag_preset_ = name;
  return *this;
}

ConfigBuilder& ConfigBuilder::file(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw ConfigError(fmt::format("{}: cannot be read; the name of a TOML file is expected", path));
  std::stringstream content;
  content << in.rdbuf();
  if (in.bad()) throw ConfigError(fmt::format("{}: cannot be read; the name of a TOML file is expected", path));
  return text(content.str(), path);
}

ConfigBuilder& ConfigBuilder::text(std::string_view toml, const std::string& name) {
  parse(toml, name, file_settings_);
  return *this;
}

ConfigBuilder& ConfigBuilder::set(std::string_view key, const Value& value, const Origin& origin) {
  if (key == "preset") {
    if (const auto* word = std::get_if<std::string>(&value)) return preset(*word, origin);
    refuse(origin, "preset", show(value) + " is " + std::string(noun(value)), "the name of a preset is expected");
  }
  auto index = find(key);
  if (!index) index = find_leaf(key);
  if (!index) refuse(origin, key, "no such key", fmt::format("the nearest known key is {}", nearest(key)));
  flag_settings_.push_back({*index, checked(keys()[*index], value, origin), origin});
  return *this;
}

void ConfigBuilder::parse(std::string_view toml, const std::string& name, std::vector<Setting>& into) {
  const auto walk = [&](const auto& self, const toml::table& table, const std::string& prefix) -> void {
    for (const auto& [key, node] : table) {
      const std::string full = prefix + std::string(key.str());
      const Origin key_origin = origin_of(key.source(), name);
      if (full == "preset" && node.is_string()) {
        file_preset_ = node.as_string()->get();
        check_preset(*file_preset_, origin_of(node.source(), name));
        continue;
      }
      if (node.is_table() && is_table(full)) {
        self(self, *node.as_table(), full + ".");
        continue;
      }
      if (full == "events") {
        for (const auto& [fields, where] : tables_of(node, full, name)) event(timed_event(fields, where));
        continue;
      }
      if (full == "tasks") {
        for (const auto& [fields, where] : tables_of(node, full, name)) tasks_.push_back(user_task(fields, where));
        continue;
      }
      if (full == "processes" || full == "subprocesses") {
        full == "processes" ? read_processes(node, name, processes_) : read_subprocesses(node, name, processes_);
        continue;
      }
      const auto index = find(full);
      if (!index) {
        // Of an unknown table, the first key inside says more than the table's own name.
        if (node.is_table() && !node.as_table()->empty()) {
          self(self, *node.as_table(), full + ".");
          continue;
        }
        refuse(key_origin, full, "no such key", fmt::format("the nearest known key is {}", nearest(full)));
      }
      const Origin origin = origin_of(node.source(), name);
      into.push_back({*index, checked(keys()[*index], value_of(node, full, origin), origin), key_origin});
    }
  };
  try {
    walk(walk, toml::parse(toml, name), "");
  } catch (const toml::parse_error& error) {
    const Origin origin = origin_of(error.source(), name);
    throw ConfigError(fmt::format("{}: {}; valid TOML 1.0 is expected", origin.text(), error.description()));
  }
}

Config ConfigBuilder::build() const {
  const auto is_driving = [](const Setting& setting) { return keys()[setting.key].name == "load.driving"; };
  Config config;
  std::map<std::string, Origin, std::less<>> origins;
  const auto apply = [&](const std::vector<Setting>& settings) {
    for (const Setting& setting : settings) {
      keys()[setting.key].assign(config, setting.value);
      origins.insert_or_assign(keys()[setting.key].name, setting.origin);
    }
  };
  if (const auto& chosen = flag_preset_ ? flag_preset_ : file_preset_) {
    for (const Preset& preset : presets()) {
      if (preset.name != *chosen) continue;
      ConfigBuilder parser;
      std::vector<Setting> settings;
      parser.parse(preset.toml, fmt::format("preset {}", preset.name), settings);
      apply(settings);
    }
  }
  const bool preset_drives = config.load.driving;
  apply(file_settings_);
  apply(flag_settings_);
  const bool own = std::ranges::any_of(file_settings_, is_driving) || std::ranges::any_of(flag_settings_, is_driving);
  if (preset_drives && config.load.parked && !own) config.load.driving = false;
  config.events = events_;
  config.tasks = tasks_;
  config.processes = processes_;
  check_user_tasks(config.tasks);
  check(config.processes, config.tasks);
  Invariants(config, origins).check();
  if (config.errors.clear) {
    const auto at = origins.find("errors.clear");
    refuse(at == origins.end() ? Origin{} : at->second, "errors.clear", "no error stands before the run", "an event \"set\" of this key is expected");
  }
  check_events(config);
  return config;
}

ConfigBuilder& ConfigBuilder::event(TimedEvent event) {
  events_.push_back(std::move(event));
  return *this;
}

void check_live(std::string_view name, const Value& value, const Origin& origin) {
  const auto index = find(name);
  if (!index) refuse(origin, name, "no such key", fmt::format("the nearest known key is {}", nearest(name)));
  const Key& key = keys()[*index];
  if (!key.live) refuse(origin, name, "cannot be changed while a run is on", "docs/configuration.md marks the keys that can");
  checked(key, value, origin);
}

KeyBits bits_of(std::string_view name, const Value& value) {
  const std::size_t index = find(name).value();
  const Key& key = keys()[index];
  const Value exact = checked(key, value, {});
  std::uint64_t bits = 0;
  if (const auto* flag = std::get_if<bool>(&exact)) bits = *flag ? 1 : 0;
  else if (const auto* integer = std::get_if<std::int64_t>(&exact)) bits = static_cast<std::uint64_t>(*integer);
  else if (const auto* number = std::get_if<double>(&exact)) bits = std::bit_cast<std::uint64_t>(*number);
  else bits = static_cast<std::uint64_t>(std::ranges::find(key.choices, std::get<std::string>(exact)) - key.choices.begin());
  return {static_cast<std::uint32_t>(index), bits};
}

Config with_live(const Config& config, std::string_view name, const Value& value, const Origin& origin) {
  check_live(name, value, origin);
  return with_key(config, name, value, origin);
}

Config with_key(const Config& config, std::string_view name, const Value& value, const Origin& origin) {
  const auto index = find(name);
  if (!index) refuse(origin, name, "no such key", fmt::format("the nearest known key is {}", nearest(name)));
  const Key& key = keys()[*index];
  Config changed = config;
  key.assign(changed, checked(key, value, origin));
  Invariants(changed, {{std::string(name), origin}}).check();
  return changed;
}

std::string to_toml(const Config& config) {
  std::string text;
  std::string_view table;
  for (const Key& key : keys()) {
    const std::string_view in = std::string_view(key.name).substr(0, key.name.rfind('.'));
    if (in != table) {
      text += fmt::format("{}[{}]\n", table.empty() ? "" : "\n", in);
      table = in;
    }
    text += fmt::format("{} = {}\n", leaf(key.name), show(key.read(config)));
  }
  for (const UserTask& task : config.tasks) text += "\n[[tasks]]\n" + to_toml(task);
  text += to_toml(config.processes);
  for (const TimedEvent& event : config.events) text += "\n[[events]]\n" + to_toml(event);
  return text;
}

}  // namespace cmrc
