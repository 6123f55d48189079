#pragma once
// How exec runs its one chip: what it is to come to, and why it ended.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/board_front.hpp"
#include "cli/options.hpp"
#include "machine/board_devices.hpp"
#include "machine/board_reserved.hpp"
#include "machine/boot.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

struct Outcome {
  /// "until", "halt", "idle", "limit", "external_access", "port_wait", "dma_wait", "fault", "interrupted"
  std::string reason;
  std::string message;
  int status = success;
};

/// What a run is to come to: what is met first ends it.
struct Until {
  std::vector<toolchain::Address> pcs;
  /// Words of memory, and what they are to hold: looked at after each instruction.
  std::vector<std::pair<toolchain::Address, toolchain::Word>> words;
};
/// Of all --until. \throws InputError
Until parse_until(const ExecOptions& options, const toolchain::Image& image);

/// What stands around the chip.
struct Surroundings {
  std::optional<machine::BootFeeder> feeder;  ///< of the port through which it boots
  BoardConsole& front;
  machine::LoneDevices& devices;
  machine::IgnoredAccesses& ignored;
  std::optional<toolchain::Address> stream{};  ///< where the boot loader reads, if it reads memory
};

/// Stops at a branch to itself, at an IDLE that nothing can end, and where `until` or --cycles say.
Outcome run(c40::Chip& chip, const toolchain::Image& image, const Until& until, const ExecOptions& options,
            Surroundings& around);

}  // namespace cli
