#pragma once
/// The way most emulators work, for comparison only: fetch a word, decode it, switch. No timing, no causes, no guards;
/// only the instructions of the three kernels of tests/toolchain/bench. The arithmetic is the core's own (float40), so
/// that it costs the same.
#include <array>
#include <cstdint>
#include <vector>

#include "c40/values/float40.hpp"

namespace c40::bench {

class PlainInterpreter {
 public:
  PlainInterpreter();
  void load(std::uint32_t address, const std::vector<std::uint32_t>& words);
  /// Executes this number of instructions. \throws std::runtime_error at an instruction that it does not know
  void run(std::uint32_t start, std::uint64_t instructions);
  std::uint32_t integer(unsigned code) const { return r_[code]; }

 private:
  std::uint32_t& word(std::uint32_t address) { return memory_[address & mask]; }
  std::uint32_t general_address(std::uint32_t w);
  std::uint32_t byte_address(std::uint32_t byte);
  std::uint32_t address(unsigned modn, unsigned ar, std::uint32_t step);
  std::uint32_t general_integer(std::uint32_t w, bool zero_extended);
  Float40 general_float(std::uint32_t w);
  Float40 three_float(std::uint32_t byte, bool memory, bool type2);
  Float40 float_register(unsigned code) const { return {e_[code], r_[code]}; }
  void set_float(unsigned code, const FloatResult& result, bool flags = true);
  void add(unsigned dst, std::uint32_t a, std::uint32_t b);
  void subtract(unsigned dst, std::uint32_t a, std::uint32_t b, bool write);
  bool holds(unsigned condition) const;
  void general(std::uint32_t w);
  void three_operands(std::uint32_t w);
  void parallel(std::uint32_t w);
  std::uint64_t repeat(std::uint32_t w, std::uint64_t passes);
  [[noreturn]] void unknown(std::uint32_t w) const;

  static constexpr std::uint32_t mask = 0x3FFFFF;
  std::vector<std::uint32_t> memory_;
  std::array<std::uint32_t, 32> r_{};
  std::array<std::int32_t, 32> e_{};
  bool c_ = false, v_ = false, z_ = false, n_ = false, uf_ = false, lv_ = false, luf_ = false;
  std::uint32_t pc_ = 0;
};

}  // namespace c40::bench
