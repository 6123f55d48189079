#pragma once
// The arguments of the command `emulator` (docs/cli.md).
#include <string>
#include <variant>

#include "cli/arguments/options.hpp"

namespace cli {

/// One command with its options.
using Request = std::variant<RunOptions, ConfigOptions, CmrcCommandOptions, CompareOptions, AssembleOptions,
                             DisassembleOptions, LinkOptions, ClassifyOptions, ImageOptions, ExecOptions, DebugOptions,
                             DapOptions, TraceDiffOptions, VectorOptions>;
/// What --help prints.
struct Help {
  std::string text;
};

/// Reads the arguments; opens no file. \throws InputError
std::variant<Request, Help> parse_command_line(int argc, const char* const* argv);

}  // namespace cli
