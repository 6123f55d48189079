#pragma once
// What `exec` was asked to watch of a chip, alone or in a network, and how it is told.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "c40/chip.hpp"
#include "cli/options.hpp"
#include "machine/board_reserved.hpp"
#include "toolchain/objects/image.hpp"

namespace cli {

class ChipListeners {
 public:
  /// The chip stands at its program's entry.
  /// \param number of the chip in a network, else 0
  /// \param trace the file for its instructions, if any
  /// \throws InputError for a --pipeline that is none
  ChipListeners(const c40::Chip& chip, const toolchain::Image& image, const ExecOptions& options, unsigned number,
                const std::optional<std::string>& trace);
  ~ChipListeners();

  /// To be given to the chip; null: nobody listens.
  c40::TraceSink* sink() const;
  /// Writes what belongs into files.
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
/// Every register by name, with its fields.
void add_peripherals(const c40::Chip& chip, nlohmann::ordered_json& out);
/// FIFO contents and word counts of each port.
void add_ports(const c40::Chip& chip, nlohmann::ordered_json& out);
/// `reserved`: the accesses that a board ignores; nothing of a board where they are faults.
void add_reserved(const machine::IgnoredAccesses& ignored, nlohmann::ordered_json& out);

}  // namespace cli
