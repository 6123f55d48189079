#pragma once
// A chip's profile beside its program: tables, annotated source, JSON.
#include <nlohmann/json_fwd.hpp>

#include "c40/profile.hpp"
#include "toolchain/image.hpp"

namespace cli {

void print_profile(const c40::Profile& profile, const c40::Chip& chip, const toolchain::Image& image);
nlohmann::ordered_json profile_json(const c40::Profile& profile, const c40::Chip& chip, const toolchain::Image& image);

}  // namespace cli
