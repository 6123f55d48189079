#include "cmrc/configuration/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <map>

#include "cmrc/configuration/config_invariants.hpp"
#include "cmrc/configuration/rows/process_rows.hpp"
#include "io/nearest.hpp"
#include "io/print.hpp"
#include "io/text_form.hpp"
#include "io/toml.hpp"

namespace cmrc {
namespace {

std::string_view leaf(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? key : key.substr(dot + 1);
}

}  // namespace

std::string right_key(std::string_view key) {
  std::string_view best;
  const std::string_view given = leaf(key);
  const std::size_t most = io::most_wrong(given);
  // No key is the given one, so that no distance is below 1. What is not nearer than the best is not measured.
  std::size_t least = most + 2;
  for (const Key& known : keys()) {
    if (least == 1) break;
    const std::size_t in_whole = std::min(most, least - 1);
    if (const std::size_t whole = io::edit_distance(key, known.name, in_whole); whole <= in_whole)
      least = whole, best = known.name;
    if (least == 1) break;
    const std::size_t in_part = std::min(most, least - 2);
    if (const std::size_t part = io::edit_distance(given, leaf(known.name), in_part); part <= in_part)
      least = part + 1, best = known.name;
  }
  std::vector<std::string_view> alike;
  for (const Key& known : keys())
    if (io::has_in_it(known.name, given)) alike.push_back(known.name);
  if (best.empty() && alike.size() == 1) best = alike.front();
  if (!best.empty()) return io::meant(best);
  if (!alike.empty() && alike.size() <= 8) return fmt::format("keys with that word are {}", fmt::join(alike, ", "));
  const std::string_view table = key.substr(0, key.size() - given.size());
  std::vector<std::string_view> others;
  if (!table.empty())
    for (const Key& known : keys())
      if (known.name.starts_with(table)) others.push_back(known.name);
  if (others.empty()) return "docs/configuration.md lists the keys";
  return fmt::format("the keys of its table are {}", fmt::join(others, ", "));
}

namespace {

/// The tables of keys, with the lists of tables in brackets: "[run]", "[agv.vehicle]", "[[events]]".
std::vector<std::string> table_names() {
  std::vector<std::string> names{"[[events]]", "[[tasks]]", "[[processes]]", "[[subprocesses]]"};
  for (const Key& known : keys()) {
    const std::string table = fmt::format("[{}]", known.name.substr(0, known.name.rfind('.')));
    if (std::find(names.begin(), names.end(), table) == names.end()) names.push_back(table);
  }
  return names;
}

/// \throws ConfigError that names the most likely table, or all tables
[[noreturn]] void refuse_table(const Origin& origin, const std::string& table) {
  const std::vector<std::string> names = table_names();
  std::map<std::string_view, std::string_view> with_brackets;
  std::vector<std::string_view> bare;
  for (const std::string_view name : names) {
    const std::size_t first = name.find_first_not_of('['), last = name.find(']');
    bare.push_back(name.substr(first, last - first));
    with_brackets[bare.back()] = name;
  }
  if (const std::string_view near = io::nearest(table, bare, io::most_wrong(table)); !near.empty())
    refuse(origin, table, "no such table", io::meant(with_brackets[near]));
  refuse(origin, table, "no such table", fmt::format("the tables are {}", fmt::join(names, ", ")));
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

constexpr double exact_integers = 9007199254740992.0;  // 2^53: up to here every integer is a double

/// The value in the key's own type, range checked. A number without a fraction is an integer.
Value checked(const Key& key, const Value& value, const Origin& origin) {
  const auto ill_typed = [&]() -> Value {
    refuse(origin, key.name, fmt::format("{} is {}", show(value), noun(value)), what_is_right(key));
  };
  const auto out_of_range = [&]() -> Value {
    refuse(origin, key.name, fmt::format("{} is out of range", show(value)), what_is_right(key));
  };
  switch (key.type) {
    case Key::Type::boolean: return std::holds_alternative<bool>(value) ? value : ill_typed();
    case Key::Type::text: {
      const auto* text = std::get_if<std::string>(&value);
      if (text == nullptr) return ill_typed();
      // Reports and snapshots have the configuration as JSON and TOML, which have no other bytes.
      if (!io::is_utf8(*text))
        refuse(origin, key.name, fmt::format("{} is not UTF-8", show(value)), "a text in UTF-8 is expected");
      return value;
    }
    case Key::Type::choice: {
      const auto* word = std::get_if<std::string>(&value);
      if (word == nullptr) return ill_typed();
      if (std::find(key.choices.begin(), key.choices.end(), *word) == key.choices.end()) {
        refuse(origin, key.name, fmt::format("{} is not known", show(value)), one_expected(*word, key.choices));
      }
      return value;
    }
    case Key::Type::integer: {
      const auto* real = std::get_if<double>(&value);
      if (real != nullptr && *real != std::floor(*real)) return ill_typed();  // 4.0 is 4; NaN is not an integer
      if (real != nullptr && !(std::abs(*real) <= exact_integers)) return out_of_range();
      const auto* whole = std::get_if<std::int64_t>(&value);
      if (real == nullptr && whole == nullptr) return ill_typed();
      const std::int64_t integer = real != nullptr ? static_cast<std::int64_t>(*real) : *whole;
      const auto wide = static_cast<double>(integer);
      return wide < key.minimum || wide > key.maximum ? out_of_range() : Value(integer);
    }
    case Key::Type::number: {
      double number = 0;
      if (const auto* real = std::get_if<double>(&value))
        number = *real;
      else if (const auto* integer = std::get_if<std::int64_t>(&value))
        number = static_cast<double>(*integer);
      else
        return ill_typed();
      if (!(number >= key.minimum && number <= key.maximum)) return out_of_range();
      return number;
    }
  }
  return value;
}

bool is_path(const Key& key, const Value& value) { return key.path && value != key.read(Config{}); }

/// The value of a key in a file in `folder`.
Value below(const std::filesystem::path& folder, const Key& key, const Value& value) {
  if (folder.empty() || !is_path(key, value)) return value;
  return (folder / std::get<std::string>(value)).string();
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

/// Reads the tables of [[events]] or [[tasks]]: `read` gets the fields of each with their places.
template <class Read>
void each_table(const toml::node& node, const std::string& kind, const std::string& name, ConfigErrors& errors,
                Read read) {
  const toml::array* list = node.as_array();
  if (list == nullptr || !list->is_homogeneous<toml::table>()) {
    refuse(origin_of(node.source(), name), kind, "is not a list of tables",
           fmt::format("[[{}]] begins each of them", kind));
  }
  for (const toml::node& element : *list) {
    const Origin place = origin_of(element.source(), name);
    errors.attempt(place, [&] {
      std::map<std::string, Field> fields;
      for (const auto& [key, field] : *element.as_table()) {
        const Origin origin = origin_of(field.source(), name);
        fields[std::string(key.str())] = {value_of(field, kind + "." + std::string(key.str()), origin), origin};
      }
      read(fields, place);
    });
  }
}

bool is_table(std::string_view key) {
  return std::any_of(keys().begin(), keys().end(), [&](const Key& known) {
    return known.name.size() > key.size() && known.name.starts_with(key) && known.name[key.size()] == '.';
  });
}

/// Whether it is a table with a key that is known in one other table.
bool has_known_leaf(const toml::node& node) {
  const toml::table* table = node.as_table();
  return table != nullptr &&
         std::any_of(table->begin(), table->end(), [](const auto& inner) { return find_leaf(inner.first.str()); });
}

void check_preset(std::string_view name, const Origin& origin) {
  std::vector<std::string> names;
  for (const Preset& known : presets()) {
    if (known.name == name) return;
    names.emplace_back(known.name);
  }
  refuse(origin, "preset", fmt::format("\"{}\" is not known", name), one_expected(name, names));
}

}  // namespace

Intervals intervals(const Config& config) {
  const auto& r = config.rates;
  const auto floor_of = [&](double frequency) {
    // A ratio that is an integer except for the rounding of the division counts as an integer.
    return static_cast<std::int64_t>(std::floor(r.refresh_frequency_hz / frequency * (1 + 1e-12)));
  };
  const auto& s = config.scheduling;
  const auto slowed = [&](std::int64_t n, WorkMode mode) {
    return s.work_mode == mode ? static_cast<std::int64_t>(std::llround(static_cast<double>(n) * s.slow_factor)) : n;
  };
  Intervals n{floor_of(r.servo_frequency_hz), floor_of(r.crane_point_frequency_hz), floor_of(r.agv_point_frequency_hz),
              0, 0};
  n.agv_slowed = s.agv_interval_refreshes == 0 ? slowed(n.agv_point, WorkMode::slowed_agv) : s.agv_interval_refreshes;
  n.crane_slowed = slowed(n.crane_point, WorkMode::slowed_crane);
  return n;
}

ImportanceParameters importance_parameters(const Config& config) {
  const Intervals n = intervals(config);
  const auto& s = config.scheduling;
  return {s.equation, n.servo, n.crane_point, n.agv_slowed, s.gamma_refreshes, s.alpha_refreshes, s.beta_refreshes,
          s.p,        s.q,     s.b,           s.a};
}

ConfigBuilder& ConfigBuilder::preset(std::string_view name, const Origin& origin) {
  check_preset(name, origin);
  flag_preset_ = name;
  return *this;
}

ConfigBuilder& ConfigBuilder::file(const std::string& path) {
  const std::string toml = io::read_text<ConfigError>(path, "the name of a TOML file");
  std::error_code error;
  const bool has_folder = std::filesystem::is_regular_file(path, error);
  parse(toml, path, file_settings_, has_folder ? std::filesystem::path(path).parent_path() : std::filesystem::path());
  return *this;
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
  if (!index) refuse(origin, key, "no such key", right_key(key));
  flag_settings_.push_back({*index, checked(keys()[*index], value, origin), origin});
  return *this;
}

void ConfigBuilder::parse(std::string_view toml, const std::string& name, std::vector<Setting>& into,
                          const std::filesystem::path& folder) {
  ConfigErrors errors;
  const auto walk = [&](const auto& self, const toml::table& table, const std::string& prefix) -> void {
    const auto read = [&](const std::string& full, const Origin& key_origin, const toml::node& node) {
      const auto index = find(full);
      const Origin origin = origin_of(node.source(), name);
      if (full == "preset" && node.is_string()) {
        file_preset_ = node.as_string()->get();
        check_preset(*file_preset_, origin);
      } else if (node.is_table() && is_table(full)) {
        self(self, *node.as_table(), full + ".");
      } else if (full == "events") {
        each_table(node, full, name, errors,
                   [&](const auto& fields, const Origin& place) { event(timed_event(fields, place)); });
      } else if (full == "tasks") {
        each_table(node, full, name, errors,
                   [&](const auto& fields, const Origin& place) { tasks_.push_back(user_task(fields, place)); });
      } else if (full == "processes") {
        read_processes(node, name, processes_, errors);
      } else if (full == "subprocesses") {
        read_subprocesses(node, name, processes_, errors);
      } else if (index) {
        const Key& key = keys()[*index];
        into.push_back({*index, below(folder, key, checked(key, value_of(node, full, origin), origin)), key_origin});
      } else if (has_known_leaf(node)) {  // the errors of its keys say more than the error of the table
        self(self, *node.as_table(), full + ".");
      } else if (const toml::array* list = node.as_array();
                 node.is_table() || (list != nullptr && list->is_homogeneous<toml::table>())) {
        refuse_table(key_origin, full);
      } else if (const auto meant = find_leaf(full)) {
        const std::string_view known = keys()[*meant].name;
        refuse(
            key_origin, full, "no such key outside a table",
            fmt::format("{} is expected, below [{}]", known, known.substr(0, known.size() - leaf(known).size() - 1)));
      } else {
        refuse(key_origin, full, "no such key", right_key(full));
      }
    };
    for (const auto& entry : table) {
      const Origin place = origin_of(entry.first.source(), name);
      errors.attempt(place, [&] { read(prefix + std::string(entry.first.str()), place, entry.second); });
    }
  };
  try {
    walk(walk, io::parse_toml(toml, name), "");
    errors.finish();
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
  const auto clear = origins.find("errors.clear");
  const Origin clear_origin = clear == origins.end() ? Origin{} : clear->second;
  check_invariants(config, std::move(origins));
  if (config.errors.clear)
    refuse(clear_origin, "errors.clear", "there are no errors before the run",
           "an event \"set\" of this key is expected");
  check_events(config);
  return config;
}

ConfigBuilder& ConfigBuilder::event(TimedEvent event) {
  events_.push_back(std::move(event));
  return *this;
}

void check_live(std::string_view name, const Value& value, const Origin& origin) {
  const auto index = find(name);
  if (!index) refuse(origin, name, "no such key", right_key(name));
  const Key& key = keys()[*index];
  if (!key.live)
    refuse(origin, name, "cannot be changed during a run", "docs/configuration.md marks the keys that can");
  checked(key, value, origin);
}

KeyBits bits_of(std::string_view name, const Value& value) {
  const std::size_t index = find(name).value();
  const Key& key = keys()[index];
  const Value exact = checked(key, value, {});
  std::uint64_t bits = 0;
  if (const auto* flag = std::get_if<bool>(&exact))
    bits = *flag ? 1 : 0;
  else if (const auto* integer = std::get_if<std::int64_t>(&exact))
    bits = static_cast<std::uint64_t>(*integer);
  else if (const auto* number = std::get_if<double>(&exact))
    bits = std::bit_cast<std::uint64_t>(*number);
  else
    bits =
        static_cast<std::uint64_t>(std::ranges::find(key.choices, std::get<std::string>(exact)) - key.choices.begin());
  return {static_cast<std::uint32_t>(index), bits};
}

Config with_live(const Config& config, std::string_view name, const Value& value, const Origin& origin) {
  check_live(name, value, origin);
  return with_key(config, name, value, origin);
}

Config with_key(const Config& config, std::string_view name, const Value& value, const Origin& origin) {
  const auto index = find(name);
  if (!index) refuse(origin, name, "no such key", right_key(name));
  const Key& key = keys()[*index];
  Config changed = config;
  key.assign(changed, checked(key, value, origin));
  check_invariants(changed, {{std::string(name), origin}});
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

Config with_absolute_paths(const Config& config) {
  Config changed = config;
  for (const Key& key : keys()) {
    const Value value = key.read(config);
    if (is_path(key, value)) key.assign(changed, std::filesystem::absolute(std::get<std::string>(value)).string());
  }
  return changed;
}

}  // namespace cmrc
