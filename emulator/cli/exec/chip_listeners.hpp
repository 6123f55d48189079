#pragma once
// What `exec` watches of a chip, alone or in a network, and the text that it prints.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "c40/chip/chip.hpp"
#include "cli/arguments/options.hpp"
#include "machine/boards/board_reserved.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

class ChipListeners {
 public:
  /// Construct this while the chip is at its program's entry.
  /// \param number of the chip in a network, else 0
  /// \param trace the file for the chip's instructions, if any
  /// \throws InputError for a --pipeline that is not FIRST:LAST
  ChipListeners(const c40::Chip& chip, const toolchain::Image& image, const ExecOptions& options, unsigned number,
                const std::optional<std::string>& trace);
  ~ChipListeners();

  /// For the chip; null if there is no listener.
  c40::TraceSink* sink() const;
  /// Writes the files that the options name.
  void run_ended();
  /// Empty without --check.
  std::string checks_text() const;
  /// Profile and pipeline.
  std::string text() const;
  void add_to(nlohmann::ordered_json& out) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Registers that differ from their value after reset, with their fields, and the words in the FIFOs.
std::string peripherals_text(const c40::Chip& chip);
/// Adds every register by name, with its fields.
void add_peripherals(const c40::Chip& chip, nlohmann::ordered_json& out);
/// Adds FIFO contents and word counts of each port.
void add_ports(const c40::Chip& chip, nlohmann::ordered_json& out);
/// `reserved`: the accesses that a board ignores. Adds nothing for a board on which such accesses are faults.
void add_reserved(const machine::IgnoredAccesses& ignored, nlohmann::ordered_json& out);

}  // namespace cli
