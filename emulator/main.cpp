// The start of the program: cli/arguments/command_line.cpp reads the arguments, cli/ has the commands.
#include <exception>
#include <functional>

#include "cli/arguments/command_line.hpp"
#include "cmrc/configuration/config.hpp"
#include "io/file_roles.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/reason.hpp"
#include "io/signals.hpp"
#include "io/standard_streams.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/networks/network.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/linker/memory_map.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/missing_symbol.hpp"
#include "toolchain/objects/rom_file.hpp"
#include "toolchain/syntax/diagnostics.hpp"

namespace {

using Action = std::function<int()>;

/// Executes the requested command.
struct Perform {
  int operator()(const cli::RunOptions& options) const { return cli::run(options); }
  int operator()(const cli::ConfigOptions& options) const { return cli::print_config(options); }
  int operator()(const cli::CmrcCommandOptions& options) const { return cli::cmrc_command(options); }
  int operator()(const cli::CompareOptions& options) const { return cli::compare(options); }
  int operator()(const cli::AssembleOptions& options) const { return cli::assemble(options); }
  int operator()(const cli::DisassembleOptions& options) const { return cli::disassemble(options); }
  int operator()(const cli::LinkOptions& options) const { return cli::link(options); }
  int operator()(const cli::ClassifyOptions& options) const { return cli::classify(options); }
  int operator()(const cli::ImageOptions& options) const { return cli::image(options); }
  int operator()(const cli::ExecOptions& options) const { return cli::exec(options); }
  int operator()(const cli::DebugOptions& options) const { return cli::debug(options); }
  int operator()(const cli::DapOptions& options) const { return cli::dap(options); }
  int operator()(const cli::TraceDiffOptions& options) const { return cli::trace_diff(options); }
  int operator()(const cli::VectorOptions& options) const { return cli::vectors(options); }
};

/// Performs the action; if it fails, prints one message on standard error.
int guarded(const Action& action) {
  const auto fail = [](const char* message, int status) {
    io::print(stderr, "emulator: {}\n", message);
    return status;
  };
  try {
    return action();
  } catch (const cli::InputError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const io::CannotOpen& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const io::SameFile& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const machine::NetworkError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const machine::BoardError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const cmrc::ConfigError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::AssemblyError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::WrongProcessor& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::MissingSymbol& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::CoffError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::LinkError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::MemoryMapError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const toolchain::RomError& error) {
    return fail(error.what(), cli::bad_input);
  } catch (const std::exception& error) {
    return fail(io::reason(error), cli::run_failed);
  }
}

/// A lost output file and lost printed text make the command fail.
int written(int status) {
  for (const std::string& lost : io::lost_outputs()) io::print(stderr, "emulator: {}\n", lost);
  const std::string lost = io::flush_output();
  if (!lost.empty()) io::print(stderr, "emulator: standard output: writing failed: {}\n", lost);
  return status == cli::success && !(lost.empty() && io::lost_outputs().empty()) ? cli::run_failed : status;
}

}  // namespace

int main(int argc, char** argv) {
  io::take_closed_streams();
  io::take_signals();
  return written(guarded([&] {
    const std::variant<cli::Request, cli::Help> asked = cli::parse_command_line(argc, argv);
    if (const auto* help = std::get_if<cli::Help>(&asked)) {
      io::print("{}", help->text);
      return cli::success;
    }
    return std::visit(Perform{}, std::get<cli::Request>(asked));
  }));
}
