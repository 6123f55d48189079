// The emulator's instructions against the reference, or the reference's cases for the specification in Python:
//
//   arithmetic_campaign [--cases N] [--seed S] [--jobs J] [OPERATION...]     exit status 1 if one differs
//   arithmetic_campaign --emit OPERATION [--cases N] [--seed S]              records on standard output
//
// A record is d, a, b (8 bytes each), status, selector (4 bytes each), d after (8), status after (4), little-endian.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "c40/instructions/bind.hpp"
#include "c40/instructions/handler_tables.hpp"
#include "cases.hpp"

namespace {

using c40::Word;
using reference::Case;
using reference::Cases;
using reference::Operation;
using reference::Result;

constexpr std::uint8_t ar0 = 8, ir0 = 17, block_size = 19;

/// The instruction for an operation: OP3 R2,R1,R0 or OP R1,R0; for address updates NOP *AR0..(IR0).. .
Word instruction(const std::string& name, std::uint32_t selector) {
  static const std::map<std::string, Word> three{{"addc", 0},  {"addf", 1}, {"addi", 2},    {"and", 3},    {"andn", 4},
                                                 {"ash", 5},   {"cmpf", 6}, {"cmpi", 7},    {"lsh", 8},    {"mpyf", 9},
                                                 {"mpyi", 10}, {"or", 11},  {"subb", 12},   {"subf", 13},  {"subi", 14},
                                                 {"tstb", 15}, {"xor", 16}, {"mpyshi", 17}, {"mpyuhi", 18}};
  static const std::map<std::string, Word> two{
      {"absf", 0x00000001},  {"absi", 0x00800001},        {"fix", 0x05000001},           {"float", 0x05800001},
      {"lde", 0x06800001},   {"ldf", 0x07000001},         {"ldm", 0x09000001},           {"negb", 0x0B000001},
      {"negf", 0x0B800001},  {"negi", 0x0C000001},        {"norm", 0x0D000001},          {"not", 0x0D800001},
      {"rnd", 0x11000001},   {"rol", 0x11E00001},         {"rolc", 0x12600001},          {"ror", 0x12E0FFFF},
      {"rorc", 0x1360FFFF},  {"subc", 0x17000001},        {"subrb", 0x18800001},         {"subrf", 0x19000001},
      {"subri", 0x19800001}, {"toieee", 0x1B800001},      {"frieee", 0x1C200000},        {"rsqrf", 0x1C800001},
      {"rcpf", 0x1D000001},  {"circular_up", 0x0CC07000}, {"circular_down", 0x0CC07800}, {"bit_reversed", 0x0CC0C800},
      {"lb", 0xB0000001},    {"lbu", 0xB2000001},         {"lwl", 0xB4000001},           {"lwr", 0xB6000001},
      {"mb", 0xB8000001},    {"lh", 0xBA000001},          {"lhu", 0xBB000001},           {"mh", 0xBC000001}};
  if (const auto found = three.find(name); found != three.end()) return 0x20000102u | found->second << 23;
  const Word condition = selector < 11 ? selector : selector + 1;  // 11 is reserved
  if (name == "ldfcond") return 0x40000001u | condition << 23;
  if (name == "ldicond") return 0x50000001u | condition << 23;
  return two.at(name) + (selector << 23);
}

/// Runs one instruction by the emulator's own handler.
class Emulated {
 public:
  explicit Emulated(const Operation& operation) : operation_(operation) {
    for (std::uint32_t selector = 0; selector < operation.selectors; ++selector) {
      const auto bound = c40::bind(instruction(std::string(operation.name), selector), false);
      programs_.push_back({std::get<c40::BoundInstruction>(bound).op, c40::Op{}});
      programs_.back()[0].access[0] = {&memory_, 0, 1};
      programs_.back()[1].handler = &c40::execute::end_of_step;
    }
  }

  Result run(const Case& c) {
    using reference::Operands;
    if (operation_.operands == Operands::address) {
      core_.r[ar0] = static_cast<Word>(c.a);
      core_.r[ir0] = static_cast<Word>(c.b);
      core_.r[block_size] = static_cast<Word>(c.d);
    } else {
      set(0, c.d);
      set(1, c.a);
      set(2, c.b);
      memory_ = static_cast<Word>(c.a);
    }
    core_.set_status(c.status);
    const auto& program = programs_[c.selector];
    program[0].handler(core_, program.data());
    if (operation_.operands == Operands::address) return {core_.r[ar0], core_.status()};
    return {c40::float40::bits({core_.e[0], core_.r[0]}), core_.status()};
  }

