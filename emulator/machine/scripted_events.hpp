#pragma once
// What can be made to happen to a machine at a given instant: failures, hot-plug, standstills. One row each in
// scripted_events.cpp; a new action is an enumerator and its row.
#include <cstdint>
#include <span>
#include <string_view>

#include "machine/time.hpp"

namespace machine {

struct Stage;  // what they act on: machine/script.hpp

/// Traces and snapshots have it by its number, so a new one stands last.
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
  unsigned number = 0;      ///< of what it acts on (ScriptTarget)
  std::int64_t amount = 0;  ///< see ScriptAmount
};

/// What an event's number counts. The machine has the first three, the plant the others.
enum class ScriptTarget : std::uint8_t { dsp, host, bus, joint, axis, load_cell, anemometer };
constexpr bool is_of_machine(ScriptTarget target) { return target <= ScriptTarget::bus; }

/// What an event's amount is.
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
  std::string_view undo{}, undo_meaning{};  ///< the same of amount 0, where that says that it works again
};
/// In the order in which texts list them.
std::span<const ScriptedAction> scripted_actions();
/// \throws std::invalid_argument for what is none
const ScriptedAction& row_of(Action action);

/// \throws std::invalid_argument for an event before `now`, with a number that nothing has, or an amount without sense
void require_sense(const ScriptedEvent& event, Time now, unsigned slots, unsigned buses);

}  // namespace machine
