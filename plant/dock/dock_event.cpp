#include "plant/dock/dock_event.hpp"

#include <fmt/format.h>

#include "plant/parameters/config.hpp"
#include "state/enumerators.hpp"

namespace plant {
namespace {

enum class EventObject : std::uint8_t { none, joint, agv, container, attempt };

/// A value of an event: a quantity with its unit, the number of an AGV (-1: none), or why a drive tripped.
struct EventValue {
  enum class Kind : std::uint8_t { none, quantity, agv, trip } kind = Kind::none;
  const char* name = "";
  const char* unit = "";
};

constexpr EventValue quantity(const char* name, const char* unit) { return {EventValue::Kind::quantity, name, unit}; }

struct EventRow {
  EventKind kind;
  const char* name;
  EventObject object = EventObject::none;
  std::array<EventValue, 2> values{};
};

constexpr EventValue agv_value{EventValue::Kind::agv}, trip_value{EventValue::Kind::trip},
    heat_value = quantity("heat", "");
constexpr std::array<EventValue, 2> jump_values{quantity("clearance", " m"), quantity("energy jump", " J")};
constexpr std::array<EventValue, 2> contact_values{quantity("vertical speed", " m/s"),
                                                   quantity("horizontal speed", " m/s")};

constexpr EventRow event_rows[] = {
    {EventKind::near_contact, "near_contact", EventObject::none, jump_values},
    {EventKind::free_again, "free_again", EventObject::none, jump_values},
    {EventKind::touch, "touch", EventObject::none, contact_values},
    {EventKind::hard_landing, "hard_landing", EventObject::none, contact_values},
    {EventKind::landed, "landed"},
    {EventKind::lifted, "lifted"},
    {EventKind::locked, "locked", EventObject::container},
    {EventKind::opened, "opened", EventObject::container},
    {EventKind::refused, "refused"},
    {EventKind::set_on_agv, "set_on_agv", EventObject::container, {agv_value}},
    {EventKind::agv_dry, "agv_dry", EventObject::agv},
    {EventKind::agv_overflow, "agv_overflow", EventObject::agv},
    {EventKind::agv_arrived, "agv_arrived", EventObject::agv},
    {EventKind::delivered, "delivered", EventObject::container, {agv_value}},
    {EventKind::joint_limit, "joint_limit", EventObject::joint},
    {EventKind::drive_stopped, "drive_stopped", EventObject::joint},
    {EventKind::drive_resumed, "drive_resumed", EventObject::joint},
    {EventKind::drive_tripped, "drive_tripped", EventObject::joint, {trip_value, heat_value}},
    {EventKind::drive_warm, "drive_warm", EventObject::joint, {heat_value}},
    {EventKind::fault, "fault", EventObject::none, {quantity("alpha", " rad"), quantity("beta", " rad")}},
    {EventKind::joint_stuck, "joint_stuck", EventObject::joint},
    {EventKind::joint_slipped, "joint_slipped", EventObject::joint},
    {EventKind::collision, "collision", EventObject::agv, {quantity("closing speed", " m/s"), agv_value}},
    {EventKind::missed,
     "missed",
     EventObject::attempt,
     {quantity("lateral error", " m"), quantity("yaw error", " rad")}},
};

constexpr bool rows_are_complete() {
  for (std::size_t i = 0; i < std::size(event_rows); ++i)
    if (static_cast<std::size_t>(event_rows[i].kind) != i) return false;
  return std::size(event_rows) == state::enumerator_count<EventKind>();
}
static_assert(rows_are_complete(), "each kind of event has one row, in the order of EventKind");

constexpr std::array<const char*, trip_count> trip_names = {"too fast", "too long at its largest code", "too hot"};
static_assert(trip_count == state::enumerator_count<Trip>() && trip_names.back() != nullptr,
              "each cause of a trip has one name");

const EventRow& row(EventKind kind) { return event_rows[static_cast<std::size_t>(kind)]; }

std::string text_of(const EventValue& value, double number) {
  switch (value.kind) {
    case EventValue::Kind::quantity: return fmt::format("{} {:.4g}{}", value.name, number, value.unit);
    case EventValue::Kind::agv: return number < 0 ? "" : fmt::format("AGV {:.0f}", number);
    case EventValue::Kind::trip: return name(static_cast<Trip>(number));
    case EventValue::Kind::none: break;
  }
  return "";
}

}  // namespace

const char* name(EventKind kind) { return row(kind).name; }
const char* name(Trip cause) { return trip_names.at(static_cast<std::size_t>(cause)); }

std::string object_of(const Event& event, CraneKind crane) {
  if (event.index < 0) return "";
  switch (row(event.kind).object) {
    case EventObject::joint:
      return fmt::format("joint {}", joint_names(crane).at(static_cast<std::size_t>(event.index)).name);
    case EventObject::agv: return fmt::format("AGV {}", event.index);
    case EventObject::container: return fmt::format("container {}", event.index);
    case EventObject::attempt: return fmt::format("attempt {}", event.index);
    case EventObject::none: break;
  }
  return "";
}

std::string values_of(const Event& event) {
  std::string text;
  for (std::size_t i = 0; i < event.values.size(); ++i) {
    const std::string one = text_of(row(event.kind).values[i], event.values[i]);
    if (!text.empty() && !one.empty()) text += ", ";
    text += one;
  }
  return text;
}

}  // namespace plant
