#pragma once
/// Numbers in rows, rewritten so that they pack well, and back bit for bit. What a run records moves smoothly: each
/// column is told by its differences of the order that leaves least, and these byte by byte, the high bytes of all
/// together.
#include <string>
#include <string_view>
#include <vector>

namespace state {

/// Where a text holds rows of words of eight bytes: doubles or integers.
struct Table {
  std::size_t offset = 0, rows = 0, columns = 0;
  std::size_t bytes() const { return rows * columns * 8; }
};

/// Rewrites the tables of `text` in place. Returns how each column is written, one byte each.
std::string to_columns(std::string& text, const std::vector<Table>& tables);
/// The way back. \param how what `to_columns` returned, for the same tables; a byte that it cannot have returned throws
/// StateError
void from_columns(std::string& text, const std::vector<Table>& tables, std::string_view how);

}  // namespace state
