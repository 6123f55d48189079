#pragma once
// Events at given instants of a run: failures, hot-plug, changes of parameters (docs/configuration.md, [[events]]).
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cmrc/configuration/rows/value.hpp"
#include "machine/system/scripted_events.hpp"

namespace cmrc {

struct Config;

/// A gantry's trolley has a name among the joints; in the plant it has luff's number.
inline constexpr unsigned trolley_joint = 5, luff_joint = 2, slew_joint = 1;

/// One checked event: its fields belong to its action and are in range.
struct TimedEvent {
  std::string action;
  double at_s = 0;
  unsigned number = 0;  ///< number of the DSP, bus (0 A, 1 B), joint (trolley_joint besides the plant's) or sway axis
  double amount = 0;    ///< lasts_ms, or factor
  std::string key;      ///< for "set"
  Value value;
  Origin origin;
};

/// An action of the schema: its name, the field for its object, the field for its amount.
struct TimedAction {
  std::string_view name;
  std::string_view target;  ///< "dsp", "bus", "joint", "axis", or "" for none
  std::string_view amount;  ///< "lasts_ms", "factor", or "" for none
  std::string_view meaning;
  const machine::ScriptedAction* scripted;  ///< the machine's action; null: the host does it
};
/// The actions of machine/system/scripted_events.hpp, and "set".
std::span<const TimedAction> timed_actions();

/// The target of its action: "dsp", "bus", "joint", "axis" or "".
std::string_view target_of(const TimedEvent& event);
/// The event for the machine's script; none: the host does it.
std::optional<machine::ScriptedEvent> scripted_event(const TimedEvent& event);
/// The event concerns DSPs, host or buses, not the dock.
bool concerns_machine(const TimedEvent& event);
/// The event ends what the other one has begun: a repair of the same object.
bool undoes(const TimedEvent& event, const TimedEvent& begun);

struct Field {
  Value value;
  Origin origin;
};
/// \param fields at_s, action and the action's fields \param where the event's place
/// \throws ConfigError
TimedEvent timed_event(const std::map<std::string, Field>& fields, const Origin& where);

/// The event's fields as TOML, one line each.
std::string to_toml(const TimedEvent& event);
/// "fail dsp 2", "slow dsp 1 to 0.5", "stall_bus A for 0.2 ms", "set scheduling.p = 20000"
std::string describe(const TimedEvent& event);

/// Checks that every event refers to an existing slot which holds, or does not hold, a board as the action needs; and
/// that every key that is set may be changed during a run, to a value with which all invariants hold. \throws
/// ConfigError
void check_events(const Config& config);

}  // namespace cmrc
