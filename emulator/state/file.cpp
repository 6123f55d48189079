#include "state/file.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <array>
#include <cstring>

namespace state {

namespace {

constexpr std::string_view magic = "C40STATE";
constexpr std::uint64_t format = 1;

std::string sha256(std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) throw std::runtime_error("SHA-256 is not to be had from libcrypto");
  std::string digits;
  for (unsigned i = 0; i < size; ++i) digits += fmt::format("{:02x}", digest[i]);
  return digits;
}

void put_number(std::string& to, std::uint64_t number) { to.append(reinterpret_cast<const char*>(&number), sizeof number); }  // NOLINT: its bytes
void put(std::string& to, std::string_view text) {
  put_number(to, text.size());
  to += text;
}

std::string packed(std::string_view text) {
  constexpr int quick = 1;  // a state packs to a third; more work finds little more
  uLongf size = compressBound(text.size());
  std::string bytes(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(text.data()), text.size(), quick) != Z_OK)  // NOLINT
    throw std::runtime_error("no memory to pack a snapshot");
  bytes.resize(size);
  return bytes;
}

std::string unpacked(std::string_view bytes, std::uint64_t length) {
  constexpr std::uint64_t most = 1032;  // zlib packs no better
  if (length / most > bytes.size()) throw StateError("the snapshot is damaged: a part is longer than its bytes can hold");
  std::string text(length, '\0');
  uLongf size = length;
  if (uncompress(reinterpret_cast<Bytef*>(text.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != Z_OK || size != length)  // NOLINT
    throw StateError("the snapshot is damaged: a part cannot be unpacked");
  return text;
}

[[noreturn]] void cut_short() { throw StateError("the file is cut short; a whole snapshot is expected"); }

std::string_view take(std::string_view& from, std::uint64_t size) {
  if (size > from.size()) cut_short();
  const std::string_view taken = from.substr(0, size);
  from.remove_prefix(size);
  return taken;
}
std::uint64_t take_number(std::string_view& from) {
  std::uint64_t number = 0;
  std::memcpy(&number, take(from, sizeof number).data(), sizeof number);
  return number;
}

}  // namespace

std::string sealed(std::string_view kind, const std::vector<std::string_view>& parts) {
  std::string body;
  put(body, kind);
  put(body, CMRC_VERSION);
  for (const std::string_view part : parts) {
    put_number(body, part.size());
    put(body, packed(part));
  }
  std::string file(magic);
  put_number(file, format);
  return file + sha256(body) + body;
}

std::vector<std::string> opened(std::string_view file, std::string_view kind, std::size_t parts) {
  if (!file.starts_with(magic)) throw StateError("this is no snapshot: it does not begin with " + std::string(magic));
  file.remove_prefix(magic.size());
  if (const std::uint64_t its = take_number(file); its != format)
    throw StateError(fmt::format("the snapshot has format {}; this emulator reads format {}", its, format));
  const std::string_view digest = take(file, 64);
  if (sha256(file) != digest) throw StateError("the snapshot is damaged or cut short: its checksum is another");
  if (const std::string_view its = take(file, take_number(file)); its != kind)
    throw StateError(fmt::format("the snapshot is of a {}; one of a {} is expected", its, kind));
  if (const std::string_view its = take(file, take_number(file)); its != CMRC_VERSION)
    throw StateError(fmt::format("the snapshot is of version {} of the emulator; this is version {}", its, CMRC_VERSION));
  std::vector<std::string> all;
  while (!file.empty()) {
    const std::uint64_t length = take_number(file);
    all.push_back(unpacked(take(file, take_number(file)), length));
  }
  if (all.size() != parts) throw StateError(fmt::format("the snapshot has {} parts; {} are expected", all.size(), parts));
  return all;
}

}  // namespace state
