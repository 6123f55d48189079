#include "report/events/trace_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <istream>
#include <ostream>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace report {
namespace {

[[noreturn]] void reject(std::size_t number, std::string_view why) {
  throw std::invalid_argument(fmt::format("line {}: not a line of a trace: {}", number, why));
}

std::string_view take_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

/// Reads "name=value name=value"; words without = form one field `title` (an event's kind).
void take_pairs(std::string_view rest, const char* title, TraceLine& line) {
  std::string kind;
  while (!trimmed(rest).empty()) {
    const std::string_view word = take_word(rest);
    const std::size_t equals = word.find('=');
    if (equals == std::string_view::npos)
      kind += (kind.empty() ? "" : " ") + std::string(word);
    else
      line.fields.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  }
  if (!kind.empty()) line.fields.emplace(line.fields.begin(), title, kind);
}

/// Reads the lines of a trace that count.
class Reader {
 public:
  explicit Reader(std::istream& in) : in_(in) {}

  std::optional<TraceLine> next() {
    std::string text;
    while (line(text)) {
      ++number_;
      if (!text.empty() && text.back() == '\r') text.pop_back();
      if (number_ == 1) {
        if (!text.starts_with("# cmrc ")) reject(1, "it should start with a header such as `# cmrc event trace 1`");
        header_ = text;
      }
      if (text.empty() || text.front() == '#') continue;
      return TraceLine::parse(text, number_);
    }
    if (number_ == 0) reject(1, "the file is empty");
    return std::nullopt;
  }
  const std::string& header() const { return header_; }

 private:
  // Has a limit of length: a file that is not text may have no line end.
  bool line(std::string& text) {
    in_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    if (in_.fail() && in_.gcount() > 0)
      reject(number_ + 1, fmt::format("a line longer than {} characters", buffer_.size() - 1));
    text = buffer_.data();
    return !in_.fail();
  }

  std::istream& in_;
  std::vector<char> buffer_ = std::vector<char>(1u << 16);
  std::string header_;
  std::size_t number_ = 0;
};

/// The value of the nth field with this name.
const std::string* find_field(const TraceLine& line, std::string_view name, std::size_t nth) {
  for (const auto& [each, value] : line.fields)
    if (each == name && nth-- == 0) return &value;
  return nullptr;
}

/// How many fields before the one at `place` have its name.
std::size_t namesakes(const TraceLine& line, std::size_t place) {
  const auto fields = std::span{line.fields};
  return static_cast<std::size_t>(
      std::ranges::count(fields.first(place), fields[place].first, &TraceLine::Field::first));
}

TraceDifference differing(TraceLine left, TraceLine right, std::string field, std::string left_value,
                          std::string right_value) {
  return {std::move(left), std::move(right), std::move(field), std::move(left_value), std::move(right_value)};
}

std::optional<TraceDifference> compare_lines(const TraceLine& left, const TraceLine& right) {
  if (left.text == right.text) return std::nullopt;
  if (left.when != right.when)
    return differing(left, right, left.when.find('.') == std::string::npos ? "cycle" : "time", left.when, right.when);
  if (left.who != right.who) return differing(left, right, "component", left.who, right.who);
  for (std::size_t place = 0; place < left.fields.size(); ++place) {
    const auto& [name, value] = left.fields[place];
    const std::string* other = find_field(right, name, namesakes(left, place));
    if (!other) return differing(left, right, name, value, "-");
    if (*other != value) return differing(left, right, name, value, *other);
  }
  for (std::size_t place = 0; place < right.fields.size(); ++place) {
    const auto& [name, value] = right.fields[place];
    if (!find_field(left, name, namesakes(right, place))) return differing(left, right, name, "-", value);
  }
  return std::nullopt;  // the lines differ only in blanks
}

}  // namespace

EventTextTrace::EventTextTrace(std::ostream& out, Window window) : out_(out), window_(window) {
  out_ << event_trace_header << '\n';
}