 private:
  void set(std::size_t code, std::uint64_t bits) {
    core_.e[code] = c40::float40::from_bits(bits).e;
    core_.r[code] = static_cast<Word>(bits);
  }

  const Operation& operation_;
  c40::Core core_;
  std::vector<std::array<c40::Op, 2>> programs_;
  Word memory_ = 0;
};

struct Options {
  std::uint64_t cases = 1'000'000;
  std::uint64_t seed = 1;
  unsigned jobs = 1;
  bool emit = false;
  std::vector<std::string> names;
};

std::string show(const Case& c, const Result& r) {
  return fmt::format("d={:010X} a={:010X} b={:010X} ST={:04X} selector={}: {:010X} ST={:04X}", c.d, c.a, c.b, c.status,
                     c.selector, r.d, r.status);
}

/// Number of differing cases; the first few are printed.
std::uint64_t compare(const Operation& operation, const Options& options) {
  constexpr std::uint64_t most_shown = 5;
  static std::mutex printing;
  Cases cases(operation, options.seed);
  Emulated emulated(operation);
  std::uint64_t differing = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t i = 0; i < options.cases; ++i) {
    const Case c = cases.next();
    const Result expected = operation.run(c), actual = emulated.run(c);
    if (expected == actual) [[likely]]
      continue;
    if (differing++ >= most_shown) continue;
    const std::lock_guard lock(printing);
    fmt::print("{}: the emulator gives {}; the reference {}\n", operation.name, show(c, actual), show(c, expected));
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  const std::lock_guard lock(printing);
  fmt::print("{:<14}{:>14} cases, {} differ ({:.1f} s)\n", operation.name, options.cases, differing, elapsed.count());
  std::fflush(stdout);
  return differing;
}

void emit(const Operation& operation, const Options& options) {
  Cases cases(operation, options.seed);
  for (std::uint64_t i = 0; i < options.cases; ++i) {
    const Case c = cases.next();
    const Result r = operation.run(c);
    std::array<unsigned char, 44> record{};
    std::size_t at = 0;
    const auto put = [&](std::uint64_t value, std::size_t bytes) {
      for (std::size_t n = 0; n < bytes; ++n) record[at++] = static_cast<unsigned char>(value >> 8 * n);
    };
    put(c.d, 8), put(c.a, 8), put(c.b, 8), put(c.status, 4), put(c.selector, 4), put(r.d, 8), put(r.status, 4);
    std::fwrite(record.data(), record.size(), 1, stdout);
  }
}

std::vector<const Operation*> chosen(const std::vector<std::string>& names) {
  std::vector<const Operation*> out;
  for (const Operation& operation : reference::operations())
    if (names.empty() || std::find(names.begin(), names.end(), operation.name) != names.end())
      out.push_back(&operation);
  return out;
}

Options read(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::stoull(argv[++i]) : 0; };
    if (argument == "--cases")
      options.cases = number();
    else if (argument == "--seed")
      options.seed = number();
    else if (argument == "--jobs")
      options.jobs = std::max(1u, static_cast<unsigned>(number()));
    else if (argument == "--emit")
      options.emit = true;
    else
      options.names.push_back(argument);
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = read(argc, argv);
  const std::vector<const Operation*> operations = chosen(options.names);
  if (operations.size() < options.names.size() || operations.empty() || options.cases == 0 ||
      (options.emit && operations.size() != 1)) {
    fmt::print(
        stderr,
        "usage: arithmetic_campaign [--cases N] [--seed S] [--jobs J] [OPERATION...] | --emit OPERATION\noperations:");
    for (const Operation& operation : reference::operations()) fmt::print(stderr, " {}", operation.name);
    fmt::print(stderr, "\n");
    return 2;
  }
  if (options.emit) {
    emit(*operations.front(), options);
    return 0;
  }
  std::atomic<std::size_t> next{0};
  std::atomic<std::uint64_t> differing{0};
  std::vector<std::thread> workers;
  for (unsigned job = 0; job < options.jobs; ++job)
    workers.emplace_back([&] {
      for (std::size_t i = next++; i < operations.size(); i = next++) differing += compare(*operations[i], options);
    });
  for (std::thread& worker : workers) worker.join();
  fmt::print("{} operations, {} cases each: {} differ\n", operations.size(), options.cases, differing.load());
  return differing == 0 ? 0 : 1;
}
