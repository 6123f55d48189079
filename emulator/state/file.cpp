#include "state/file.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

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
  for (const std::string_view part : parts) put(body, part);
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
  while (!file.empty()) all.emplace_back(take(file, take_number(file)));
  if (all.size() != parts) throw StateError(fmt::format("the snapshot has {} parts; {} are expected", all.size(), parts));
  return all;
}

}  // namespace state
