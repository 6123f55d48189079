#pragma once
// Boards as `exec --board` names them.
#include <optional>
#include <string>

#include "c40/memory.hpp"

namespace cli {

/// What --board chose, and what the board file says about the chip itself.
struct ChosenBoard {
  c40::Board board;
  std::optional<double> clock_mhz;  ///< CLKIN; an H1 period is two of its periods.
};

/// "default", "flat", or a TOML file (docs/configuration.md). \throws InputError naming the key.
ChosenBoard read_board(const std::string& name);

}  // namespace cli
