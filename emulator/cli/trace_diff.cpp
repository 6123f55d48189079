// emulator trace-diff: where two traces part.
#include <fmt/format.h>

#include <charconv>
#include <fstream>

#include "cli/options.hpp"
#include "cmrc/simulation.hpp"
#include "io/print.hpp"
#include "machine/instruction_trace.hpp"
#include "machine/machine.hpp"
#include "report/trace_text.hpp"

namespace cli {
namespace {

/// Cycles behind one hash of a golden trace: 0.1 ms of a C40-50.
constexpr c40::Cycles cycles_per_hash = 2500;

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

/// The line stands for the hash of a stretch of instructions.
bool is_hash(const report::TraceLine& line) {
  for (const auto& [name, value] : line.fields)
    if (name == "sha256") return true;
  return false;
}

/// What this emulator executes in the stretch, in full.
void regenerate(const report::TraceLine& line, unsigned dsps) {
  const auto slot = number_after(line.who, "dsp ");
  c40::Cycles from = 0;
  std::from_chars(line.when.data(), line.when.data() + line.when.size(), from);
  if (!slot || *slot >= dsps) return;
  cmrc::ConfigBuilder builder;
  builder.set("machine.dsps", std::int64_t{dsps}, {.name = "trace"});
  cmrc::Simulation simulation(builder.build());
  machine::InstructionText text(
      *slot, [](const std::string& instruction) { io::print("{}\n", instruction); }, from, from + cycles_per_hash,
      machine::Labels::of_dock(simulation.image()));
  simulation.trace(*slot, text);
  io::print("what this emulator executes there:\n");
  simulation.run_until(simulation.machine().chip_clock().at(from + cycles_per_hash));
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
  const report::TraceLine& line = difference->right ? *difference->right : *difference->left;
  if (is_hash(line))
    if (const auto dsps = dsps_of_scene(options.right)) regenerate(line, *dsps);
  return run_failed;
}

}  // namespace cli
