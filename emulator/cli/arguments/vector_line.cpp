#include "cli/arguments/vector_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "isa/ascii.hpp"
#include "isa/types.hpp"

namespace cli {
namespace {

constexpr unsigned most_steps = 1'000'000;

std::string shown(std::string_view text) { return std::string(text.substr(0, 40)) + (text.size() > 40 ? "..." : ""); }

[[noreturn]] void fail(std::string_view token, std::string_view expected) {
  throw VectorError(fmt::format("\"{}\": {}", shown(token), expected));
}

std::uint64_t hexadecimal(std::string_view token, std::string_view digits, std::size_t most, std::size_t least = 1) {
  const auto value = ascii::number<std::uint64_t>(digits, 16);
  if (!value || digits.size() > most || digits.size() < least)
    fail(token, least == most ? fmt::format("{} hexadecimal digits are expected", most)
                              : fmt::format("{} to {} hexadecimal digits are expected", least, most));
  return *value;
}

isa::Word word(std::string_view token, std::string_view digits) {
  return static_cast<isa::Word>(hexadecimal(token, digits, 8));
}

std::optional<Vector::Place> place_named(std::string_view text) {
  using Kind = Vector::Place::Kind;
  if (text == "PC") return Vector::Place{Kind::pc, 0};
  // F0 to F11 are synonyms in assembly only, not here.
  if (text.starts_with('F') || text.starts_with('f')) return std::nullopt;
  if (const auto r = isa::expansion_named(text)) return Vector::Place{Kind::expansion, static_cast<std::uint8_t>(*r)};
  if (const auto r = isa::register_named(text)) return Vector::Place{Kind::primary, isa::code(*r)};
  return std::nullopt;
}

bool is_extended(Vector::Place place) {
  return place.kind == Vector::Place::Kind::primary && isa::is_extended(static_cast<isa::Register>(place.code));
}

/// Reads the tokens of both sides of the arrow.
class LineReader {
 public:
  Vector read(std::string_view line) {
    const std::size_t arrow = line.find("->");
    if (arrow == std::string_view::npos)
      throw VectorError("\"->\" between the state before and the state after is missing");
    each_token(line.substr(0, arrow), [this](auto token, auto key, auto value) { left(token, key, value); });
    each_token(line.substr(arrow + 2), [this](auto token, auto key, auto value) { right(token, key, value); });
    if (out_.code.empty()) throw VectorError("op=WORD is missing");
    return std::move(out_);
  }

 private:
  template <typename Use>
  static void each_token(std::string_view text, Use use) {
    for (const std::string_view token : ascii::words(text, " \t")) {
      const std::size_t equals = std::min(token.find('='), token.size());
      use(token, token.substr(0, equals), token.substr(std::min(equals + 1, token.size())));
    }
  }

  void setting(std::vector<Vector::Setting>& settings, std::string_view token, std::string_view key,
               std::string_view value) {
    const auto place = place_named(key);
    if (!place) fail(token, "unknown token");
    const bool extended = is_extended(*place);
    const std::uint64_t number = hexadecimal(token, value, extended ? 10 : 8, extended ? 10 : 1);
    if (std::any_of(settings.begin(), settings.end(), [&](const auto& s) { return s.place == *place; }))
      fail(token, "this register is given twice");
    settings.push_back({*place, number});
  }

  void left(std::string_view token, std::string_view key, std::string_view value) {
    if (key == "id")
      out_.id = value;
    else if (key == "m")
      out_.status_mask = word(token, value);
    else if (key == "op")
      out_.code.push_back(word(token, value));
    else if (key == "steps")
      out_.steps = step_count(token, value);
    else if (key.starts_with('@'))
      out_.memory_before.push_back({word(token, key.substr(1)), word(token, value)});
    else if (key == "PC")
      fail(token, "the address of the instruction is always 1000h");
    else
      setting(out_.before, token, key, value);
  }

  void right(std::string_view token, std::string_view key, std::string_view value) {
    if (key.starts_with("rd@")) {
      if (token.find('=') != std::string_view::npos) fail(token, "a read has no value; rd@ADDRESS is expected");
      out_.accesses.push_back({word(token, key.substr(3)), false, 0});
    } else if (key.starts_with("wr@")) {
      out_.accesses.push_back({word(token, key.substr(3)), true, word(token, value)});
    } else if (key.starts_with('@')) {
      out_.memory_after.push_back({word(token, key.substr(1)), word(token, value)});
    } else {
      setting(out_.after, token, key, value);
    }
  }

  static unsigned step_count(std::string_view token, std::string_view value) {
    const unsigned steps = ascii::number<unsigned>(value).value_or(0);
    if (steps == 0 || steps > most_steps)
      fail(token, fmt::format("a decimal number of instructions from 1 to {} is expected", most_steps));
    return steps;
  }

  Vector out_;
};

}  // namespace

Vector parse_vector(std::string_view line) { return LineReader().read(line); }

std::string name(Vector::Place place) {
  using Kind = Vector::Place::Kind;
  std::string text = "PC";
  if (place.kind == Kind::primary) text = isa::name(static_cast<isa::Register>(place.code));
  if (place.kind == Kind::expansion) text = isa::name(static_cast<isa::Expansion>(place.code));
  return ascii::upper(text);
}

}  // namespace cli
