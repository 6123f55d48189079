#pragma once
// Columns of text for a terminal: the first aligned left, the others right.
#include <string>
#include <vector>

namespace report {

class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  bool empty() const { return rows_.size() < 2; }
  /// Indented by two, two spaces between columns.
  std::string render() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// Picoseconds in a suitable unit, four significant digits: "31.25 us", "8.812 ms", "12.34 s", "0".
std::string duration(double picoseconds);
/// 12.3 % as "12.3"; "0" for exactly nothing, "<0.1" for less than a tenth of a percent.
std::string percent(double part, double whole);

}  // namespace report
