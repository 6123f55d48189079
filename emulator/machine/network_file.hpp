#pragma once
// Networks as TOML files describe them (docs/networks.md).
#include <functional>
#include <string>

#include "machine/network.hpp"

namespace machine {

/// Reads a program by the path that the file gives it, which is relative to the file.
using ProgramReader = std::function<toolchain::Image(const std::string& path)>;

/// \throws NetworkError and BoardError, which name file and line, and what the reader throws.
NetworkDescription read_network(const std::string& path, const ProgramReader& read_program);

}  // namespace machine
