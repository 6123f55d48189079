#include "state/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace state {

namespace {

// FNV-1a
std::uint32_t hash(std::string_view name) {
  std::uint32_t h = 0x811C9DC5;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x01000193;
  return h;
}

std::string hexadecimal(std::string_view bytes) {
  constexpr std::size_t most = 16;
  std::string text;
  for (const char c : bytes.substr(0, most)) text += fmt::format("{:02X}", static_cast<unsigned char>(c));
  return bytes.size() > most ? text + "..." : text;
}

}  // namespace

void Saver::bytes(void* data, std::size_t size) { text_.append(static_cast<const char*>(data), size); }

void Saver::rows(void* first, std::size_t count, std::size_t columns) {
  constexpr std::size_t few =
      256;  // tables with fewer rows are left as they are: a note about them would be longer than what they save
  if (count >= few) tables_.push_back({text_.size(), count, columns});
  bytes(first, count * columns * sizeof(std::uint64_t));
}

std::size_t Saver::count(std::size_t present, std::size_t /*least*/) {
  std::uint64_t n = present;
  bytes(&n, sizeof n);
  return present;
}

void Saver::listed(std::string_view name) {
  const std::uint32_t tag = hash(name);
  text_.append(reinterpret_cast<const char*>(&tag), sizeof tag);  // the bytes of a number
}

void Loader::refuse_here(const std::string& what) const { refuse(fmt::format("{}: {}", fmt::join(path_, "."), what)); }

void Loader::bytes(void* data, std::size_t size) {
  if (rest_.size() < size) refuse_here("the state ends here");
  if (size == 0) return;  // an empty vector has no address to copy to
  std::memcpy(data, rest_.data(), size);
  rest_.remove_prefix(size);
}

std::size_t Loader::count(std::size_t /*present*/, std::size_t least) {
  std::uint64_t n = 0;
  bytes(&n, sizeof n);
  if (n > rest_.size() / least) refuse_here(fmt::format("{} elements, more than fit into the rest of the state", n));
  return static_cast<std::size_t>(n);
}

void Loader::listed(std::string_view name) {
  path_.push_back(name);
  std::uint32_t tag = 0;
  bytes(&tag, sizeof tag);
  if (tag != hash(name)) refuse_here("the state has another field here; it comes from another version");
}

void Loader::end() const {
  if (!rest_.empty()) refuse(fmt::format("{} bytes after the end of the state", rest_.size()));
}

void Lister::add(std::string_view name) {
  ends_.push_back(path_.size());
  if (!path_.empty()) path_ += '.';
  path_ += name;
}

void Lister::bytes(void* data, std::size_t size) {
  leaves_.push_back({path_, text().size(), size});
  Saver::bytes(data, size);
}

std::size_t Lister::count(std::size_t present, std::size_t least) {
  add("count");
  Saver::count(present, least);
  leave();
  return present;
}

void Lister::listed(std::string_view name) {
  Saver::listed(name);
  add(name);
}

void Lister::part(std::size_t index) { add(std::to_string(index)); }

void Lister::leave() {
  path_.resize(ends_.back());
  ends_.pop_back();
}

std::optional<std::string> first_difference(const Lister& a, const Lister& b) {
  const auto said = [](const Lister& list, const Leaf& leaf) {
    return std::string_view(list.text()).substr(leaf.offset, leaf.size);
  };
  for (std::size_t i = 0; i < std::max(a.leaves().size(), b.leaves().size()); ++i) {
    if (i >= a.leaves().size() || i >= b.leaves().size())
      return fmt::format("{}: only in one of the two", (i < a.leaves().size() ? a : b).leaves()[i].path);
    const Leaf &one = a.leaves()[i], &other = b.leaves()[i];
    if (one.path != other.path) return fmt::format("{} beside {}", one.path, other.path);
    if (said(a, one) != said(b, other))
      return fmt::format("{}: {} beside {}", one.path, hexadecimal(said(a, one)), hexadecimal(said(b, other)));
  }
  return std::nullopt;
}

}  // namespace state
