#pragma once
// Networks as TOML files describe them (docs/networks.md).
#include <string>
#include <vector>

#include "machine/network.hpp"

namespace cli {

/// \throws InputError, machine::NetworkError, machine::BoardError and what read_program() throws; the file's own errors name its line.
machine::NetworkDescription read_network(const std::string& path, const std::vector<std::string>& include_directories);

}  // namespace cli
