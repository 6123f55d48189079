#include "toolchain/assembler/substitution.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "isa/ascii.hpp"
#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {
namespace {

constexpr int deepest = 10;
constexpr std::size_t longest_line = 1 << 16;

bool is_name(char c) { return ascii::is_letter_or_digit(c) || c == '_'; }

std::string_view name_at(std::string_view text, std::size_t start, bool (*is_part)(char)) {
  std::size_t end = start;
  while (end < text.size() && is_part(text[end])) ++end;
  return text.substr(start, end - start);
}

std::optional<std::size_t> count_of(std::string_view text) { return ascii::number<std::size_t>(ascii::trimmed(text)); }

class Substitution {
 public:
  Substitution(const Substitutes& symbols, bool nested) : symbols_(symbols), nested_(nested) {}

  std::string line(std::string_view text, int depth, bool with_words = true) {
    std::string out;
    char quote = 0;
    for (std::size_t i = 0; i < text.size();) {
      const char c = text[i];
      if (quote == 0 && (c == ';' || (i == 0 && c == '*' && depth == 0))) {
        out += text.substr(i);  // A comment.
        break;
      }
      if (c == '"') quote = quote == 0 ? c : '\0';
      if (const std::size_t length = quote == 0 && c == '\'' ? character(text, i, out, depth) : 0; length != 0) {
        i += length;
        continue;
      }
      const std::size_t taken = c == '\\' || c == ':'                          ? forced(text, i, out, depth)
                                : with_words && quote == 0 && is_identifier(c) ? word(text, i, out, depth)
                                                                               : 0;
      const std::size_t kept = taken != 0 ? 0 : quote != 0 && c == '\\' ? 2 : 1;  // \" in quotes does not end them
      out += text.substr(i, kept);
      i += taken + kept;
      check_length(out);
    }
    return out;
  }

 private:
  static void check_length(std::string_view out) {
    if (out.size() > longest_line)
      throw LineError{0, fmt::format("substitution makes this line longer than {} characters", longest_line)};
  }

  void put(const std::string& value, std::string& out, int depth) {
    if (nested_ && depth + 1 < deepest)
      out += line(value, depth + 1);
    else
      out += value;
  }

  /// A character constant, as it is written or as it is with its \name and :name: put in.
  std::size_t character(std::string_view text, std::size_t at, std::string& out, int depth) {
    const std::size_t written = character_constant(text.substr(at));
    const std::size_t end = text.find('\'', at + 1);
    if (end == std::string_view::npos || end == at + 1) {  // '''' is a quote
      out += text.substr(at, written);
      return written;
    }
    std::string constant = "'";
    for (std::size_t i = at + 1; i < end;) {
      const std::size_t taken = text[i] == '\\' || text[i] == ':' ? forced(text.substr(0, end), i, constant, depth) : 0;
      if (taken == 0) constant += text[i];
      i += std::max<std::size_t>(taken, 1);
      check_length(constant);
    }
    constant += '\'';
    if (written == 0 && character_constant(constant) != constant.size()) return 0;
    out += constant;
    return end + 1 - at;
  }

  std::size_t word(std::string_view text, std::size_t at, std::string& out, int depth) {
    const auto name = name_at(text, at, is_identifier);
    const auto found = symbols_.find(name);
    if (found == symbols_.end())
      out += name;
    else
      put(found->second, out, depth);
    return name.size();
  }

  /// \name or :name: or a part of it, :name(n,count):
  std::size_t forced(std::string_view text, std::size_t at, std::string& out, int depth) {
    const auto name = name_at(text, at + 1, is_name);
    const auto found = symbols_.find(name);
    if (found == symbols_.end()) return 0;
    std::size_t after = at + 1 + name.size();
    if (text[at] == '\\') {
      put(found->second, out, depth);
      return after - at;
    }
    std::string value = found->second;
    if (after < text.size() && text[after] == '(') {
      const auto close = text.find(')', after);
      if (close == std::string_view::npos) return 0;
      const auto inside = text.substr(after + 1, close - after - 1);
      const auto comma = inside.find(',');
      const auto first = count_of(inside.substr(0, comma));
      const auto count =
          comma == std::string_view::npos ? std::optional<std::size_t>(1) : count_of(inside.substr(comma + 1));
      if (!first || !count || *first == 0) return 0;
      value = *first > value.size() ? std::string() : value.substr(*first - 1, *count);
      after = close + 1;
    }
    if (after >= text.size() || text[after] != ':') return 0;
    put(value, out, depth);
    return after + 1 - at;
  }

  const Substitutes& symbols_;
  bool nested_;
};

/// The functions of TI's macro language.
class Functions {
 public:
  explicit Functions(const SubstituteScopes& symbols) : symbols_(symbols) {}

