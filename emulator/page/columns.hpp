#pragma once
// Columns of numbers and texts in few bytes: what a page carries of its run (docs/page.md, The recording).
//
// A column of numbers is whole numbers, each less what the ones before it foretell: nothing (order 0), that it stays
// (1), that it goes on as it went (2). Of the three the shortest is kept. What is left is written as zigzag varints,
// deflated. page/src/data/columns.ts and python/cmrc/page.py read them.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace page {

class Columns {
 public:
  void whole(const std::string& name, std::span<const std::int64_t> values);
  /// Numbers to the nearest multiple of `unit`. \throws std::invalid_argument for one that is not finite
  void scaled(const std::string& name, std::span<const double> values, double unit);
  void text(const std::string& name, std::string_view utf8);

  /// Eight bytes "CMRCpage", the size of the header (4 bytes, the lowest first), the header as JSON with the columns'
  /// names, and the columns one after the other.
  std::string bytes(nlohmann::json header) const;

 private:
  void add(const std::string& name, std::span<const std::int64_t> values, double unit);

  nlohmann::json list_ = nlohmann::json::array();
  std::string data_;
};

/// Base64 (RFC 4648), without line ends.
std::string base64(std::string_view bytes);

}  // namespace page
