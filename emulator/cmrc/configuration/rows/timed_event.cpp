#include "cmrc/configuration/rows/timed_event.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/configuration/machine/machine_topology.hpp"
#include "report/events/event.hpp"

namespace cmrc {
namespace {

using machine::ScriptAmount;
using machine::ScriptTarget;

/// A field for an event's amount: its range, and its unit in units of the machine.
struct AmountField {
  std::string_view name;
  double least, most;
  double unit;
};
constexpr AmountField factor{"factor", 0.001, 1, 1e6}, lasts_ms{"lasts_ms", 1e-6, 1e6, 1e9};

const AmountField* amount_field(ScriptAmount amount) {
  switch (amount) {
    case ScriptAmount::factor: return &factor;
    case ScriptAmount::duration: return &lasts_ms;
    case ScriptAmount::none:
    case ScriptAmount::failed: break;
  }
  return nullptr;
}

std::string_view target_field(ScriptTarget target) {
  switch (target) {
    case ScriptTarget::dsp: return "dsp";
    case ScriptTarget::bus: return "bus";
    case ScriptTarget::joint: return "joint";
    case ScriptTarget::axis: return "axis";
    case ScriptTarget::host:
    case ScriptTarget::load_cell:
    case ScriptTarget::anemometer: break;
  }
  return "";
}

std::vector<std::string> names_of(std::string_view target) {
  if (target == "bus") return {"A", "B", "C", "D"};
  if (target == "joint") return {"travel", "slew", "luff", "hoist", "rotate", "trolley"};
  if (target == "axis") return {"alpha", "beta"};
  return {};
}

const TimedAction& action_named(const std::string& name, const Origin& origin) {
  std::vector<std::string> names;
  for (const TimedAction& known : timed_actions()) {
    if (known.name == name) return known;
    names.emplace_back(known.name);
  }
  refuse(origin, "events.action", fmt::format("\"{}\" is not known", name), one_expected(name, names));
}

/// Takes the fields of one event one by one; a field that is left over is unknown.
class EventFields {
 public:
  EventFields(const std::map<std::string, Field>& fields, const Origin& where) : fields_(fields), where_(where) {}

  /// To be called before a field is reported as missing: a misspelt field is then reported as it is written.
  void all_known() const {
    static constexpr std::array<std::string_view, 10> known = {"at_s", "action", "dsp",      "bus", "joint",
                                                               "axis", "factor", "lasts_ms", "key", "value"};
    for (const auto& [name, field] : fields_)
      if (std::find(known.begin(), known.end(), name) == known.end())
        refuse(field.origin, "events." + name, "no such field", one_expected(name, {known.begin(), known.end()}));
  }
  const Field& take(std::string_view name, std::string_view right) {
    const auto found = fields_.find(std::string(name));
    if (found == fields_.end()) refuse(where_, fmt::format("events.{}", name), "is missing", right);
    taken_.push_back(found->first);
    return found->second;
  }
  double number(std::string_view name, double least, double most) {
    const std::string right = fmt::format("a number from {} to {} is expected", least, most);
    const Field& field = take(name, right);
    double value = 0;
    if (const auto* real = std::get_if<double>(&field.value))
      value = *real;
    else if (const auto* integer = std::get_if<std::int64_t>(&field.value))
      value = static_cast<double>(*integer);
    else
      refuse(field.origin, fmt::format("events.{}", name),
             fmt::format("{} is {}", show(field.value), noun(field.value)), right);
    if (!(value >= least && value <= most)) {
      refuse(field.origin, fmt::format("events.{}", name), fmt::format("{} is out of range", show(field.value)), right);
    }
    return value;
  }
  std::string text(std::string_view name, std::string_view right) {
    const Field& field = take(name, right);
    if (const auto* word = std::get_if<std::string>(&field.value)) return *word;
    refuse(field.origin, fmt::format("events.{}", name), fmt::format("{} is {}", show(field.value), noun(field.value)),
           right);
  }
  unsigned target(std::string_view name) {
    if (name == "dsp") {
      const Field& field = take(name, "a DSP's number is expected");
      const auto* number = std::get_if<std::int64_t>(&field.value);
      if (number == nullptr || *number < 0 || *number > 15) {
        refuse(field.origin, "events.dsp", fmt::format("{} is not a DSP", show(field.value)),
               "an integer from 0 to 15 is expected");
      }
      return static_cast<unsigned>(*number);
    }
    const auto names = names_of(name);
    const std::string word = text(name, quoted_list(names) + " is expected");
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      refuse(fields_.at(std::string(name)).origin, fmt::format("events.{}", name),
             fmt::format("\"{}\" is not known", word), one_expected(word, names));
    }
    return static_cast<unsigned>(found - names.begin());
  }
  void nothing_left(const TimedAction& action) const {
    for (const auto& [name, field] : fields_) {
      if (std::find(taken_.begin(), taken_.end(), name) != taken_.end()) continue;
      refuse(field.origin, "events." + name, fmt::format("\"{}\" has no such field", action.name),
             fmt::format("its fields are {}", quoted_list(taken_)));
    }
  }

