#pragma once
// Text traces (docs/trace.md): writes the events of a window; finds the first difference of two traces.
#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/events/event_log.hpp"

namespace report {

/// Instants from <= t < to.
struct Window {
  Time from = Time::zero();
  Time to = Time::max();
  bool contains(Time time) const { return from <= time && time < to; }
};

inline constexpr std::string_view event_trace_header = "# cmrc event trace 1";
inline constexpr std::string_view instruction_trace_header = "# cmrc instruction trace 1";
inline constexpr std::string_view labelled_trace_header = "# cmrc labelled instruction trace 1";

/// Writes the events of a window, one line each.
class EventTextTrace final : public EventSink {
 public:
  /// Writes the header. `out` must outlive this.
  explicit EventTextTrace(std::ostream& out, Window window = {});
  void event(const Event& event) override;

 private:
  std::ostream& out_;
  Window window_;
};

/// A line of either kind of trace, split into its parts.
struct TraceLine {
  std::size_t number = 0;  ///< in its file, from 1
  std::string when;        ///< time in s or cycle, as written
  std::string who;         ///< "dsp 3"
  using Field = std::pair<std::string, std::string>;
  std::vector<Field> fields;  ///< name and value; a name may come again
  std::string text;

  /// \throws std::invalid_argument with the line's number if it is not a line of a trace.
  static TraceLine parse(std::string_view text, std::size_t number);
};

/// A line of a labelled instruction trace in the form that golden hashes use (docs/trace.md): only the mnemonics of the
/// instruction.
std::string without_operands(std::string_view line);

/// The first difference of two traces.
struct TraceDifference {
  std::optional<TraceLine> left, right;  ///< none: that trace has ended
  std::string field;                     ///< "time", "cycle", "component", "pc", "R0", "end", ...
  std::string left_value, right_value;   ///< "-" if the field is missing

  /// "cycle 1234, dsp 0, field R0: 0000000001 (line 17) and 0000000002 (line 17)", followed by both lines.
  std::string message() const;
};

/// First difference of two traces. Lines that start with # and empty lines do not count, but both traces must have the
/// same header. \throws std::invalid_argument if a text is not a trace.
std::optional<TraceDifference> compare_traces(std::istream& left, std::istream& right);

}  // namespace report
