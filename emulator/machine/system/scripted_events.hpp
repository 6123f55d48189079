#pragma once
// Events that can be scripted for a machine at a given instant: failures, hot-plug, pauses. One row each in
// scripted_events.cpp; a new action is an enumerator and its row.
#include <cstdint>
#include <span>
#include <string_view>

#include "machine/time/time.hpp"

namespace machine {

struct Stage;  // the objects of events: machine/system/script.hpp

/// Traces and snapshots use the number, so a new action comes last.
enum class Action : std::uint8_t {
  fail,
  freeze,
  hang,
  unplug,
  plug,
  reset,
  link,
  pace,
  pause_host,
  stall_bus,
  drive,
  encoder,
  sway,
  second_sway,
  drive_status,
  drive_speed,
  load_cell,
  anemometer,
};
inline constexpr std::size_t action_count = static_cast<std::size_t>(Action::anemometer) + 1;

struct ScriptedEvent {
  Time time{};
  Action action{};
  unsigned number = 0;      ///< number of its object (ScriptTarget)
  std::int64_t amount = 0;  ///< see ScriptAmount
};

/// What an event's number counts. The first three belong to the machine, the others to the plant.
enum class ScriptTarget : std::uint8_t { dsp, host, bus, joint, axis, load_cell, anemometer };
constexpr bool is_of_machine(ScriptTarget target) { return target <= ScriptTarget::bus; }

/// The meaning of an event's amount.
enum class ScriptAmount : std::uint8_t {
  none,
  factor,    ///< millionths, not 0
  duration,  ///< picoseconds
  failed,    ///< 1: it fails; 0: it works again
};

struct ScriptedAction {
  Action action;
  ScriptTarget target;
  ScriptAmount amount;
  void (*act)(const Stage&, const ScriptedEvent&, Time now);
  std::string_view name, meaning;
  std::string_view undo{}, undo_meaning{};  ///< the name for amount 0, if that repairs the failure
};
/// In the order of lists in texts.
std::span<const ScriptedAction> scripted_actions();
/// \throws std::invalid_argument for an unknown action
const ScriptedAction& row_of(Action action);

/// \throws std::invalid_argument for an event before `now`, with an unknown number, or with an amount without sense
void require_sense(const ScriptedEvent& event, Time now, unsigned slots, unsigned buses);

}  // namespace machine