 private:
  const std::map<std::string, Field>& fields_;
  const Origin& where_;
  std::vector<std::string> taken_;
};

const TimedAction& action_of(const TimedEvent& event) { return action_named(event.action, event.origin); }

/// The slots that hold a board, updated event by event.
class Slots {
 public:
  explicit Slots(const Config& config) : config_(config) {
    for (std::size_t slot = 0; slot < static_cast<std::size_t>(config.machine.dsps); ++slot) plugged_.at(slot) = true;
  }
  void follow(const TimedEvent& event) {
    if (action_of(event).target != "dsp") return;
    const auto slots = std::max(config_.machine.dsps, config_.machine.slots);
    if (event.number >= slots) {
      refuse(event.origin, "events.dsp", fmt::format("there is no slot {}", event.number),
             fmt::format("the slots are 0 to {}; machine.slots makes more", slots - 1));
    }
    if (event.action == "break_link" || event.action == "repair_link") return;  // for the slot, with or without a board
    bool& plugged = plugged_.at(event.number);
    const bool wanted = event.action != "plug";
    if (plugged != wanted) {
      refuse(event.origin, "events.action",
             fmt::format("{} at {} s, but slot {} {}", event.action, event.at_s, event.number,
                         plugged ? "holds a board" : "is empty"),
             plugged ? "unplug it first" : "plug a board in first");
    }
    if (event.action == "unplug" || event.action == "plug") plugged = !plugged;
  }

 private:
  const Config& config_;
  std::array<bool, 16> plugged_{};
};

void check_joint(const Config& config, const TimedEvent& event) {
  if (action_of(event).target != "joint") return;
  const bool gantry = config.dock.crane == CraneMachine::gantry;
  const bool has = gantry ? event.number != slew_joint && event.number != luff_joint : event.number != trolley_joint;
  if (has) return;
  refuse(event.origin, "events.joint",
         fmt::format("a {} has no {}", gantry ? "gantry" : "slewing crane", names_of("joint")[event.number]),
         gantry ? "\"travel\", \"trolley\", \"hoist\", \"rotate\" is expected (dock.crane)"
                : "\"travel\", \"slew\", \"luff\", \"hoist\", \"rotate\" is expected (dock.crane)");
}

void check_sensor(const Config& config, const TimedEvent& event) {
  if (!event.action.ends_with("_second_sway") || config.dock.sway_sensors == 2) return;
  refuse(event.origin, "events.action", fmt::format("{}, but the crane has one sway sensor", event.action),
         "dock.sway_sensors = 2 is expected");
}

}  // namespace

std::string_view target_of(const TimedEvent& event) { return action_of(event).target; }

std::span<const TimedAction> timed_actions() {
  static const std::vector<TimedAction> all = [] {
    std::vector<TimedAction> rows;
    for (const machine::ScriptedAction& one : machine::scripted_actions()) {
      const AmountField* amount = amount_field(one.amount);
      const std::string_view much = amount != nullptr ? amount->name : "";
      const TimedAction row{one.name, target_field(one.target), much, one.meaning, &one};
      rows.push_back(row);
      if (!one.undo.empty()) rows.push_back({one.undo, row.target, row.amount, one.undo_meaning, &one});
    }
    rows.push_back({"set", "", "",
                    "the operator sets `key` to `value`; the keys marked \"live\" may change during a run", nullptr});
    return rows;
  }();
  return all;
}

