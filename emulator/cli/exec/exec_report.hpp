#pragma once
// The result of exec for one chip, after the run.
#include <optional>
#include <utility>
#include <vector>

#include "cli/exec/board_front.hpp"
#include "cli/exec/chip_listeners.hpp"
#include "cli/exec/exec_run.hpp"
#include "machine/boards/board_reserved.hpp"

namespace cli {

struct Dump {
  toolchain::Address address;
  std::vector<toolchain::Word> words;
};

/// ADDRESS:COUNT of --dump. \throws InputError
std::pair<toolchain::Address, toolchain::Address> parse_dump(const std::string& text, const toolchain::Image& image);
/// \throws InputError that begins with `what` for an address that is not in memory
Dump read_dump(const c40::Chip& chip, toolchain::Address address, toolchain::Address count,
               std::string_view what = "--dump");

struct ExecReport {
  const c40::Chip& chip;
  const Outcome& outcome;
  std::vector<Dump> dumps;
  const ChipListeners& listeners;
  std::optional<double> clock_mhz;
  bool peripherals = false;
  const BoardConsole& front;
  const machine::IgnoredAccesses& ignored;
};
void print_text(const ExecReport& report);
void print_json(const ExecReport& report);

}  // namespace cli
