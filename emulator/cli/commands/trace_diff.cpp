// emulator trace-diff: the first difference of two traces.
#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "cli/arguments/options.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/run/simulation.hpp"
#include "io/print.hpp"
#include "machine/program_text/instruction_trace.hpp"
#include "machine/system/machine.hpp"
#include "report/events/event_log.hpp"
#include "report/events/trace_text.hpp"
#include "state/sha256.hpp"

namespace cli {
namespace {

/// Cycles covered by one hash of a golden trace: 0.1 ms of a C40-50.
constexpr c40::Cycles cycles_per_hash = 2500;
constexpr std::size_t digits_of_hash = 16;

std::ifstream open(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(fmt::format("{}: no such file, or it cannot be read", path));
  return in;
}

std::optional<unsigned> number_after(std::string_view text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return std::nullopt;
  text.remove_prefix(prefix.size());
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} ? std::optional(value) : std::nullopt;
}

/// The comment `# emulator --dsps N` of a scene's trace.
std::optional<unsigned> dsps_of_scene(const std::string& path) {
  std::ifstream in = open(path);
  std::string line;
  while (std::getline(in, line) && line.starts_with('#'))
    if (const auto dsps = number_after(line, "# emulator --dsps ")) return dsps;
  return std::nullopt;
}

/// The hash in a line that stands for a part of the instructions.
std::optional<std::string> hash_of(const std::optional<report::TraceLine>& line) {
  if (line)
    for (const auto& [name, value] : line->fields)
      if (name == "sha256") return value;
  return std::nullopt;
}

/// Prints the instructions of this part in full, if one of the traces has their hash. Else says what the reader can do.
void regenerate(const report::TraceDifference& difference, const TraceDiffOptions& options) {
  const report::TraceLine& line = difference.right ? *difference.right : *difference.left;
  const auto left = hash_of(difference.left), right = hash_of(difference.right);
  if (!left && !right) return;
  const auto dsps = dsps_of_scene(options.right);
  if (!dsps) {
    io::print(
        "instructions behind a hash can be printed for a scene's trace only: one with a comment `# emulator --dsps "
        "N`\n");
    return;
  }
  const auto slot = number_after(line.who, "dsp ");
  c40::Cycles from = 0;
  std::from_chars(line.when.data(), line.when.data() + line.when.size(), from);
  if (!slot || *slot >= *dsps)
    throw InputError(fmt::format("{}: line {}: {} in a scene of {} DSPs", options.right, line.number, line.who, *dsps));
  cmrc::ConfigBuilder builder;
  builder.set("machine.dsps", std::int64_t{*dsps}, {.name = "trace"});
  if (options.programs) builder.set("machine.programs", *options.programs, {.name = "--programs"});
  cmrc::Simulation simulation(builder.build());
  std::string executed, hashed;
  machine::InstructionText text(
      *slot,
      [&](const std::string& instruction) {
        executed += instruction + '\n';
        hashed += report::without_operands(instruction) + '\n';
      },
      [from](c40::Cycles cycle) { return from <= cycle && cycle < from + cycles_per_hash; },
      machine::Labels::of_dock(simulation.image()));
  simulation.trace(*slot, text);
  simulation.run_until(simulation.machine().chip_clock().at(from + cycles_per_hash));
  const std::string hash = state::sha256(hashed).substr(0, digits_of_hash);
  if (hash != left && hash != right)
    return io::print(stderr,
                     "error: this emulator executes other instructions there (sha256 {}) than both traces: the traces "
                     "were made with other programs (--programs DIR takes programs of a directory), with other options "
                     "than --dsps {}, or by another version\n",
                     hash, *dsps);
  io::print("instructions that this emulator executes there, equal to those of {}:\n{}",
            hash == left ? options.left : options.right, executed);
}

}  // namespace

int trace_diff(const TraceDiffOptions& options) {
  std::ifstream left = open(options.left);
  std::ifstream right = open(options.right);
  std::optional<report::TraceDifference> difference;
  try {
    difference = report::compare_traces(left, right);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("{} and {}: {}", options.left, options.right, error.what()));
  }
  if (!difference) {
    io::print("no difference\n");
    return success;
  }
  io::print("first difference: {}", difference->message());
  regenerate(*difference, options);
  return run_failed;
}

}  // namespace cli
