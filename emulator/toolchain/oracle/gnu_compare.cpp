// Compares our disassembly with GNU objdump's for tic4x-coff (docs/oracles.md). A tool of the tests and campaigns.
//
//   c40_gnu_compare words COUNT SEED > FILE     random words: every other one of a random row with random fields
//   c40_gnu_compare range FIRST COUNT > FILE    consecutive words
//   c40_gnu_compare text FILE < OBJDUMP         compares; prints what differs, by class:
//                                               class <tab> count <tab> first word <tab> ours <tab> GNU's
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "isa/decode.hpp"
#include "isa/disassemble.hpp"

namespace {

using isa::Instruction;
using isa::Operand;
using isa::Word;

// Words

void put(Word word) {
  const std::array<char, 4> bytes{static_cast<char>(word), static_cast<char>(word >> 8), static_cast<char>(word >> 16),
                                  static_cast<char>(word >> 24)};
  std::cout.write(bytes.data(), bytes.size());
}

void random_words(std::uint64_t count, std::uint64_t seed) {
  std::mt19937_64 source(seed);
  const auto rows = isa::rows();
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t bits = source();
    auto word = static_cast<Word>(bits);
    if (i % 2 == 1) {
      const isa::Row& row = rows[(bits >> 32) % rows.size()];
      word = (word & ~row.bits.mask) | row.bits.match;
    }
    put(word);
  }
}

// Text

/// objdump's text of a short float: C's %f; all numbers with exponent -8 are zero.
std::string gnu_float(Word bits) {
  const int exponent = static_cast<int>(bits >> 12) - ((bits >> 12) >= 8 ? 16 : 0);
  if (exponent == -8) return "0.000000";
  const double fraction = static_cast<double>(bits & 0x7FF) / 2048.0;
  return fmt::format("{:f}", std::ldexp(((bits & 0x800) != 0 ? -2.0 : 1.0) + fraction, exponent));
}

/// Our text in objdump's conventions: no 3 at the end of mnemonics, no marks of exact fields, floats by %f, the last
/// loaded page before direct addresses.
std::string in_gnu_style(const Instruction& instruction, const std::string& ours, Word page) {
  const isa::Row& row = *instruction.row;
  const bool three = row.format == isa::Format::three_type1 || row.format == isa::Format::three_type2 || row.parallel();
  std::string out;
  bool in_mnemonic = true;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const char c = ours[i];
    if (in_mnemonic && c == ' ') {
      if (three && out.ends_with('3')) out.pop_back();
      in_mnemonic = false;
    } else if (ours.compare(i, 4, " || ") == 0) {
      out += " || ";
      i += 3;
      in_mnemonic = true;
      continue;
    }
    if (row.has('z') && ours.compare(i, 2, ",=") == 0) break;
    if (c == '=') continue;
    if (c == '@') {
      const Operand& direct = instruction.src1.is(Operand::Kind::direct)   ? instruction.src1
                              : instruction.src2.is(Operand::Kind::direct) ? instruction.src2
                                                                           : instruction.dst;
      out += fmt::format("@{:#x}", static_cast<Word>(direct.value) + (page << 16));
      i = ours.find(',', i);
      if (i == std::string::npos) break;
      --i;
      continue;
    }
    out += c;
  }
  const Operand& f = instruction.src1.is(Operand::Kind::immediate_float) ? instruction.src1 : instruction.src2;
  if (f.is(Operand::Kind::immediate_float)) {
    const auto start = out.find(' ') + 1, end = out.find(',');
    out.replace(start, end - start, gnu_float(static_cast<Word>(f.value)));
  }
  return out;
}

/// The first immediate operand with the other sign, as GNU prints it.
std::string with_immediate(const std::string& text, std::int64_t value) {
  const auto start = text.find(' ') + 1, end = std::min(text.find(','), text.size());
  return text.substr(0, start) + std::to_string(value) + text.substr(end);
}

/// Known differences in objdump's text of the same instruction; empty if none of them explains the difference.
std::string explain(const Instruction& instruction, const std::string& ours, std::string_view gnu) {
  using Op = isa::Operation;
  const isa::Row& row = *instruction.row;
  if (row.operation == Op::nop && gnu == "nop r0") return "NOP is printed with an operand: nop r0";
  if (row.format == isa::Format::branch_register && ours.starts_with("rptbd ") && gnu == "rptb" + ours.substr(5))
    return "RPTBD of a register is printed as RPTB";
  if (row.format == isa::Format::store_constant) {
    const std::string unsigned_text = "sti" + with_immediate(ours, instruction.src1.value & 31).substr(4);
    if (gnu == unsigned_text) return "STIK is printed as STI, its constant unsigned";
  }
  const Operand& immediate = instruction.src1.is(Operand::Kind::immediate_int) ? instruction.src1 : instruction.src2;
  if (!immediate.is(Operand::Kind::immediate_int)) return {};
  const auto bits = static_cast<std::uint16_t>(immediate.value);
  if ((instruction.word >> 16) == 0x5070 && gnu == fmt::format("ldp {}", bits))
    return "LDIU of an immediate to DP is printed as LDP";
  if (gnu == with_immediate(ours, static_cast<std::int16_t>(bits)))
    return fmt::format("the immediate of {} is signed", isa::name(row.operation));
  if (gnu == with_immediate(ours, bits))
    return fmt::format("the immediate of {} is unsigned", isa::name(row.operation));
  return {};
}

