#pragma once
// Values to be tried, as typed: "1:3:0.25" (from, to, step) or "1,1.5,4".
#include <string>
#include <vector>

namespace cli {

/// Exact to millionths, by no accumulated step. \throws InputError naming the option
std::vector<double> parse_grid(const std::string& text, const std::string& option);

}  // namespace cli
