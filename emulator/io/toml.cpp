#include "io/toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace io {
namespace {

/// Looks at brackets and dots only; the parser finds everything else that is not TOML.
class Nesting {
 public:
  Nesting(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  void check() {
    while (at_ < text_.size()) {
      switch (const char c = text_[at_]) {
        case '#': at_ = std::min(text_.find('\n', at_), text_.size()); continue;
        case '"':
        case '\'': skip_string(c); continue;
        case '[':
        case '{': dots_ = 0, one_more(depth_, "brackets are nested"); break;
        case ']':
        case '}': dots_ = 0, depth_ = std::max(0, depth_ - 1); break;
        case ',':
        case '=':
        case '\n': dots_ = 0; break;
        case '.': one_more(dots_, "dots are in a key"); break;
        default: break;
      }
      ++at_;
    }
  }

 private:
  void one_more(int& count, const char* what) const {
    if (++count <= deepest_toml) return;
    const std::string_view before = text_.substr(0, at_);
    const auto line = static_cast<toml::source_index>(1 + std::count(before.begin(), before.end(), '\n'));
    const auto column = static_cast<toml::source_index>(at_ - (before.rfind('\n') + 1) + 1);
    const std::string message = fmt::format("more than {} {}; a flatter file is expected", deepest_toml, what);
    throw toml::parse_error(message.c_str(), toml::source_position{line, column},
                            std::make_shared<const std::string>(name_));
  }

  // Skips to after the string's end: three quotes, with up to two quotes before them, or one in the same line.
  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool many = text_.substr(at_, 3) == three;
    at_ += many ? 3 : 1;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\\' && quote == '"') {
        ++at_;
      } else if (many && text_.substr(at_, 3) == three) {
        at_ += 3;
        for (int more = 0; more < 2 && at_ < text_.size() && text_[at_] == quote; ++more) ++at_;
        return;
      } else if (!many && (text_[at_] == quote || text_[at_] == '\n')) {
        at_ += text_[at_] == quote ? 1 : 0;
        return;
      }
    }
    at_ = text_.size();
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  int depth_ = 0, dots_ = 0;
};

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& name) {
  Nesting(text, name).check();
  return toml::parse(text, name);
}

}  // namespace io