std::optional<machine::ScriptedEvent> scripted_event(const TimedEvent& event) {
  const TimedAction& action = action_of(event);
  if (action.scripted == nullptr) return std::nullopt;
  std::int64_t amount = 0;
  if (const AmountField* field = amount_field(action.scripted->amount))
    amount = std::llround(event.amount * field->unit);
  else if (action.scripted->amount == ScriptAmount::failed)
    amount = action.name == action.scripted->name ? 1 : 0;
  const unsigned number = action.target == "joint" && event.number == trolley_joint ? luff_joint : event.number;
  const machine::Time at = report::from_seconds(event.at_s);
  return machine::ScriptedEvent{at, action.scripted->action, number, amount};
}

bool concerns_machine(const TimedEvent& event) {
  const machine::ScriptedAction* scripted = action_of(event).scripted;
  return scripted != nullptr && machine::is_of_machine(scripted->target);
}

bool undoes(const TimedEvent& event, const TimedEvent& begun) {
  const machine::ScriptedAction* scripted = action_of(event).scripted;
  return scripted != nullptr && scripted == action_of(begun).scripted && event.number == begun.number &&
         event.action == scripted->undo && begun.action == scripted->name;
}

TimedEvent timed_event(const std::map<std::string, Field>& given, const Origin& where) {
  EventFields fields(given, where);
  fields.all_known();
  TimedEvent event;
  event.origin = where;
  event.at_s = fields.number("at_s", 0, 86400);
  event.action = fields.text("action", "the name of an action is expected");
  const TimedAction& action = action_named(event.action, given.at("action").origin);
  if (!action.target.empty()) event.number = fields.target(action.target);
  if (action.scripted != nullptr) {
    if (const AmountField* field = amount_field(action.scripted->amount))
      event.amount = fields.number(field->name, field->least, field->most);
  }
  if (event.action == "set") {
    event.key = fields.text("key", "a dotted key is expected");
    event.value = fields.take("value", "a value for the key is expected").value;
    check_live(event.key, event.value, given.at("key").origin);
  }
  fields.nothing_left(action);
  return event;
}

std::string to_toml(const TimedEvent& event) {
  const TimedAction& action = action_of(event);
  std::string text = fmt::format("at_s = {}\naction = \"{}\"\n", show(Value{event.at_s}), event.action);
  if (action.target == "dsp")
    text += fmt::format("dsp = {}\n", event.number);
  else if (!action.target.empty())
    text += fmt::format("{} = \"{}\"\n", action.target, names_of(action.target).at(event.number));
  if (!action.amount.empty()) text += fmt::format("{} = {}\n", action.amount, show(Value{event.amount}));
  if (event.action == "set") text += fmt::format("key = \"{}\"\nvalue = {}\n", event.key, show(event.value));
  return text;
}

std::string describe(const TimedEvent& event) {
  const TimedAction& action = action_of(event);
  std::string text = event.action;
  if (action.target == "dsp")
    text += fmt::format(" DSP {}", event.number);
  else if (!action.target.empty())
    text += " " + names_of(action.target).at(event.number);
  if (action.amount == factor.name) text += fmt::format(" to {}", event.amount);
  if (action.amount == lasts_ms.name) text += fmt::format(" for {} ms", event.amount);
  if (event.action == "set") text += fmt::format(" {} = {}", event.key, show(event.value));
  return text;
}

void check_events(const Config& config) {
  std::vector<const TimedEvent*> order;
  for (const TimedEvent& event : config.events) order.push_back(&event);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->at_s < b->at_s; });
  const std::vector<std::string> buses = topology_of(config).buses;
  Slots slots(config);
  Config changed = config;
  for (const TimedEvent* event : order) {
    slots.follow(*event);
    check_joint(config, *event);
    check_sensor(config, *event);
    if (action_of(*event).target == "bus" && event->number >= buses.size())
      refuse(event->origin, "events.bus", fmt::format("there is no bus {}", names_of("bus")[event->number]),
             quoted_list(buses) + " is expected (bus.topology)");
    if (event->action == "set") changed = with_live(changed, event->key, event->value, event->origin);
  }
}

}  // namespace cmrc
