#pragma once
// The page itself: one HTML file that fetches nothing, with a recording inside.
#include <string>
#include <string_view>

namespace page {

/// The page that the build embeds (page/dist/page.html), with this recording.
/// \param title of the window, any text in UTF-8
std::string html(std::string_view recording, std::string_view title);

}  // namespace page
