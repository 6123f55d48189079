#include "report/events/perfetto_trace.hpp"

#include <fmt/format.h>

#include <ostream>
#include <protozero/pbf_writer.hpp>
#include <stdexcept>

namespace report {
namespace {

using protozero::pbf_writer;

// Field numbers, by message.
namespace trace {
constexpr unsigned packet = 1;
}
namespace packet {
constexpr unsigned clock_snapshot = 6, timestamp = 8, sequence = 10, track_event = 11, interned_data = 12,
                   sequence_flags = 13, timestamp_clock = 58, defaults = 59, track_descriptor = 60;
// Bits of the flags. A third flag says that a packet needs its sequence's state. It is left out: two bytes of each
// packet, useful only for incomplete traces.
constexpr unsigned state_cleared = 1;
}  // namespace packet
namespace defaults {
constexpr unsigned track_event = 11, timestamp_clock = 58, track = 11;  // track: of TrackEventDefaults
}
namespace snapshot {
constexpr unsigned clocks = 1, id = 1, timestamp = 2, is_incremental = 3;
}
namespace descriptor {
constexpr unsigned uuid = 1, name = 2, parent = 5, counter = 8, child_ordering = 11, rank = 12, description = 14;
constexpr unsigned by_rank = 3;    // child_ordering
constexpr unsigned unit_name = 6;  // of CounterDescriptor
}  // namespace descriptor
namespace track_event {
constexpr unsigned note = 4, type = 9, name = 10, counter = 30, double_counter = 44, flow = 47, last_of_flow = 48;
}
namespace note {
constexpr unsigned name = 1, integer = 4, text = 6;
}
namespace interned {
constexpr unsigned event_name = 2, note_name = 3, id = 1, text = 2;
}

constexpr unsigned boot_time = 6;     // the clock of the whole trace
constexpr unsigned track_clock = 64;  // the clock of one sequence

enum class Type : unsigned { begin = 1, end = 2, instant = 3, counter = 4 };

/// Rounds down, also before 0.
std::int64_t nanoseconds(Time at) { return std::chrono::floor<std::chrono::nanoseconds>(at).count(); }

}  // namespace

struct PerfettoTrace::Event {
  Type type{};
  Time at{};
  std::string_view name{};
  Notes notes{};
  std::string_view exact{};  ///< the name of the note with the picoseconds
  std::span<const Flow> from{}, to{};
  std::variant<std::monostate, std::int64_t, double> value{};
  bool in_order = true;
};

PerfettoTrace::PerfettoTrace(std::ostream& out) : out_(out) {}

void PerfettoTrace::put(const std::string& packet) {
  header_.clear();
  pbf_writer(header_).add_bytes(trace::packet, packet);
  out_.write(header_.data(), static_cast<std::streamsize>(header_.size()));
}

PerfettoTrace::Track PerfettoTrace::add(std::string_view name, Track parent, std::string_view description,
                                        const std::string* unit) {
  const auto track = static_cast<Track>(tracks_.size());
  tracks_.emplace_back();
  children_.push_back(0);
  packet_.clear();
  pbf_writer packet(packet_);
  packet.add_uint32(packet::sequence, 1);
  {
    pbf_writer body(packet, packet::track_descriptor);
    body.add_uint64(descriptor::uuid, track);
    body.add_string(descriptor::name, name.data(), name.size());
    if (parent != 0) body.add_uint64(descriptor::parent, parent);
    body.add_enum(descriptor::child_ordering, descriptor::by_rank);
    body.add_int32(descriptor::rank, static_cast<std::int32_t>(++children_.at(parent)));
    if (!description.empty()) body.add_string(descriptor::description, description.data(), description.size());
    if (unit != nullptr) pbf_writer(body, descriptor::counter).add_string(descriptor::unit_name, *unit);
  }
  put(packet_);
  return track;
}

PerfettoTrace::Track PerfettoTrace::add_group(std::string_view name, Track parent, std::string_view description) {
  return add(name, parent, description, nullptr);
}

PerfettoTrace::Track PerfettoTrace::add_slices(std::string_view name, Track parent, std::string_view description) {
  return add(name, parent, description, nullptr);
}

PerfettoTrace::Track PerfettoTrace::add_counter(std::string_view name, std::string_view unit, Track parent,
                                                std::string_view description) {
  const std::string of{unit};
  return add(name, parent, description, &of);
}

// The first packet of a track: its clock, and that its packets belong to this track and use that clock.
PerfettoTrace::State& PerfettoTrace::introduce(Track track) {
  State& state = tracks_.at(track);
  if (track == 0) throw std::logic_error("PerfettoTrace: no track");
  if (state.begun) return state;
  state.begun = true;
  packet_.clear();
  pbf_writer packet(packet_);
  packet.add_uint32(packet::sequence, track + 1);
  packet.add_uint32(packet::sequence_flags, packet::state_cleared);
  packet.add_uint64(packet::timestamp, 0);
  packet.add_uint32(packet::timestamp_clock, boot_time);
  {
    pbf_writer body(packet, packet::defaults);
    body.add_uint32(defaults::timestamp_clock, track_clock);
    pbf_writer(body, defaults::track_event).add_uint64(defaults::track, track);
  }
  {
    pbf_writer body(packet, packet::clock_snapshot);
    for (const unsigned id : {boot_time, track_clock}) {
      pbf_writer clock(body, snapshot::clocks);
      clock.add_uint32(snapshot::id, id);
      clock.add_uint64(snapshot::timestamp, 0);
      if (id == track_clock) clock.add_bool(snapshot::is_incremental, true);
    }
  }
  put(packet_);
  return state;
}

void PerfettoTrace::write(Track track, const Event& event) {
  State& state = introduce(track);
  const std::int64_t ns = nanoseconds(event.at);
  if (event.in_order && ns < state.last_ns)
    throw std::logic_error(fmt::format("PerfettoTrace: {} ns comes after {} ns", ns, state.last_ns));
  packet_.clear();
  pbf_writer packet(packet_);
  packet.add_uint64(packet::timestamp, static_cast<std::uint64_t>(event.in_order ? ns - state.last_ns : ns));
  if (!event.in_order) packet.add_uint32(packet::timestamp_clock, boot_time);
  packet.add_uint32(packet::sequence, track + 1);
  if (event.in_order) state.last_ns = ns;

  std::string new_names;
  pbf_writer interned_data(new_names);
  const auto id_of = [&](auto& table, std::string_view text, unsigned field) {
    if (const auto found = table.find(text); found != table.end()) return found->second;
    const std::uint64_t id = table.size() + 1;
    table.emplace(text, id);
    pbf_writer row(interned_data, field);
    row.add_uint64(interned::id, id);
    row.add_string(interned::text, text.data(), text.size());
    return id;
  };
  {
    pbf_writer body(packet, packet::track_event);
    body.add_enum(track_event::type, static_cast<std::int32_t>(event.type));
    if (!event.name.empty()) body.add_uint64(track_event::name, id_of(state.names, event.name, interned::event_name));
    const auto note = [&](std::string_view name, const auto& value) {
      pbf_writer row(body, track_event::note);
      row.add_uint64(note::name, id_of(state.note_names, name, interned::note_name));
      if (const auto* number = std::get_if<std::int64_t>(&value))
        row.add_int64(note::integer, *number);
      else
        row.add_string(note::text, std::get<std::string_view>(value).data(), std::get<std::string_view>(value).size());
    };
    for (const Note& one : event.notes) note(one.name, one.value);
    if (!event.exact.empty() && event.at.count() % 1000 != 0)
      note(event.exact, decltype(Note::value)(event.at.count()));
    if (const auto* whole = std::get_if<std::int64_t>(&event.value)) body.add_int64(track_event::counter, *whole);
    if (const auto* real = std::get_if<double>(&event.value)) body.add_double(track_event::double_counter, *real);
    for (const Flow flow : event.from) body.add_fixed64(track_event::flow, flow);
    for (const Flow flow : event.to) body.add_fixed64(track_event::last_of_flow, flow);
  }
  if (!new_names.empty()) packet.add_message(packet::interned_data, new_names);
  put(packet_);
}

void PerfettoTrace::begin(Track track, Time at, std::string_view name, Notes notes) {
  write(track, {.type = Type::begin, .at = at, .name = name, .notes = notes, .exact = "begin_ps"});
  ++tracks_[track].open;
}

void PerfettoTrace::end(Track track, Time at, Notes notes) {
  if (tracks_.at(track).open == 0) throw std::logic_error("PerfettoTrace: an end without a begin");
  write(track, {.type = Type::end, .at = at, .notes = notes, .exact = "end_ps"});
  --tracks_[track].open;
}

void PerfettoTrace::instant(Track track, Time at, std::string_view name, Notes notes, std::span<const Flow> from,
                            std::span<const Flow> to) {
  write(track, {.type = Type::instant,
                .at = at,
                .name = name,
                .notes = notes,
                .exact = "at_ps",
                .from = from,
                .to = to,
                .in_order = false});
}

void PerfettoTrace::count(Track track, Time at, std::int64_t value) {
  write(track, {.type = Type::counter, .at = at, .value = value});
}

void PerfettoTrace::count(Track track, Time at, double value) {
  write(track, {.type = Type::counter, .at = at, .value = value});
}

}  // namespace report
