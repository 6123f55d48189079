#include "page/columns.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace page {
namespace {

std::string deflated(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, MAX_MEM_LEVEL, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib cannot begin to deflate");
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  if (out.size() > std::numeric_limits<uInt>::max()) {
    deflateEnd(&stream);
    throw std::runtime_error(fmt::format("a column of {} bytes is too long for a page", bytes.size()));
  }
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("zlib cannot deflate a column");
  return out;
}

/// Seven bits per byte, the lowest first; a set eighth bit says that more bytes follow. The sign is the lowest bit.
void put_varint(std::string& out, std::int64_t value) {
  auto bits = static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
  for (; bits >= 0x80; bits >>= 7) out.push_back(static_cast<char>(bits | 0x80));
  out.push_back(static_cast<char>(bits));
}

std::string varints(std::span<const std::int64_t> values, int order) {
  std::string out;
  out.reserve(values.size() * 2);
  std::int64_t before = 0, step = 0;
  for (const std::int64_t value : values) {
    put_varint(out, order == 0 ? value : order == 1 ? value - before : value - before - step);
    step = value - before;
    before = value;
  }
  return out;
}

}  // namespace

void Columns::add(const std::string& name, std::span<const std::int64_t> values, double unit) {
  std::string shortest;
  int kept = 0;
  for (const int order : {0, 1, 2}) {
    std::string written = deflated(varints(values, order));
    if (order == 0 || written.size() < shortest.size()) shortest = std::move(written), kept = order;
  }
  list_.push_back({{"name", name},
                   {"count", values.size()},
                   {"order", kept},
                   {"unit", unit},
                   {"at", data_.size()},
                   {"size", shortest.size()}});
  data_ += shortest;
}

void Columns::whole(const std::string& name, std::span<const std::int64_t> values) { add(name, values, 1); }

void Columns::scaled(const std::string& name, std::span<const double> values, double unit) {
  std::vector<std::int64_t> steps;
  steps.reserve(values.size());
  for (const double value : values) {
    if (!(std::abs(value / unit) < 9e15))
      throw std::invalid_argument(fmt::format("column {}: {} cannot be stored in steps of {}", name, value, unit));
    steps.push_back(std::llround(value / unit));
  }
  add(name, steps, unit);
}

void Columns::text(const std::string& name, std::string_view utf8) {
  const std::string written = deflated(utf8);
  list_.push_back({{"name", name}, {"text", utf8.size()}, {"at", data_.size()}, {"size", written.size()}});
  data_ += written;
}

std::string Columns::bytes(nlohmann::json header) const {
  header["columns"] = list_;
  const std::string text = header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string out = "CMRCpage";
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(text.size() >> shift & 0xFF));
  return out + text + data_;
}

std::string base64(std::string_view bytes) {
  static constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    const std::size_t here = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < here ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) out.push_back(k <= here ? digits[word >> (18 - 6 * k) & 63] : '=');
  }
  return out;
}

}  // namespace page
