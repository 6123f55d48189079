#pragma once
// Reads board files: errors are collected with their places, and reported together.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/nearest.hpp"
#include "io/toml.hpp"
#include "machine/board_file.hpp"

namespace machine {

class BoardToml {
 public:
  explicit BoardToml(std::string file) : file_(std::move(file)) {}
  const std::string& file() const { return file_; }

  /// Every region could be read. Only then an error reports a device outside all regions.
  bool regions_known = true;

  /// The files that the board file names are read.
  bool reads_files = true;

  /// Thrown by fail() after it has noted the error; reading continues with the next part.
  struct Noted {};

  void note(const toml::node& node, const std::string& what) {
    const auto line = static_cast<std::size_t>(node.source().begin.line);
    errors_.emplace(line, fmt::format("{}:{}: {}", file_, line, what));
  }
  /// An error of the whole file.
  void note(const std::string& what) { errors_.emplace(0, fmt::format("{}: {}", file_, what)); }
  [[noreturn]] void fail(const toml::node& node, const std::string& what) {
    note(node, what);
    throw Noted{};
  }

  /// Reads a part; false: it had an error.
  template <class Read>
  bool attempt(Read&& read) {
    try {
      read();
      return true;
    } catch (const Noted&) {
      return false;
    }
  }
  /// Reads the value of a key, if the key is there.
  template <class Read>
  void optional(const toml::table& table, std::string_view key, Read&& read) {
    if (const auto* node = table.get(key)) attempt([&] { read(*node); });
  }

  /// \throws BoardError with all noted errors, in the order of their lines
  void finish() const {
    if (errors_.empty()) return;
    std::vector<std::string> lines;
    for (const auto& [line, what] : errors_) lines.push_back(what);
    throw BoardError(fmt::format("{}", fmt::join(lines, "\n")));
  }

  template <class Keys>
  void allow(const toml::table& table, const std::string& prefix, const Keys& keys) {
    for (const auto& [key, node] : table)
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
        note(node, fmt::format("no such key {}{}; known are {}{}", prefix, key.str(), fmt::join(keys, ", "),
                               io::did_you_mean(key.str(), keys)));
  }

  std::string text(const toml::node& node, std::string_view key) {
    if (!node.is_string()) fail(node, fmt::format("{}: text in quotes is expected", key));
    return node.as_string()->get();
  }

  std::int64_t whole(const toml::node& node, std::string_view key, std::int64_t least, std::int64_t most) {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < least || value->get() > most)
      fail(node, fmt::format("{}: a whole number from {} to {} is expected", key, least, most));
    return value->get();
  }
  c40::Word word(const toml::node& node, std::string_view key, std::int64_t most = 0xFFFFFFFF) {
    return static_cast<c40::Word>(whole(node, key, 0, most));
  }

 private:
  std::string file_;
  std::multimap<std::size_t, std::string> errors_;  ///< by line
};

/// [[device]] tables, to be read after the regions. Adds the devices to the board.
void read_devices(BoardToml& toml, BoardDescription& board, const toml::node& node);
/// A file that a board file names: relative to the board file.
std::string beside_board(const BoardToml& toml, const std::string& given);

}  // namespace machine
