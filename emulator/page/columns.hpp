#pragma once
// Columns of numbers and texts in few bytes: the recording of a run inside a page (docs/page.md, The recording).
//
// A column of numbers has whole numbers, each minus a prediction from the numbers before: 0 (order 0), the last number
// (order 1), or a straight line through the last two (order 2). The order with the shortest result is kept. The
// differences are written as zigzag varints and deflated. page/src/data/columns.ts and python/cmrc/page.py read them.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

namespace page {

class Columns {
 public:
  void whole(const std::string& name, std::span<const std::int64_t> values);
  /// Numbers, rounded to a multiple of `unit`. \throws std::invalid_argument for a number that is not finite
  void scaled(const std::string& name, std::span<const double> values, double unit);
  void text(const std::string& name, std::string_view utf8);

  /// Eight bytes "CMRCpage", the size of the header (4 bytes, the lowest first), the header as JSON with the names of
  /// the columns, then the columns one after the other.
  std::string bytes(nlohmann::json header) const;

 private:
  void add(const std::string& name, std::span<const std::int64_t> values, double unit);

  nlohmann::json list_ = nlohmann::json::array();
  std::string data_;
};

/// Base64 (RFC 4648), without line ends.
std::string base64(std::string_view bytes);

}  // namespace page
