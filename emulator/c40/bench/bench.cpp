// Emulated instructions per second: c40_bench [--millions N] [--repeat N] [--exact CYCLES] FILE.hex...
// Each file has one word per line; it is loaded and started at 1000h of board flat. Three ways are compared: blocks
// (which runs use), the exact engine (which asks the pipeline model about every instruction), and a plain interpreter
// that fetches, decodes and switches. With --exact only the exact engine runs, for so many cycles, and the number of
// its instructions is printed: scripts/host_costs counts what they cost.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "c40/bench/plain_interpreter.hpp"
#include "c40/chip/chip.hpp"
#include "isa/types.hpp"

namespace {

constexpr c40::Address start = 0x1000;

struct Options {
  std::int64_t millions = 100;  // of cycles
  int repeat = 5;
  c40::Cycles exact = 0;  // only the exact engine, for so many cycles
  std::vector<std::string> files;
};

std::vector<c40::Word> read_words(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + " cannot be read");
  std::vector<c40::Word> words;
  for (std::string line; file >> line;) words.push_back(static_cast<c40::Word>(std::stoul(line, nullptr, 16)));
  return words;
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Run {
  double rate;  // millions of instructions per second
  std::uint64_t instructions;
  std::vector<std::uint64_t> registers;
};

Run run_chip(const std::vector<c40::Word>& words, c40::Cycles cycles, bool exact) {
  c40::Chip chip(c40::Board::flat());
  chip.write_block(start, words);
  chip.set_pc(start);
  chip.set_exact(exact);
  c40::StopInfo stop;
  const double elapsed = seconds_of([&] { stop = chip.run_until(cycles); });
  if (stop.fault) throw std::runtime_error(stop.fault->message);
  c40::Cycles sum = 0;
  for (const c40::Cycles cause : chip.causes()) sum += cause;
  if (sum != chip.cycle()) throw std::runtime_error("the causes do not add up to the cycles");
  Run run{static_cast<double>(chip.instructions()) / elapsed / 1e6, chip.instructions(), {}};
  for (const auto reg :
       {isa::Register::R0, isa::Register::R2, isa::Register::R5, isa::Register::AR0, isa::Register::AR3})
    run.registers.push_back(chip.register_value(reg) & 0xFFFFFFFF);
  return run;
}

Run run_plain(const std::vector<c40::Word>& words, std::uint64_t instructions) {
  c40::bench::PlainInterpreter plain;
  plain.load(start, words);
  const double elapsed = seconds_of([&] { plain.run(start, instructions); });
  Run run{static_cast<double>(instructions) / elapsed / 1e6, instructions, {}};
  for (const unsigned code : {0U, 2U, 5U, 8U, 11U}) run.registers.push_back(plain.integer(code));
  return run;
}

double median(std::vector<double> rates) {
  std::ranges::sort(rates);
  return rates[rates.size() / 2];
}

// The three ways take turns, so that other load of the machine affects them equally.
void measure(const Options& options, const std::string& path) {
  const auto words = read_words(path);
  const c40::Cycles cycles = options.millions * 1'000'000;
  std::vector<double> blocks, exact, plain;
  for (int i = 0; i < options.repeat; ++i) {
    const Run by_blocks = run_chip(words, cycles, false);
    const Run by_exact = run_chip(words, cycles / 10, true);
    const Run by_plain = run_plain(words, by_blocks.instructions);
    if (by_plain.registers != by_blocks.registers)
      throw std::runtime_error(path + ": the interpreter and the blocks disagree");
    blocks.push_back(by_blocks.rate), exact.push_back(by_exact.rate), plain.push_back(by_plain.rate);
  }
  fmt::print("{:<12}{:>10.0f}{:>16.0f}{:>12.0f}{:>12.1f}\n", std::filesystem::path(path).stem().string(),
             median(blocks), median(exact), median(plain), median(blocks) / median(plain));
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--millions" && i + 1 < argc)
      options.millions = std::stoll(argv[++i]);
    else if (word == "--repeat" && i + 1 < argc)
      options.repeat = std::stoi(argv[++i]);
    else if (word == "--exact" && i + 1 < argc)
      options.exact = std::stoll(argv[++i]);
    else
      options.files.push_back(word);
  }
  if (options.files.empty() || options.millions < 1 || options.repeat < 1 || options.exact < 0)
    throw std::invalid_argument("usage: c40_bench [--millions N] [--repeat N] [--exact CYCLES] FILE.hex...");
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parse(argc, argv);
    if (options.exact > 0) {
      for (const std::string& file : options.files)
        fmt::print("{}\n", run_chip(read_words(file), options.exact, true).instructions);
      return 0;
    }
    fmt::print("{:<12}{:>10}{:>16}{:>12}{:>12}\n", "million/s", "blocks", "every one timed", "plain", "blocks/plain");
    for (const std::string& file : options.files) measure(options, file);
  } catch (const std::exception& error) {
    fmt::print(stderr, "c40_bench: {}\n", error.what());
    return 2;
  }
  return 0;
}
