// Emulated instructions per second of the core on one program: c40_bench FILE.hex [MILLIONS] [--exact]
// The file holds one word per line; it is loaded and started at 1000h of board flat.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "c40/chip.hpp"

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: c40_bench FILE.hex [MILLIONS OF CYCLES] [--exact]\n");
    return 2;
  }
  std::ifstream file(argv[1]);
  std::vector<c40::Word> words;
  for (std::string line; file >> line;) words.push_back(static_cast<c40::Word>(std::stoul(line, nullptr, 16)));
  const c40::Cycles cycles = (argc > 2 ? std::atoll(argv[2]) : 100) * 1000000;
  c40::Chip chip(c40::Board::flat());
  chip.write_block(0x1000, words);
  chip.set_pc(0x1000);
  chip.set_exact(argc > 3 && std::string(argv[3]) == "--exact");
  const auto begin = std::chrono::steady_clock::now();
  const c40::StopInfo stop = chip.run_until(cycles);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  if (stop.fault) fmt::print("stopped at {:08X}h: {}\n", stop.fault->pc, stop.fault->message);
  const auto& causes = chip.causes();
  c40::Cycles sum = 0;
  for (c40::Cycles cause : causes) sum += cause;
  fmt::print("{:.1f} million instructions/s ({} instructions, {} cycles, causes {}, {:.3f} s)\n",
             static_cast<double>(chip.instructions()) / elapsed.count() / 1e6, chip.instructions(), chip.cycle(),
             sum == chip.cycle() ? "complete" : "INCOMPLETE", elapsed.count());
  return 0;
}
