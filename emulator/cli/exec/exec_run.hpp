#pragma once
// How exec runs one chip: conditions for the end of the run, and why the run ended.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments/options.hpp"
#include "cli/exec/board_front.hpp"
#include "machine/boards/board_devices.hpp"
#include "machine/boards/board_reserved.hpp"
#include "machine/chips/boot.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

struct Outcome {
  /// "until", "halt", "idle", "limit", "external_access", "port_wait", "dma_wait", "fault", "interrupted"
  std::string reason;
  std::string message;
  int status = success;
};

/// The conditions for the end of a run; the first one that is met ends it.
struct Until {
  std::vector<toolchain::Address> pcs;
  /// Words of memory and their expected values, compared after each instruction.
  std::vector<std::pair<toolchain::Address, toolchain::Word>> words;
};
/// The conditions of all --until. \throws InputError
Until parse_until(const ExecOptions& options, const toolchain::Image& image);

/// What is connected to the chip.
struct Connected {
  std::optional<machine::BootFeeder> feeder;  ///< feeds the port from which the chip boots
  BoardConsole& front;
  machine::LoneDevices& devices;
  machine::IgnoredAccesses& ignored;
  std::optional<toolchain::Address> stream{};  ///< where the boot loader reads, if it reads memory
};

/// Stops at a branch to itself, at an IDLE that nothing can end, and where `until` or --cycles say.
Outcome run(c40::Chip& chip, const Until& until, const ExecOptions& options, Connected& connected);

}  // namespace cli