void EventTextTrace::event(const Event& event) {
  if (window_.contains(event.time)) out_ << to_text(event) << '\n';
}

TraceLine TraceLine::parse(std::string_view text, std::size_t number) {
  TraceLine line;
  line.number = number;
  line.text = text;
  std::string_view rest = text;
  line.when = take_word(rest);
  if (line.when.empty() || line.when.find_first_not_of("0123456789.") != std::string::npos)
    reject(number, "it should start with a time in s or a cycle");
  rest = trimmed(rest);
  const std::size_t close = rest.find(']');
  if (rest.empty() || rest.front() != '[' || close == std::string_view::npos)
    reject(number, "a component such as [dsp 0] should follow");
  line.who = rest.substr(1, close - 1);
  rest.remove_prefix(close + 1);
  if (line.when.find('.') != std::string::npos) {
    take_pairs(rest, "event", line);
    return line;
  }
  line.fields.emplace_back("pc", take_word(rest));
  line.fields.emplace_back("word", take_word(rest));
  const std::size_t semicolon = rest.find(';');
  line.fields.emplace_back("instruction", trimmed(rest.substr(0, semicolon)));
  if (semicolon != std::string_view::npos) take_pairs(rest.substr(semicolon + 1), "note", line);
  return line;
}

std::string TraceDifference::message() const {
  const TraceLine& line = left ? *left : *right;
  const bool timed = line.when.find('.') != std::string::npos;
  std::string text =
      timed ? fmt::format("time {} s, {}", line.when, line.who) : fmt::format("cycle {}, {}", line.when, line.who);
  if (!left || !right) {
    text += fmt::format(": the {} trace has ended, the other continues at its line {}\n", left ? "second" : "first",
                        line.number);
  } else {
    text += fmt::format(", field {}: {} (line {}) and {} (line {})\n", field, left_value, left->number, right_value,
                        right->number);
  }
  if (left) text += fmt::format("< {}\n", left->text);
  if (right) text += fmt::format("> {}\n", right->text);
  return text;
}

std::string without_operands(std::string_view line) {
  constexpr std::string_view before = " -  ", after = "  ;", parallel = "||";
  const std::size_t begins = line.find(before);
  if (begins == std::string_view::npos) return std::string(line);
  std::string out(line.substr(0, begins + before.size()));
  std::string_view instruction = line.substr(begins + before.size());
  const std::size_t ends = std::min(instruction.find(after), instruction.size());
  const std::string_view changes = instruction.substr(ends);
  instruction = instruction.substr(0, ends);
  for (bool first = true; !instruction.empty();) {
    const std::size_t bar = std::min(instruction.find(parallel), instruction.size());
    std::string_view half = instruction.substr(0, bar);
    instruction.remove_prefix(std::min(bar + parallel.size(), instruction.size()));
    const std::string_view mnemonic = take_word(half);
    if (mnemonic.empty()) continue;
    if (!std::exchange(first, false)) out += parallel;
    out += mnemonic;
  }
  return out.append(changes);
}

std::optional<TraceDifference> compare_traces(std::istream& left, std::istream& right) {
  Reader left_reader(left);
  Reader right_reader(right);
  for (bool first = true;; first = false) {
    std::optional<TraceLine> left_line = left_reader.next();
    std::optional<TraceLine> right_line = right_reader.next();
    if (first && left_reader.header() != right_reader.header())
      throw std::invalid_argument(
          fmt::format("traces of two kinds: `{}` and `{}`", left_reader.header(), right_reader.header()));
    if (!left_line && !right_line) return std::nullopt;
    if (!left_line || !right_line)
      return TraceDifference{left_line, right_line, "end", left_line ? "" : "-", right_line ? "" : "-"};
    if (auto difference = compare_lines(*left_line, *right_line)) return difference;
  }
}

}  // namespace report
