#pragma once
// page/dist/page.html, embedded by the build (page/embed.cmake).
#include <string_view>

namespace page {

std::string_view embedded_page();

}  // namespace page
