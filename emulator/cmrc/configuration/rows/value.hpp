#pragma once
// Values from the user, the places where they were given, and the error for a wrong value.
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "io/text_error.hpp"

namespace cmrc {

using Value = std::variant<bool, std::int64_t, double, std::string>;

/// The place of a value: a file with line and column, or the name of a flag or an argument.
struct Origin {
  std::string name;
  std::int64_t line = 0;
  std::int64_t column = 0;
  std::string text() const;
};

/// "FILE:line:column: key: what is wrong; what would be right" (line and column only if known).
class ConfigError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

/// \throws ConfigError in this form
[[noreturn]] void refuse(const Origin& origin, std::string_view key, std::string_view what, std::string_view right);

/// The errors of one file. Its parts are read one after another, so that the user gets the errors of all of them.
class ConfigErrors {
 public:
  /// Reads a part of the file, and keeps its ConfigError. After the first `most` errors nothing more is read.
  template <class Read>
  void attempt(const Origin& place, Read&& read) {
    if (found_.size() == most) return;
    try {
      read();
    } catch (const ConfigError& error) {
      found_.emplace(std::pair(place.line, place.column), error.what());
    }
  }
  /// \throws ConfigError with the kept errors in the order of their places, one in a line
  void finish() const;

 private:
  static constexpr std::size_t most = 20;
  std::multimap<std::pair<std::int64_t, std::int64_t>, std::string> found_;
};

/// The value as TOML.
std::string show(const Value& value);
/// "a boolean", "an integer", "a number", "a string"
std::string_view noun(const Value& value);
/// "a", "b" or "c"
std::string quoted_list(const std::vector<std::string>& words);
/// `"hang" or "fail" is expected`, and which of the words is near to `given`, if one is.
std::string one_expected(std::string_view given, const std::vector<std::string>& words);

}  // namespace cmrc
