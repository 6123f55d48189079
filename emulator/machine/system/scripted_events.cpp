#include "machine/system/scripted_events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "bus_model/bus.hpp"
#include "machine/bus_agents/host_board.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/dsps/dsp.hpp"
#include "machine/dsps/link_adapter.hpp"
#include "machine/system/script.hpp"
#include "plant/dock/dock.hpp"

namespace machine {
namespace {

using plant::Dock;
using Event = ScriptedEvent;

Dsp& dsp_of(const Stage& on, const Event& event) { return on.dsps.at(event.number); }

template <auto act>
void happens_to_dsp(const Stage& on, const Event& event, Time now) {
  (dsp_of(on, event).*act)(now);
}

void unplug(const Stage& on, const Event& event, Time now) {
  on.registers.clear_idle(event.number);
  dsp_of(on, event).unplug(now);
}
void plug(const Stage& on, const Event& event, Time now) {
  on.fence.mask |= Word{1} << event.number;
  dsp_of(on, event).plug(now);
}
void reset(const Stage& on, const Event& event, Time now) {
  on.registers.clear_idle(event.number);
  dsp_of(on, event).reset(now);
}
void set_pace(const Stage& on, const Event& event, Time now) { dsp_of(on, event).pace(now, event.amount); }
void break_link(const Stage& on, const Event& event, Time now) {
  on.adapter.set_broken(event.number, event.amount != 0, now);
}

void pause_host(const Stage& on, const Event& event, Time now) {
  if (on.host != nullptr) on.host->pause(now + Time{event.amount});
}
void stall_bus(const Stage& on, const Event& event, Time now) {
  const auto clocks = [&](Time at) { return on.bus_clocks[event.number].tick_at_or_after(at); };
  on.buses[event.number].stall(clocks(now), clocks(now + Time{event.amount}));
}

// A drive or sensor of the dock fails or works again; most have a number.
template <auto fail>
void of_dock(const Stage& on, const Event& event, Time now) {
  if (on.dock == nullptr) return;
  const bool failed = event.amount != 0;
  const Time at =
      std::max(now, on.dock->time());  // an access that was broken off may have taken it a bus clock further
  if constexpr (std::is_invocable_v<decltype(fail), Dock&, int, bool, Time>)
    (on.dock->*fail)(static_cast<int>(event.number), failed, at);
  else
    (on.dock->*fail)(failed, at);
}

using Target = ScriptTarget;
using Amount = ScriptAmount;

constexpr ScriptedAction actions[] = {
    {Action::fail, Target::dsp, Amount::none, happens_to_dsp<&Dsp::fail>, "fail",
     "the chip fails until its board is replaced (unplug, plug)"},
    {Action::hang, Target::dsp, Amount::none, happens_to_dsp<&Dsp::hang>, "hang",
     "its program loops forever with interrupts masked, until it is reset; during a reset: from the end of this reset "
     "until the next one"},
    {Action::freeze, Target::dsp, Amount::none, happens_to_dsp<&Dsp::freeze>, "freeze",
     "the chip is halted until it is reset"},
    {Action::unplug, Target::dsp, Amount::none, unplug, "unplug",
     "the board is pulled out: transactions break off, posted words are lost"},
    {Action::plug, Target::dsp, Amount::none, plug, "plug",
     "a board is put in, is reset, booted by the host and starts working"},
    {Action::reset, Target::dsp, Amount::none, reset, "reset", "reset, and booted again by the host"},
    {Action::pace, Target::dsp, Amount::factor, set_pace, "slow",
     "its clock runs at this factor of its frequency; 1 is full speed again"},
    {Action::link, Target::dsp, Amount::failed, break_link, "break_link",
     "the wires between it and the link adapter break: it cannot be booted any more, and a word under way is lost",
     "repair_link", "the wires are repaired"},
    {Action::pause_host, Target::host, Amount::duration, pause_host, "pause_host",
     "the host's processor does nothing for this time"},
    {Action::stall_bus, Target::bus, Amount::duration, stall_bus, "stall_bus",
     "the bus's arbiter grants nothing for this time"},
    {Action::drive, Target::joint, Amount::failed, of_dock<&Dock::fail_drive>, "fail_drive",
     "the drive has no torque and its brake closes", "repair_drive", "the drive works again"},
    {Action::encoder, Target::joint, Amount::failed, of_dock<&Dock::fail_encoder>, "stick_encoder",
     "the encoder keeps showing the count of this instant", "repair_encoder", "the encoder works again"},
    {Action::sway, Target::axis, Amount::failed, of_dock<&Dock::fail_sway>, "stick_sway",
     "the sway sensor keeps showing the angle of this instant", "repair_sway", "the sway sensor works again"},
    {Action::second_sway, Target::axis, Amount::failed, of_dock<&Dock::fail_second_sway>, "stick_second_sway",
     "the second sway sensor keeps showing the angle of this instant", "repair_second_sway",
     "the second sway sensor works again"},
    {Action::drive_status, Target::joint, Amount::failed, of_dock<&Dock::fail_drive_status>, "stick_drive_status",
     "the drive's status stays as it is at this instant", "repair_drive_status", "the drive's status is right again"},
    {Action::drive_speed, Target::joint, Amount::failed, of_dock<&Dock::fail_drive_speed>, "stick_drive_speed",
     "the drive's estimate of its speed stays what it is at this instant", "repair_drive_speed",
     "the drive's estimate of its speed works again"},
    {Action::load_cell, Target::load_cell, Amount::failed, of_dock<&Dock::fail_load_cell>, "stick_load_cell",
     "the load cell keeps showing the load of this instant", "repair_load_cell", "the load cell works again"},
    {Action::anemometer, Target::anemometer, Amount::failed, of_dock<&Dock::fail_anemometer>, "stick_anemometer",
     "the anemometer keeps showing the wind of this instant", "repair_anemometer", "the anemometer works again"},
};

// Every action has one row; the second name is given only if the action can be undone.
constexpr bool complete() {
  std::array<bool, action_count> has{};
  for (const ScriptedAction& row : actions) {
    bool& seen = has[static_cast<std::size_t>(row.action)];
    if (seen || row.undo.empty() == (row.amount == Amount::failed)) return false;
    seen = true;
  }
  return std::ranges::all_of(has, [](bool one) { return one; });
}
static_assert(complete());

struct Numbered {
  std::string_view what;
  unsigned count;
};

Numbered numbered(ScriptTarget target, unsigned slots, unsigned buses) {
  switch (target) {
    case Target::dsp: return {"slot", slots};
    case Target::host: return {"host", 1};
    case Target::bus: return {"bus", buses};
    case Target::joint: return {"joint", plant::joint_count};
    case Target::axis: return {"axis", 2};
    case Target::load_cell: return {"load cell", 1};
    case Target::anemometer: return {"anemometer", 1};
  }
  return {};
}

}  // namespace

std::span<const ScriptedAction> scripted_actions() { return actions; }

const ScriptedAction& row_of(Action action) {
  const auto found = std::ranges::find(actions, action, &ScriptedAction::action);
  if (found == std::end(actions))
    throw std::invalid_argument{fmt::format("machine: there is no action {}", static_cast<int>(action))};
  return *found;
}

void require_sense(const ScriptedEvent& event, Time now, unsigned slots, unsigned buses) {
  const ScriptedAction& row = row_of(event.action);
  const auto [what, count] = numbered(row.target, slots, buses);
  if (event.number >= count || event.time < now)
    throw std::invalid_argument{
        fmt::format("machine: a scripted event at {} ps for {} {}; the time is {} ps, and the last {} is {}",
                    event.time.count(), what, event.number, now.count(), what, count - 1)};
  if (event.amount < 0 || (row.amount == Amount::factor && event.amount == 0))
    throw std::invalid_argument{
        fmt::format("machine: a scripted event with amount {}; it is not negative, and a clock runs", event.amount)};
}

}  // namespace machine
