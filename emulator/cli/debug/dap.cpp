// emulator dap: the Debug Adapter Protocol (docs/dap.md).
#include <fmt/format.h>
#include <unistd.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/debug/debug_target.hpp"
#include "debugger/dap_server.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"

namespace cli {
namespace {

/// A key of `launch` whose value is a text or a list of texts.
std::vector<std::string> texts_of(const debugger::dap::Json& arguments, const char* key) {
  const auto found = arguments.find(key);
  if (found == arguments.end() || found->is_null()) return {};
  if (found->is_string()) return {found->get<std::string>()};
  if (found->is_array() &&
      std::all_of(found->begin(), found->end(), [](const debugger::dap::Json& one) { return one.is_string(); }))
    return found->get<std::vector<std::string>>();
  throw InputError(fmt::format("launch: {}: a text, or a list of texts, is expected", key));
}

std::optional<std::string> text_of(const debugger::dap::Json& arguments, const char* key) {
  const std::vector<std::string> all = texts_of(arguments, key);
  if (all.size() > 1) throw InputError(fmt::format("launch: {}: one text is expected", key));
  return all.empty() ? std::nullopt : std::optional(all.front());
}

template <class Number>
std::optional<Number> number_of(const debugger::dap::Json& arguments, const char* key) {
  const auto found = arguments.find(key);
  if (found == arguments.end() || found->is_null()) return std::nullopt;
  if (!found->is_number()) throw InputError(fmt::format("launch: {}: a number is expected", key));
  return found->get<Number>();
}

/// The keys have the meaning of the options of `emulator debug`.
DebugOptions options_of(const debugger::dap::Json& arguments) {
  DebugOptions options;
  ExecOptions& exec = options.exec;
  exec.programs = texts_of(arguments, "program");
  exec.network = text_of(arguments, "network");
  exec.boards = texts_of(arguments, "board");
  exec.links = texts_of(arguments, "link");
  exec.nets = texts_of(arguments, "net");
  exec.actions = texts_of(arguments, "action");
  exec.include_directories = texts_of(arguments, "include");
  exec.topology = text_of(arguments, "topology");
  exec.dialect = text_of(arguments, "dialect");
  exec.entry = text_of(arguments, "entry");
  exec.load_at = text_of(arguments, "loadAt");
  exec.until = texts_of(arguments, "until");
  exec.boot = text_of(arguments, "boot");
  exec.roms = texts_of(arguments, "rom");
  exec.rom_width = number_of<unsigned>(arguments, "romWidth");
  exec.loads = texts_of(arguments, "load");
  exec.pokes = texts_of(arguments, "poke");
  exec.console_input = text_of(arguments, "consoleInput");
  exec.device_inputs = texts_of(arguments, "deviceInput");
  exec.device_scripts = texts_of(arguments, "deviceScript");
  RunOptions& run = options.run;
  run.config = text_of(arguments, "config");
  run.preset = text_of(arguments, "preset");
  run.settings = texts_of(arguments, "set");
  run.resume = text_of(arguments, "snapshot");
  run.dsps = number_of<std::int64_t>(arguments, "dsps");
  run.duration_s = number_of<double>(arguments, "duration");
  run.seed = number_of<std::int64_t>(arguments, "seed");
  return options;
}

debugger::dap::Launched launch(const debugger::dap::Json& arguments) {
  auto target = std::make_shared<DebugTarget>(debug_target(options_of(arguments)));
  return {target, target->debuggee.get()};
}

}  // namespace

int dap(const DapOptions& options) {
  if (!options.port) {
    // Standard output carries the protocol: other output must not get between its messages.
    const int out = dup(STDOUT_FILENO);
    dup2(STDERR_FILENO, STDOUT_FILENO);
    const debugger::dap::Ended ended = debugger::dap::serve(STDIN_FILENO, out, launch);
    close(out);
    if (!ended.broken.empty()) throw InputError(fmt::format("dap: {}", ended.broken));
    return success;
  }
  try {
    debugger::dap::Listener listener(*options.port);
    io::print("emulator dap: listening on port {} of this machine\n", listener.port());
    std::fflush(stdout);
    for (;;) {
      const int client = listener.accept();
      if (client < 0) return success;
      const debugger::dap::Ended ended = debugger::dap::serve(client, client, launch);
      close(client);
      if (!ended.broken.empty()) io::print(stderr, "emulator dap: {}\n", ended.broken);
    }
  } catch (const std::system_error& error) {
    throw InputError(fmt::format("--listen: {}", error.what()));
  }
}

}  // namespace cli
