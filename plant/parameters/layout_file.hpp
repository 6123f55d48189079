#pragma once
// A dock's layout as TOML (docs/layout.md).
#include <stdexcept>
#include <string>
#include <string_view>

#include "io/text_error.hpp"
#include "plant/parameters/config.hpp"

namespace plant {

// The text gives file, line and column, what is wrong, and what would be right.
struct LayoutError : io::TextError<std::runtime_error> {
  using TextError::TextError;
};

// Changes the values that the text names; the rest of the dock stays. Lanes come from `[[lanes]]`, or are the default
// loop around the new spot and warehouse. Throws LayoutError.
void apply_layout(DockConfig&, std::string_view text, const std::string& name);
void load_layout(DockConfig&, const std::string& path);

}  // namespace plant
