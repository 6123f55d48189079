#include "report/text/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace report {

std::string TextTable::render() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows_) {
    std::string line = "  ";
    for (std::size_t i = 0; i < row.size(); ++i)
      line += i == 0 ? fmt::format("{:<{}}", row[i], widths[i]) : fmt::format("  {:>{}}", row[i], widths[i]);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string duration(double picoseconds) {
  struct Unit {
    double size;
    const char* name;
  };
  static constexpr std::array units = {Unit{1e12, "s"}, Unit{1e9, "ms"}, Unit{1e6, "us"}, Unit{1e3, "ns"}};
  if (picoseconds == 0) return "0";
  const double magnitude = std::abs(picoseconds);
  for (const Unit& unit : units) {
    const double value = magnitude / unit.size;
    if (value < 1) continue;
    const int decimals = value < 10 ? 3 : value < 100 ? 2 : value < 1000 ? 1 : 0;
    return fmt::format("{:.{}f} {}", picoseconds / unit.size, decimals, unit.name);
  }
  return fmt::format("{:.0f} ps", picoseconds);
}

std::string percent(double part, double whole) {
  if (part <= 0 || whole <= 0) return "0";
  const double value = 100 * part / whole;
  return value < 0.05 ? "<0.1" : fmt::format("{:.1f}", value);
}

}  // namespace report
