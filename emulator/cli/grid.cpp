#include "cli/grid.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "cli/options.hpp"

namespace cli {
namespace {

constexpr std::size_t most_points = 1000;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// In millionths.
std::optional<std::int64_t> parse_number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty() || !(std::abs(value) < 1e9))
    return std::nullopt;
  return std::llround(value * 1e6);
}

}  // namespace

std::vector<double> parse_grid(const std::string& text, const std::string& option) {
  const auto refuse = [&](const std::string& why) {
    return InputError(fmt::format("{}: \"{}\" {}; FROM:TO:STEP or VALUE,VALUE,... is expected", option, text, why));
  };
  const bool range = text.find(':') != std::string::npos;
  std::vector<std::int64_t> numbers;
  for (const std::string& part : split(text, range ? ':' : ',')) {
    const auto number = parse_number(part);
    if (!number) throw refuse("is no grid");
    numbers.push_back(*number);
  }
  std::vector<double> values;
  if (!range) {
    for (const std::int64_t number : numbers) values.push_back(static_cast<double>(number) / 1e6);
    return values;
  }
  if (numbers.size() == 2) numbers.push_back(1'000'000);
  if (numbers.size() != 3) throw refuse("is no range");
  if (numbers[2] <= 0) throw refuse("has no positive step");
  if (numbers[0] > numbers[1]) throw refuse("holds no value");
  if ((numbers[1] - numbers[0]) / numbers[2] >= static_cast<std::int64_t>(most_points))
    throw refuse(fmt::format("holds more than {} values", most_points));
  for (std::int64_t number = numbers[0]; number <= numbers[1]; number += numbers[2])
    values.push_back(static_cast<double>(number) / 1e6);
  return values;
}

}  // namespace cli
