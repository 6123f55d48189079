#include "page/html.hpp"

#include <stdexcept>

#include "page/columns.hpp"
#include "page/embedded.hpp"

namespace page {
namespace {

/// Escapes the text: none of it is markup. A character that cannot be shown becomes a space.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
    }
  }
  return out;
}

void replace(std::string& text, std::string_view mark, std::string_view by) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) throw std::logic_error("page.html has no " + std::string(mark));
  text.replace(at, mark.size(), by);
}

}  // namespace

std::string html(std::string_view recording, std::string_view title) {
  std::string text(embedded_page());
  // The recording's mark is replaced last: the recording is base64 and contains no mark.
  replace(text, "@RECORDING@", base64(recording));
  replace(text, "@TITLE@", escaped(title));
  return text;
}

}  // namespace page
