#pragma once
// Reads a TOML file of a user: errors are collected with their places, and reported together.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/nearest.hpp"
#include "io/toml.hpp"

namespace io {

class TomlReader {
 public:
  explicit TomlReader(std::string file) : file_(std::move(file)) {}
  const std::string& file() const { return file_; }

  /// A path that the file has: relative to the file's folder.
  std::string beside(const std::string& path) const {
    return (std::filesystem::path(file_).parent_path() / path).string();
  }

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
  /// Reads the value of a key that must be there. \param of what has the key, for the message
  /// \returns false: the key is missing, or its value had an error
  template <class Read>
  bool needed(const toml::table& table, std::string_view key, std::string_view of, Read&& read) {
    const auto* node = table.get(key);
    if (node == nullptr) note(table, fmt::format("{}: {} is missing", of, key));
    return node != nullptr && attempt([&] { read(*node); });
  }
  /// Reads each table of an array of tables, if the key is there.
  template <class Read>
  void each(const toml::table& table, std::string_view key, Read&& read) {
    const auto* all = table.get(key);
    if (all == nullptr) return;
    const auto wrong = [&](const toml::node& node) {
      note(node, fmt::format("{}: each is a table, [[{}]]", key, key));
    };
    if (!all->is_array()) return wrong(*all);
    for (const auto& node : *all->as_array())
      if (!node.is_table())
        wrong(node);
      else
        attempt([&] { read(*node.as_table()); });
  }

  /// \throws Error with the first noted errors in the order of their lines, and how many more there are
  template <class Error>
  void finish() const {
    if (errors_.empty()) return;
    constexpr std::size_t most = 20;
    std::vector<std::string> lines;
    for (const auto& [line, what] : errors_)
      if (lines.size() < most) lines.push_back(what);
    if (errors_.size() > most) lines.push_back(fmt::format("{}: {} more errors", file_, errors_.size() - most));
    throw Error(fmt::format("{}", fmt::join(lines, "\n")));
  }

  template <class Keys>
  void allow(const toml::table& table, std::string_view prefix, const Keys& keys) {
    for (const auto& [key, node] : table)
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
        note(node, fmt::format("no such key {}{}; known are {}{}", prefix, key.str(), fmt::join(keys, ", "),
                               did_you_mean(key.str(), keys)));
  }

  std::string text(const toml::node& node, std::string_view key) {
    if (!node.is_string()) fail(node, fmt::format("{}: text in quotes is expected", key));
    return node.as_string()->get();
  }
  std::int64_t whole(const toml::node& node, std::string_view key, std::int64_t least, std::int64_t most) {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < least || value->get() > most)
      fail(node, fmt::format("{}: an integer from {} to {} is expected", key, least, most));
    return value->get();
  }
  double real(const toml::node& node, std::string_view key, double least, double most) {
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !(*value >= least) || *value > most)
      fail(node, fmt::format("{}: a number from {} to {} is expected", key, least, most));
    return *value;
  }
  bool truth(const toml::node& node, std::string_view key) {
    if (!node.is_boolean()) fail(node, fmt::format("{}: true or false is expected", key));
    return node.as_boolean()->get();
  }

 private:
  std::string file_;
  std::multimap<std::size_t, std::string> errors_;  ///< by line
};

}  // namespace io
