#pragma once
// The outside of a board's devices: files, standard input, the terminal (docs/boards.md).
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments/options.hpp"
#include "io/file_roles.hpp"
#include "io/output_file.hpp"
#include "machine/boards/board_devices.hpp"
#include "machine/boards/board_file.hpp"

namespace cli {

/// Each chip's name, and the board whose devices the chip has.
using NamedBoards = std::vector<std::pair<std::string, machine::BoardDescription*>>;

/// Gives the devices what --console-input, --device-input and --device-script say. \throws InputError
void add_inputs(const NamedBoards& boards, const ExecOptions& options);
/// The option of these that reads standard input, with its argument: - , live for the console, or a name of that file.
std::optional<std::string> reader_of_standard_input(const ExecOptions& options);
/// Registers the files of these options and those of --device-output and --console-record.
void add_device_files(const ExecOptions& options, io::FileRoles& files);

/// Writes what devices send to files and to the terminal; gives live input to the console.
class BoardConsole {
 public:
  /// \param boards the chips' names and devices; a null pointer: the chip has none. The devices must outlive this
  /// object.
  /// \param shows prints the characters of a console on standard output at once; of one chip only
  BoardConsole(std::vector<std::pair<std::string, machine::BoardDevices*>> boards, const ExecOptions& options,
               bool shows);

  /// Standard input goes to the console while the program runs (--console-input live).
  bool is_live() const { return live_ != nullptr; }
  bool may_be_typed() const { return is_live() && !at_end_; }
  /// Takes the input typed until now; the console gets it in this cycle. \param waits for a character, the end of the
  /// input, or a signal
  void listen(c40::Cycles now, bool waits = false);

  /// Writes the files. \param states the final states of the chips, for the hash
  void run_ended(const std::vector<std::string>& states);
  /// No chip has a device.
  bool empty() const;
  std::string text() const;
  /// "hash ..." over inputs and states; empty if no chip has a device.
  std::string hash_text() const;
  void add_to(nlohmann::ordered_json& root) const;

 private:
  struct Output {
    const machine::BoardDevices::Place* place;
    std::unique_ptr<io::OutputFile> file;
  };
  std::string called(const std::string& chip, const std::string& device) const;

  std::vector<std::pair<std::string, machine::BoardDevices*>> boards_;
  bool shows_;
  machine::BoardDevices* live_ = nullptr;
  bool at_end_ = false;
  std::size_t typed_characters_ = 0;
  std::vector<machine::HostStep> typed_;
  std::vector<Output> outputs_;
  std::optional<io::OutputFile> record_;
  std::string hash_;
  bool at_line_begin_ = true;
};

}  // namespace cli
