#pragma once
/// Rows of numbers, rewritten so that they compress well, and restored bit for bit. What a run records moves smoothly:
/// each column becomes its differences of the best order, and these are stored byte by byte, the high bytes of all
/// together.
#include <string>
#include <string_view>
#include <vector>

namespace state {

/// The place in a text of rows of eight-byte words: doubles or integers.
struct Table {
  std::size_t offset = 0, rows = 0, columns = 0;
  std::size_t bytes() const { return rows * columns * 8; }
};

/// Rewrites the tables of `text` in place. Returns the form of each column, one byte each.
std::string to_columns(std::string& text, const std::vector<Table>& tables);
/// The inverse of to_columns. \param how what `to_columns` returned for the same tables; throws StateError for a byte
/// that to_columns cannot return
void from_columns(std::string& text, const std::vector<Table>& tables, std::string_view how);

}  // namespace state
