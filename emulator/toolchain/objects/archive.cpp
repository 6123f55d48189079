#include "toolchain/objects/archive.hpp"

#include <fmt/format.h>

#include <string_view>

#include "isa/ascii.hpp"
#include "toolchain/objects/coff.hpp"

namespace toolchain {
namespace {

constexpr std::string_view magic = "!<arch>\n";
constexpr std::size_t header_size = 60;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string_view trimmed(std::string_view text) {
  const auto last = text.find_last_not_of(' ');
  return last == std::string_view::npos ? std::string_view() : text.substr(0, last + 1);
}

/// For messages: a damaged library may contain any bytes.
std::string shown(std::string_view name) {
  std::string out(name);
  for (char& c : out)
    if (c < ' ' || c > '~') c = '?';
  return out;
}

/// "name/", "name", or "/17": a place in the table of long names.
std::string member_name(std::string_view field, std::string_view long_names) {
  if (field.size() > 1 && field[0] == '/') {
    const auto at = ascii::number<std::size_t>(field.substr(1));
    if (at && *at < long_names.size()) {
      const auto name = long_names.substr(*at);
      return shown(name.substr(0, name.find_first_of("/\n")));
    }
  }
  if (field.ends_with('/')) field.remove_suffix(1);
  return shown(field);
}

}  // namespace

bool is_archive(std::span<const std::byte> bytes) { return text_of(bytes).starts_with(magic); }

std::vector<ArchiveMember> archive_members(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text = text_of(bytes);
  std::vector<ArchiveMember> out;
  std::string_view long_names;
  for (std::size_t at = magic.size(); at < text.size(); at += at % 2) {
    if (text.size() - at < header_size)
      throw CoffError(fmt::format("{}: cut short: a member's header at byte {}", name, at));
    const auto header = text.substr(at, header_size);
    const auto size = ascii::number<std::size_t>(trimmed(header.substr(48, 10)));
    if (!size || header.substr(58, 2) != "`\n")
      throw CoffError(fmt::format("{}: no header of a library's member at byte {}", name, at));
    at += header_size;
    if (*size > text.size() - at)
      throw CoffError(fmt::format("{}: cut short: a member of {} bytes at byte {}", name, *size, at));
    const auto field = trimmed(header.substr(0, 16));
    if (field == "//") {
      long_names = text.substr(at, *size);
    } else if (field != "/" && !field.starts_with("__.SYMDEF") && !field.empty()) {
      out.push_back({member_name(field, long_names), bytes.subspan(at, *size)});
    }
    at += *size;
  }
  return out;
}

}  // namespace toolchain
