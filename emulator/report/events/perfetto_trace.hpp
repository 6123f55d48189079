#pragma once
// Writes a trace for Perfetto (ui.perfetto.dev): tracks of slices, instants and counters, packet by packet in the order
// of the calls. Does not know runs. Format: protos/perfetto/trace/trace_packet.proto of github.com/google/perfetto.
//
// Perfetto counts whole nanoseconds. Times are rounded down; if this loses something, a note of the event (begin_ps,
// end_ps, at_ps) has the picoseconds. Each track is a sequence of packets, with its own table of names and its own
// clock; each packet gives the time since the one before.
#include <cstdint>
#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "report/events/event.hpp"

namespace report {

class PerfettoTrace {
 public:
  using Track = std::uint32_t;  ///< its uuid; 0: none
  using Flow = std::uint64_t;   ///< not 0

  /// A note at an event; notes are shown in the order of the list.
  struct Note {
    std::string_view name;
    std::variant<std::int64_t, std::string_view> value;
  };
  using Notes = std::span<const Note>;

  /// `out` must outlive this.
  explicit PerfettoTrace(std::ostream& out);

  /// A track that contains other tracks, in the order in which they are added, and shows nothing itself.
  Track add_group(std::string_view name, Track parent = 0, std::string_view description = {});
  /// A track of slices and instants.
  Track add_slices(std::string_view name, Track parent = 0, std::string_view description = {});
  Track add_counter(std::string_view name, std::string_view unit, Track parent = 0, std::string_view description = {});

  /// Opens a slice inside the open slices of this track. \throws std::logic_error for a time before the last begin or
  /// end of the track
  void begin(Track track, Time at, std::string_view name, Notes notes = {});
  /// Closes the slice opened last. \throws std::logic_error if no slice is open, and as begin()
  void end(Track track, Time at, Notes notes = {});
  /// May have any time, also one before the last event. \param from, to flows that begin here, and flows that end here
  void instant(Track track, Time at, std::string_view name, Notes notes = {}, std::span<const Flow> from = {},
               std::span<const Flow> to = {});
  /// A counter's value from `at` on; times as in begin().
  void count(Track track, Time at, std::int64_t value);
  void count(Track track, Time at, double value);

  /// Number of open slices of a track.
  std::size_t depth(Track track) const { return tracks_.at(track).open; }

 private:
  struct State {
    bool begun = false;
    std::int64_t last_ns = 0;
    std::size_t open = 0;
    std::map<std::string, std::uint64_t, std::less<>> names, note_names;
  };
  struct Event;

  Track add(std::string_view name, Track parent, std::string_view description, const std::string* unit);
  State& introduce(Track track);
  void write(Track track, const Event& event);
  void put(const std::string& packet);

  std::ostream& out_;
  std::vector<State> tracks_{1};  // by uuid
  std::vector<std::uint32_t> children_{0};
  std::string packet_, header_;
};

}  // namespace report
