#pragma once
// Networks from TOML files (docs/networks.md).
#include <functional>
#include <string>

#include "machine/networks/network.hpp"

namespace machine {

/// Reads a program; its path in the file is relative to the file.
using ProgramReader = std::function<toolchain::Image(const std::string& path)>;

/// \throws NetworkError and BoardError, which name file and line, and the reader's errors.
NetworkDescription read_network(const std::string& path, const ProgramReader& read_program);

}  // namespace machine
