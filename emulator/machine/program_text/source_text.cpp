#include "machine/program_text/source_text.hpp"

#include <algorithm>
#include <string_view>

#include "isa/disassemble.hpp"

namespace machine {
namespace {

std::string tidy(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, text.find(';'))) {
    const bool blank = c == ' ' || c == '\t';
    if (!blank)
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  }
  if (out.ends_with(' ')) out.pop_back();
  return out;
}

/// A label begins in the first column, or has a colon.
std::string_view without_label(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  const std::size_t end = std::min(text.find_first_of(" \t:;", first), text.size());
  const bool colon = end < text.size() && text[end] == ':';
  return first == 0 || colon ? text.substr(std::min(end + (colon ? 1 : 0), text.size())) : text;
}

}  // namespace

SourceText::SourceText(const toolchain::Image& image, Label label) {
  for (const toolchain::LineRecord& line : image.lines) {
    std::string text = tidy(label == Label::kept ? line.text : without_label(line.text));
    if (!line.second.empty()) text += " " + tidy(line.second);
    lines_[line.address] = std::move(text);
  }
}

std::string SourceText::operator()(isa::Address address, isa::Word word,
                                   const std::function<std::string(isa::Address)>& symbols) const {
  const auto line = lines_.find(address);
  return line == lines_.end() || line->second.empty() ? isa::disassemble(word, address, symbols) : line->second;
}

}  // namespace machine
