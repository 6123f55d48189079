#pragma once
// What happens to the system at given instants of a run: failures, hot-plug, changes of parameters
// (docs/configuration.md, [[events]]).
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cmrc/configuration/value.hpp"
#include "machine/scripted_events.hpp"

namespace cmrc {

struct Config;

/// A gantry's trolley among the joints' names; in the plant it has the number of luff.
inline constexpr unsigned trolley_joint = 5, luff_joint = 2, slew_joint = 1;

/// One event, checked: its fields belong to its action and are in range.
struct TimedEvent {
  std::string action;
  double at_s = 0;
  unsigned number = 0;  ///< of the DSP, bus (0 A, 1 B), joint (trolley_joint besides the plant's) or sway axis
  double amount = 0;    ///< lasts_ms, or factor
  std::string key;      ///< of "set"
  Value value;
  Origin origin;
};

/// An action of the schema: its name, the field that says to what, the field that says how much.
struct TimedAction {
  std::string_view name;
  std::string_view target;  ///< "dsp", "bus", "joint", "axis", or "" for none
  std::string_view amount;  ///< "lasts_ms", "factor", or "" for none
  std::string_view meaning;
  const machine::ScriptedAction* scripted;  ///< what it is to the machine; null: the host does it
};
/// Those of machine/scripted_events.hpp, and "set".
std::span<const TimedAction> timed_actions();

/// The target of its action: "dsp", "bus", "joint", "axis" or "".
std::string_view target_of(const TimedEvent& event);
/// As the machine's script has it; none: the host does it.
std::optional<machine::ScriptedEvent> scripted_event(const TimedEvent& event);
/// It happens to DSPs, host or buses, not to the dock.
bool befalls_machine(const TimedEvent& event);

struct Field {
  Value value;
  Origin origin;
};
/// \param fields at_s, action and those of the action \param where the event begins
/// \throws ConfigError
TimedEvent timed_event(const std::map<std::string, Field>& fields, const Origin& where);

/// The event's fields as TOML, a line each.
std::string to_toml(const TimedEvent& event);
/// "fail dsp 2", "slow dsp 1 to 0.5", "stall_bus A for 0.2 ms", "set scheduling.p = 20000"
std::string describe(const TimedEvent& event);

/// Every event refers to a slot that is there and holds, or does not hold, a board as the action needs; every key that
/// is set may be changed while a run is on, to a value with which the configuration holds together. \throws ConfigError
void check_events(const Config& config);

}  // namespace cmrc