  std::optional<long> call(std::string_view name, const std::vector<std::string>& arguments) {
    const bool two = name == "$symcmp" || name == "$firstch" || name == "$lastch" || name == "$ismember";
    if (arguments.size() != (two ? 2U : 1U)) return std::nullopt;
    const std::string a = value(arguments[0]);
    if (name == "$symlen") return static_cast<long>(a.size());
    if (name == "$symcmp") return sign(a.compare(value(arguments[1])));
    if (name == "$firstch") return place(a.find(character(arguments[1])));
    if (name == "$lastch") return place(a.rfind(character(arguments[1])));
    if (name == "$isdefed") return symbols_.is_defined(a) ? 1 : 0;
    if (name == "$ismember") return take_member(arguments[0], arguments[1]);
    if (name == "$iscons") return static_cast<long>(constant_kind(a));
    if (name == "$isname")
      return !a.empty() && is_identifier_start(a[0]) && std::ranges::all_of(a, is_identifier) ? 1 : 0;
    if (name == "$isreg") return isa::register_named(a, symbols_.cpu) ? 1 : 0;
    return std::nullopt;
  }

 private:
  static long sign(int order) { return order < 0 ? -1 : order > 0 ? 1 : 0; }
  static long place(std::size_t index) { return index == std::string::npos ? 0 : static_cast<long>(index) + 1; }

  static std::string unquoted(const std::string& text) {
    return text.size() >= 2 && text.front() == '"' && text.back() == '"' ? text.substr(1, text.size() - 2) : text;
  }

  std::string value(const std::string& argument) const {
    const std::string* found = symbols_.find(argument);
    return unquoted(found != nullptr ? *found : argument);
  }

  std::string character(const std::string& argument) const {
    return argument.size() == 3 && argument.front() == '\'' ? argument.substr(1, 1) : value(argument);
  }

  /// Moves the first item of the list `from` into `to`; 0 if there is none.
  long take_member(const std::string& to, const std::string& from) {
    const std::string* list = symbols_.find(from);
    if (list == nullptr || ascii::trimmed(*list).empty()) return 0;
    const std::string items = *list;
    const auto comma = items.find(',');
    symbols_.owner(from)[from] = comma == std::string::npos ? std::string() : items.substr(comma + 1);
    symbols_.owner(to)[to] = std::string(ascii::trimmed(std::string_view(items).substr(0, comma)));
    return 1;
  }

  const SubstituteScopes& symbols_;
};

std::vector<std::string> split_arguments(std::string_view text) {
  std::vector<std::string> out;
  bool quoted = false;
  std::size_t start = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && text[i] == '"') quoted = !quoted;
    if (i == text.size() || (text[i] == ',' && !quoted && !(i > start && text[i - 1] == '\''))) {
      out.emplace_back(ascii::trimmed(text.substr(start, i - start)));
      start = i + 1;
    }
  }
  return out;
}

}  // namespace

std::string substitute(const std::string& text, const Substitutes& symbols, bool nested) {
  return symbols.empty() ? text : Substitution(symbols, nested).line(text, 0);
}

std::string substitute_forced(const std::string& text, const Substitutes& symbols, bool nested) {
  return symbols.empty() ? text : Substitution(symbols, nested).line(text, 0, false);
}

const std::string* SubstituteScopes::find(std::string_view name) const {
  for (const Substitutes* scope : {parameters, globals}) {
    if (scope == nullptr) continue;
    if (const auto found = scope->find(name); found != scope->end()) return &found->second;
  }
  return nullptr;
}

Substitutes& SubstituteScopes::owner(std::string_view name) const {
  return parameters != nullptr && parameters->contains(name) ? *parameters : *globals;
}

std::string replace_functions(std::string_view text, std::size_t code, const SubstituteScopes& symbols) {
  static constexpr std::array<std::string_view, 9> names{"$symlen",   "$symcmp", "$firstch", "$lastch", "$isdefed",
                                                         "$ismember", "$iscons", "$isname",  "$isreg"};
  std::string out;
  std::size_t at = 0;
  bool quoted = false;
  // A character constant and a text in quotes are taken as they are.
  const auto pass = [&](std::size_t from) {
    if (quoted && text[from] == '\\') return std::min(from + 2, code);
    quoted ^= text[from] == '"';
    return from + (quoted ? 1 : std::max<std::size_t>(1, character_constant(text.substr(from, code - from))));
  };
  while (at < code) {
    const auto name = lower(name_at(text, at, is_identifier));
    const std::size_t open = at + name.size();
    if (quoted || std::ranges::find(names, name) == names.end() || open >= code || text[open] != '(') {
      const std::size_t next = quoted || name.empty() ? pass(at) : open;
      out += text.substr(at, next - at);
      at = next;
      continue;
    }
    std::size_t close = open;
    while (close < code && (quoted || text[close] != ')')) close = pass(close);
    if (close >= code) throw LineError{open, "')' expected"};
    const auto number = Functions(symbols).call(name, split_arguments(text.substr(open + 1, close - open - 1)));
    if (!number) throw LineError{at, fmt::format("wrong number of arguments for {}", name)};
    out += std::to_string(*number);
    at = close + 1;
  }
  return out.append(text.substr(code));
}

}  // namespace toolchain
