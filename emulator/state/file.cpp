#include "state/file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "state/archive.hpp"
#include "state/sha256.hpp"

namespace state {
namespace {

constexpr std::string_view magic = "CMRC state\n";

struct Envelope {
  std::string kind;
  std::vector<std::pair<std::string, std::string>> key;  // values as fingerprints
  Saved state;
};

template <class T>
void append(std::string& out, T number) {
  out.append(reinterpret_cast<const char*>(&number), sizeof number);  // NOLINT: bytes of a number
}
void append_text(std::string& out, std::string_view text) {
  append(out, std::uint64_t{text.size()});
  out += text;
}

std::string packed(std::string_view text) {
  constexpr int quick = 1;  // a state compresses to a third; a slower level gains little
  uLongf size = compressBound(text.size());
  std::string bytes(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(text.data()), text.size(),
                quick) != Z_OK)  // NOLINT: bytes
    throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

std::string unpacked(std::string_view bytes, std::uint64_t length) {
  constexpr std::uint64_t most = 1032;  // zlib's limit of compression
  std::string text;
  uLongf size = length;
  if (length / most <= bytes.size()) text.resize(length);
  if (text.size() != length ||
      uncompress(reinterpret_cast<Bytef*>(text.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                 bytes.size()) != Z_OK ||
      size != length)  // NOLINT
    throw StateError("the snapshot is damaged: its state cannot be unpacked");
  return text;
}

/// A checksum excludes damaged envelopes; whatever passes nevertheless is refused here.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  std::uint64_t number() {
    std::uint64_t out = 0;
    std::memcpy(&out, take(sizeof out).data(), sizeof out);
    return out;
  }
  std::string text() { return std::string(take(number())); }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size()) throw StateError("the snapshot is damaged: it ends too early");
    const std::string_view out = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return out;
  }
  std::string_view rest_;
};

Envelope read(std::string_view sealed) {
  constexpr std::size_t digits = 64;                                               // of the checksum
  constexpr std::size_t head = magic.size() + 2 * sizeof(std::uint64_t) + digits;  // version, size, checksum
  if (sealed.size() < magic.size() || !sealed.starts_with(magic))
    throw StateError(
        fmt::format("{} bytes that are not a snapshot; a snapshot begins with \"CMRC state\"", sealed.size()));
  if (sealed.size() < head) throw StateError("the snapshot was cut short");
  Reader start(sealed.substr(magic.size(), head - magic.size()));
  const std::uint64_t its_version = start.number(), size = start.number();
  if (its_version != version)
    throw StateError(fmt::format("a snapshot of version {}; this emulator reads version {}", its_version, version));
  const std::string_view body = sealed.substr(head);
  if (body.size() != size)
    throw StateError(fmt::format("the snapshot was cut short or extended: {} bytes instead of {}", body.size(), size));
  if (sha256(body) != sealed.substr(head - digits, digits))
    throw StateError("the snapshot is damaged: its checksum is wrong");
  Reader reader(body);
  Envelope out;
  out.kind = reader.text();
  for (std::uint64_t n = reader.number(); n != 0; --n) {
    std::string what = reader.text();
    out.key.emplace_back(std::move(what), reader.text());
  }
  for (std::uint64_t n = reader.number(); n != 0; --n) {
    const std::uint64_t offset = reader.number(), rows = reader.number();
    out.state.tables.push_back({offset, rows, reader.number()});
  }
  const std::string how = reader.text();
  const std::uint64_t length = reader.number();
  out.state.text = unpacked(reader.text(), length);
  if (!reader.at_end()) throw StateError("the snapshot is damaged: bytes follow its end");
  for (const Table& table : out.state.tables) {
    const std::uint64_t room = length - std::min(length, table.offset), words = room / sizeof(std::uint64_t);
    if (table.columns == 0 || table.rows > words / table.columns)
      throw StateError("the snapshot is damaged: a table reaches beyond its end");
  }
  from_columns(out.state.text, out.state.tables, how);
  return out;
}

}  // namespace

std::string seal(std::string_view kind, const Key& key, Saved state) {
  std::string body;
  append_text(body, kind);
  append(body, std::uint64_t{key.size()});
  for (const auto& [what, value] : key) append_text(body, what), append_text(body, sha256(value));
  append(body, std::uint64_t{state.tables.size()});
  for (const Table& table : state.tables)
    for (const std::uint64_t number : {table.offset, table.rows, table.columns}) append(body, number);
  append_text(body, to_columns(state.text, state.tables));
  append(body, std::uint64_t{state.text.size()});
  append_text(body, packed(state.text));
  std::string out(magic);
  append(out, std::uint64_t{version});
  append(out, std::uint64_t{body.size()});
  out += sha256(body);
  return out += body;
}

std::string kind_of(std::string_view sealed) { return read(sealed).kind; }

Saved opened(std::string_view sealed, std::string_view kind, const Key& key) {
  Envelope envelope = read(sealed);
  if (envelope.kind != kind)
    throw StateError(fmt::format("a snapshot of a {}; one of a {} is expected", envelope.kind, kind));
  for (std::size_t n = 0; n < std::max(key.size(), envelope.key.size()); ++n) {
    if (n >= key.size() || n >= envelope.key.size() || key[n].first != envelope.key[n].first)
      throw StateError(fmt::format("a snapshot of another {}: {} {}", kind,
                                   n < envelope.key.size() ? envelope.key[n].first : key[n].first,
                                   n < envelope.key.size() ? "is not here" : "is not in it"));
    if (sha256(key[n].second) != envelope.key[n].second)
      throw StateError(fmt::format("a snapshot of another {}: the {} is not the same", kind, key[n].first));
  }
  return std::move(envelope.state);
}

}  // namespace state