/// For a word of no row that GNU takes as an instruction: the row that differs in the fewest bits.
std::string nearest_row(Word word) {
  if (word >> 24 == 0xBD) return "MH2, MH3";
  const isa::Row* best = nullptr;
  int least = 33;
  for (const isa::Row& row : isa::rows()) {
    const int distance = std::popcount((word ^ row.bits.match) & row.bits.mask);
    if (distance < least && ((word ^ row.bits.match) & row.bits.mask) >> 23 == 0) least = distance, best = &row;
  }
  if (best == nullptr) return "none";
  std::string name(best->mnemonic);
  if (best->parallel()) name += fmt::format(" || {}", best->mnemonic2);
  return name;
}

struct Difference {
  std::uint64_t count = 0;
  Word word = 0;
  std::string ours, gnu;
};

class Comparison {
 public:
  void add(Word word, Word address, std::string_view gnu) {
    ++words_;
    if (word >> 16 == 0x5070 || word >> 16 == 0x1F70) page_ = word & 0xFFFF;
    const bool gnu_knows = gnu != fmt::format("{:08x}", word);
    const isa::Decoded decoded = isa::decode(word);
    if (const auto* reserved = std::get_if<isa::Reserved>(&decoded)) {
      if (!gnu_knows) {
        ++reserved_;
        return;
      }
      std::string what(isa::describe(reserved->reason));
      if (reserved->reason == isa::Reserved::Reason::opcode) what = "opcode or fixed bits of " + nearest_row(word);
      return differ("reserved for us: " + what, word, ".word", gnu);
    }
    const auto& instruction = std::get<Instruction>(decoded);
    const std::string text = isa::disassemble(instruction, address);
    if (!gnu_knows) return differ("no instruction for GNU: " + text.substr(0, text.find(' ')), word, text, gnu);
    const std::string ours = in_gnu_style(instruction, text, page_);
    if (ours == gnu) {
      ++equal_;
      return;
    }
    std::string known = explain(instruction, ours, gnu);
    if (known.empty()) known = "UNEXPLAINED: " + text.substr(0, text.find(' '));
    differ(known, word, ours, gnu);
  }

  void print() const {
    fmt::print("words\t{}\nequal instructions\t{}\nreserved for both\t{}\n", words_, equal_, reserved_);
    for (const auto& [name, d] : differences_)
      fmt::print("{}\t{}\t{:08x}\t{}\t{}\n", name, d.count, d.word, d.ours, d.gnu);
  }

 private:
  void differ(const std::string& name, Word word, std::string_view ours, std::string_view gnu) {
    Difference& d = differences_[name];
    if (d.count++ == 0) d = {1, word, std::string(ours), std::string(gnu)};
  }

  std::uint64_t words_ = 0, equal_ = 0, reserved_ = 0;
  Word page_ = 0;
  std::map<std::string, Difference> differences_;
};

Word hexadecimal(std::string_view text) {
  Word value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return value;
}

/// Lines "  address:<tab>word <tab>text"; they must contain every word of the file, in order.
void compare(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Comparison comparison;
  std::string line;
  Word address = 0;
  while (std::getline(std::cin, line)) {
    const auto tab = line.find('\t');
    if (tab == std::string::npos || tab == 0 || line[tab - 1] != ':') continue;
    const auto second = line.find('\t', tab + 1);
    if (second == std::string::npos) throw std::runtime_error("not a line of objdump: " + line);
    std::array<unsigned char, 4> bytes{};
    if (!file.read(reinterpret_cast<char*>(bytes.data()), 4)) throw std::runtime_error("more lines than words");
    const Word word = bytes[0] | Word{bytes[1]} << 8 | Word{bytes[2]} << 16 | Word{bytes[3]} << 24;
    if (hexadecimal(std::string_view(line).substr(tab + 1, 8)) != word)
      throw std::runtime_error("a word that differs from the file:  " + line);
    std::string_view text = std::string_view(line).substr(second + 1);
    while (text.ends_with(' ')) text.remove_suffix(1);
    comparison.add(word, address++, text);
  }
  if (file.peek() != std::ifstream::traits_type::eof()) throw std::runtime_error("fewer lines than words");
  comparison.print();
}

}  // namespace

int main(int count, char** values) {
  std::ios::sync_with_stdio(false);
  const std::vector<std::string> arguments(values + 1, values + count);
  try {
    if (arguments.size() == 3 && arguments[0] == "words") {
      random_words(std::stoull(arguments[1]), std::stoull(arguments[2]));
    } else if (arguments.size() == 3 && arguments[0] == "range") {
      for (std::uint64_t i = 0, first = std::stoull(arguments[1], nullptr, 0); i < std::stoull(arguments[2]); ++i)
        put(static_cast<Word>(first + i));
    } else if (arguments.size() == 2 && arguments[0] == "text") {
      compare(arguments[1]);
    } else {
      throw std::invalid_argument("usage: c40_gnu_compare words COUNT SEED | range FIRST COUNT | text FILE");
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "c40_gnu_compare: {}\n", error.what());
    return 2;
  }
}
