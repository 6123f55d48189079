// emulator exec: a program on one chip.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "c40/chip.hpp"
#include "c40/float40.hpp"
#include "c40/peripherals/events.hpp"
#include "cli/board_front.hpp"
#include "cli/chip_listeners.hpp"
#include "cli/options.hpp"
#include "cli/program.hpp"
#include "io/input_file.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "machine/address_names.hpp"
#include "machine/asleep.hpp"
#include "machine/board_file.hpp"
#include "machine/board_reserved.hpp"
#include "machine/boot.hpp"
#include "machine/chip_runner.hpp"
#include "machine/program_end.hpp"
#include "state/archive.hpp"
#include "toolchain/rom_file.hpp"

namespace cli {
namespace {

using isa::Register;
using toolchain::Address;
using toolchain::Image;
using toolchain::Word;

struct Dump {
  Address address;
  std::vector<Word> words;
};

struct Outcome {
  std::string
      reason;  ///< "until", "halt", "idle", "limit", "external_access", "port_wait", "dma_wait", "fault", "interrupted"
  std::string message;
  int status = success;
};

void load(c40::Chip& chip, const Image& image, const c40::Board& board) {
  for (const Image::Section& section : image.sections) {
    if (!section.loaded) continue;
    try {
      chip.write_block(section.address, section.words);
    } catch (const std::out_of_range&) {
      throw InputError(machine::no_ram_for(board, section.name, section.address, section.size));
    }
  }
}

/// What a run is to come to.
struct Until {
  std::optional<Address> pc;
  std::optional<std::pair<Address, Word>>
      word;  ///< a word of memory, and what it is to hold: looked at after each instruction
};

Until parse_until(const ExecOptions& options, const Image& image) {
  if (!options.until) return {};
  const std::string& text = *options.until;
  const std::size_t equals = text.find("==");
  if (equals == std::string::npos) return {.pc = parse_address(text, &image, "--until"), .word = {}};
  return {.pc = {},
          .word = std::pair{parse_address(text.substr(0, equals), &image, "--until"),
                            parse_address(text.substr(equals + 2), &image, "--until, behind ==")}};
}

/// Stops at a branch to itself and at an IDLE that nothing can end; the words that may be one are breakpoints.
class Run final : private machine::ChipRunner {
 public:
  /// \param asked the limit is what was asked for
  Run(c40::Chip& chip, const Image& image, const Until& until, bool asked)
      : chip_(chip), until_(until), asked_(asked), ends_unknown_(image.sections.empty()) {
    if (until_.pc) chip_.add_breakpoint(*until_.pc);
    for (const Address end : machine::program_ends(image)) chip_.add_breakpoint(end);
  }

  Outcome run(c40::Cycles limit) {
    limit_ = limit;
    run_chip(chip_);
    return outcome_;
  }

  std::optional<machine::BootFeeder> feeder;
  BoardFront* front = nullptr;
  machine::LoneDevices* devices = nullptr;
  machine::IgnoredAccesses* ignored = nullptr;

 private:
  static constexpr c40::Cycles slice =
      50'000;  // after which is asked whether to stop: a moment, also where each instruction is written

  std::optional<Span> span() override {
    if (until_.word && chip_.peek(until_.word->first) == until_.word->second) {
      ends({"until",
            fmt::format("{:08X}h holds {:08X}h, at {:08X}h", until_.word->first, until_.word->second, chip_.pc())});
      return {};
    }
    if (std::exchange(passes_, false)) {
      devices->limit(limit_);  // what is due comes before the instruction
      return Span{.one_instruction = true};
    }
    if (io::stop_asked()) {
      ends({"interrupted", fmt::format("by a signal, at {:08X}h", chip_.pc())});
      return {};
    }
    const c40::Cycles look =
        chip_.idle() ? 8 : 1000;  // whether the DMA, which an idle processor may wait for, still goes on
    front->listen(chip_.cycle());
    const c40::Cycles end = devices->limit(std::min(limit_, chip_.cycle() + (until_.word          ? 1
                                                                             : chip_.dma_active() ? look
                                                                                                  : slice)));
    return Span{.limit = end, .known = end};
  }

  bool at_limit() override {
    if (ends_unknown_ && machine::program_end(peek_at_pc(), chip_.pc()) == machine::ProgramEnd::halt &&
        !chip_.dma_busy() && (chip_.register_value(Register::ST) & c40::st::GIE) == 0)
      return ends(
          {"halt",
           fmt::format(
               "branch to itself at {:08X}h, seen at cycle {}: without PROGRAM it is looked for every {} cycles",
               chip_.pc(), chip_.cycle(), slice)});
    if (chip_.cycle() >= limit_)
      return asked_
                 ? ends({"limit", fmt::format("the {} cycles of --cycles have passed, at {:08X}h", limit_, chip_.pc())})
                 : ends({"limit", fmt::format("--max-cycles {} reached at {:08X}h", limit_, chip_.pc()), run_failed});
    if (!machine::sleeps_for_ever(chip_) || may_be_woken()) return true;
    if (machine::awaits_dma(chip_)) return dma_wait();
    return ends({"idle", fmt::format("IDLE at {:08X}h, and no interrupt is to come{}", chip_.pc() - 1,
                                     machine::armed_dma(chip_))});
  }

  bool asks_anew() override { return at_limit(); }

  Word peek_at_pc() const {
    try {
      return chip_.peek(chip_.pc());
    } catch (const std::out_of_range&) {
      return 0;  // the chip will say so itself
    }
  }

  bool at_breakpoint() override {
    const Address pc = chip_.pc();
    if (until_.pc && pc == *until_.pc) return ends({"until", fmt::format("reached {:08X}h", pc)});
    if (machine::program_end(chip_.peek(pc), pc) == machine::ProgramEnd::halt && !chip_.dma_busy()) {
      const bool interrupts = (chip_.register_value(Register::ST) & c40::st::GIE) != 0;
      const bool sleeps = interrupts && (machine::awaits_dma(chip_) || may_be_woken());
      if (!sleeps) return ends({"halt", fmt::format("branch to itself at {:08X}h{}", pc, machine::armed_dma(chip_))});
      if (machine::next_dma_tick(chip_) == std::numeric_limits<c40::Cycles>::max() && !awaits_event() &&
          !may_be_woken())
        return dma_wait();
    }
    return passes_ = true;
  }

  bool window_access(const c40::ExternalAccess& access) override {
    if (devices->serve(access) || ignored->serve(chip_, access)) return true;
    return ends(
        {"external_access",
         fmt::format(
             "{}{} at {:08X}h from PC {:08X}h: that is a bus window, and no [[device]] of the board file is behind it",
             access.channel < 0 ? "" : fmt::format("DMA channel {}: ", access.channel), access.write ? "write" : "read",
             access.address, chip_.pc()),
         run_failed});
  }

  bool port_access(const c40::PortAccess& access) override { return port_wait(access); }

  bool port_wait(const c40::PortAccess& access) override {
    if (feeder && feeder->serve(access)) return true;
    return ends({"port_wait",
                 fmt::format("{} from PC {:08X}h waits for ever since cycle {}: nothing is attached to the port{}",
                             c40::describe(access), chip_.pc(), access.cycle, booting()),
                 run_failed});
  }

  bool faulted(const c40::Fault& why) override {
    return ends({"fault", fmt::format("{} (PC {:08X}h, cycle {}){}", why.message, chip_.pc(), why.cycle, booting()),
                 run_failed});
  }

  /// Whether the loader of the boot ROM is what stopped, and where its stream stands.
  std::string booting() const {
    if (!feeder || chip_.pc() >= c40::rom_words) return "";
    return fmt::format("; this is the boot loader, which has got {} of {} words of its stream through port {}",
                       feeder->sent(), feeder->size(), feeder->port());
  }

  bool may_be_woken() const { return devices->could_wake() || front->may_be_typed(); }
  bool awaits_event() const { return machine::next_timer_interrupt(chip_) != std::numeric_limits<c40::Cycles>::max(); }

  bool dma_wait() {
    std::vector<std::string> waits;
    for (const c40::DmaWait& wait : chip_.dma_waits())
      waits.push_back(fmt::format("{} for ever since cycle {}", c40::describe(wait), wait.since));
    return ends({"dma_wait", fmt::format("{}; the processor sleeps at PC {:08X}h", fmt::join(waits, "; "), chip_.pc()),
                 run_failed});
  }

  bool ends(Outcome outcome) {
    outcome_ = std::move(outcome);
    return false;
  }

  c40::Chip& chip_;
  Until until_;
  bool asked_;
  bool ends_unknown_;    ///< there is no program that says where a branch to itself may stand
  bool passes_ = false;  ///< the instruction at the breakpoint is next
  c40::Cycles limit_ = 0;
  Outcome outcome_;
};

double microseconds(const c40::Chip& chip, double clock_mhz) {
  return static_cast<double>(chip.cycle()) * 2.0 / clock_mhz;
}

/// ADDRESS:COUNT
std::pair<Address, Address> parse_dump(const std::string& text, const Image& image) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) throw InputError(fmt::format("--dump: \"{}\" is not ADDRESS:COUNT", text));
  const Address address = parse_address(std::string_view(text).substr(0, colon), &image, "--dump");
  const Address count = parse_address(std::string_view(text).substr(colon + 1), nullptr, "--dump, COUNT");
  if (count == 0 || count > 1'000'000)
    throw InputError(fmt::format("--dump: {} words; 1 to 1000000 are possible", count));
  return {address, count};
}

Dump read_dump(const c40::Chip& chip, Address address, Address count, std::string_view what = "--dump") {
  Dump dump{address, {}};
  for (Address i = 0; i < count; ++i) {
    try {
      dump.words.push_back(chip.peek(address + i));
    } catch (const std::out_of_range&) {
      throw InputError(fmt::format("{}: {:08X}h is no memory of this board", what, address + i));
    }
  }
  return dump;
}

std::string register_name(Register reg) {
  std::string name(isa::name(reg));
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

/// Exact: a register's mantissa fits a double.
double to_double(c40::Float40 value) {
  return std::ldexp(static_cast<double>(c40::float40::mantissa(value)), value.e - 31);
}

constexpr std::array<Register, isa::register_count> all_registers() {
  using enum Register;
  return {R0,  R1,  R2,  R3,  R4, R5,  R6,  R7, R8, R9, R10, R11, AR0, AR1, AR2, AR3,
          AR4, AR5, AR6, AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS,  RE,  RC};
}

void print_text(const c40::Chip& chip, const Outcome& outcome, const std::vector<Dump>& dumps,
                const ChipListeners& listeners, const std::optional<double>& clock_mhz, bool peripherals) {
  io::print("stop: {}: {}\n", outcome.reason, outcome.message);
  io::print("PC {:08X}  {} instructions, {} cycles\n", chip.pc(), chip.instructions(), chip.cycle());
  for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
    if (chip.causes()[cause] != 0)
      io::print("  {:<18}{:>14}\n", name(static_cast<c40::Cause>(cause)), chip.causes()[cause]);
  if (clock_mhz) io::print("  {:.3f} us at {} MHz\n", microseconds(chip, *clock_mhz), *clock_mhz);
  io::print("{}", listeners.checks_text());
  int column = 0;
  for (const Register reg : all_registers()) {
    if (isa::is_extended(reg)) {
      io::print("{:<4}{:010X}  {:.9g}\n", register_name(reg), chip.register_value(reg),
                to_double(chip.float_register(reg)));
      continue;
    }
    io::print("{:<4}{:08X}{}", register_name(reg), chip.register_value(reg), ++column % 5 == 0 ? "\n" : "   ");
  }
  io::print("IVTP {:08X}  TVTP {:08X}\n", chip.expansion(isa::Expansion::IVTP), chip.expansion(isa::Expansion::TVTP));
  for (const Dump& dump : dumps)
    for (std::size_t i = 0; i < dump.words.size(); ++i) {
      if (i % 8 == 0) io::print("{}{:08X}:", i == 0 ? "" : "\n", dump.address + i);
      io::print(" {:08X}{}", dump.words[i], i + 1 == dump.words.size() ? "\n" : "");
    }
  io::print("{}", listeners.text());
  if (peripherals) io::print("{}", peripherals_text(chip));
}

void print_json(const c40::Chip& chip, const Outcome& outcome, const std::vector<Dump>& dumps,
                const ChipListeners& listeners, const std::optional<double>& clock_mhz, bool peripherals,
                BoardFront& front, const machine::IgnoredAccesses& ignored) {
  using Json = nlohmann::ordered_json;
  Json root = {{"stop", {{"reason", outcome.reason}, {"message", outcome.message}, {"pc", chip.pc()}}},
               {"instructions", chip.instructions()},
               {"cycles", chip.cycle()}};
  for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
    root["causes"][std::string(name(static_cast<c40::Cause>(cause)))] = chip.causes()[cause];
  for (const Register reg : all_registers()) {
    root["registers"][register_name(reg)] = chip.register_value(reg);
    if (isa::is_extended(reg)) root["floats"][register_name(reg)] = to_double(chip.float_register(reg));
  }
  root["registers"]["IVTP"] = chip.expansion(isa::Expansion::IVTP);
  root["registers"]["TVTP"] = chip.expansion(isa::Expansion::TVTP);
  if (clock_mhz) root["microseconds"] = microseconds(chip, *clock_mhz);
  root["dumps"] = Json::array();
  for (const Dump& dump : dumps) root["dumps"].push_back({{"address", dump.address}, {"words", dump.words}});
  listeners.add_to(root);
  if (peripherals) {
    add_peripherals(chip, root);
    add_ports(chip, root);
  }
  front.add_to(root);
  add_reserved(ignored, root);
  io::print("{}\n", root.dump(2, ' ', true, Json::error_handler_t::replace));
}

}  // namespace

namespace {

class EventText : public c40::PeripheralSink {
 public:
  EventText(const std::string& path, const Image& image) : file_(path), names_(image) {}
  void happened(const c40::PeripheralEvent& event) override {
    file_.stream() << event.cycle << ' ' << c40::to_text(event, [this](Address at) { return names_.text(at); }) << '\n';
  }
  void commit() { file_.commit(); }

 private:
  io::OutputFile file_;
  machine::AddressNames names_;
};

/// From reset on, as the board's pins say.
struct Boot {
  c40::Board board;
  std::optional<int> port;  ///< that brings the program
};

/// --boot PORT, ADDRESS or reset.
std::optional<Boot> parse_boot(const ExecOptions& options, const machine::BoardDescription& given) {
  if (!options.boot) return std::nullopt;
  const std::string& text = *options.boot;
  if (text == "reset") {
    if (!given.has_pins)
      throw InputError(fmt::format(
          "--boot reset: board {} says nothing of its pins; a board file with [pins] is expected (docs/boards.md)",
          given.board.name));
    if (machine::reset_source(given.board) == machine::ResetSource::ports)
      throw InputError(
          "--boot reset: the board's pins choose the communication ports; say through which the program comes: --boot "
          "0 to --boot 5");
    return Boot{given.board, {}};
  }
  Boot boot;
  try {
    if (text.size() == 1 && text[0] >= '0' && text[0] <= '5') {
      boot.port = text[0] - '0';
      boot.board = machine::with_boot_from_port(given.board);
    } else {
      boot.board = machine::with_boot_from_memory(given.board, parse_address(text, nullptr, "--boot"));
    }
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--boot: {}", error.what()));
  }
  const auto& asked = boot.board.pins;
  const auto& tied = given.board.pins;
  if (given.has_pins &&
      (given.board.rom.empty() || asked.reset_location != tied.reset_location || asked.iiof != tied.iiof))
    throw InputError(
        fmt::format("--boot {}: for that, [pins] of board {} would be romen = true, resetloc = 0, iiof = \"{:04b}\"; "
                    "--boot reset starts as they are",
                    text, given.board.name, asked.iiof));
  return boot;
}

std::vector<Word> stream_for(const Image& image, const Boot& boot) {
  machine::BootHeader header;
  header.global_interface_control = boot.board.global_interface_control;
  header.local_interface_control = boot.board.local_interface_control;
  try {
    return boot.port ? machine::boot_stream(image, header) : machine::boot_memory(image, header);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--boot: {}", error.what()));
  }
}

/// Where the chip will look for it: as a stream in the memory that the pins choose, or as it is, with a reset vector of
/// its own.
void place(c40::Chip& chip, const Image& image, const Boot& boot) {
  if (machine::reset_source(boot.board) == machine::ResetSource::vector) return load(chip, image, boot.board);
  try {
    chip.write_block(machine::boot_address(boot.board), stream_for(image, boot));
  } catch (const std::out_of_range& error) {
    throw InputError(fmt::format("--boot: the stream at {:08X}h does not lie in memory: {}",
                                 machine::boot_address(boot.board), error.what()));
  }
}

/// FILE@ADDRESS
std::pair<std::string, Address> file_at(const std::string& text, std::string_view what, const Image& image) {
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos || at == 0) throw InputError(fmt::format("{}: \"{}\" is not FILE@ADDRESS", what, text));
  return {text.substr(0, at), parse_address(std::string_view(text).substr(at + 1), &image, what)};
}

void write_words(c40::Chip& chip, Address address, std::span<const Word> words, std::string_view what) {
  try {
    chip.write_block(address, words);
  } catch (const std::out_of_range& error) {
    throw InputError(
        fmt::format("{}: {} words at {:08X}h do not lie in memory: {}", what, words.size(), address, error.what()));
  }
}

/// The ROMs as they are; what of them is booted is for the pins to say.
void place_roms(c40::Chip& chip, const ExecOptions& options, const Image& image) {
  struct Placed {
    std::uint64_t begin, end;
    std::string file;
  };
  std::vector<Placed> placed;
  for (const std::string& given : options.roms) {
    const auto [file, address] = file_at(given, "--rom", image);
    const auto bytes = toolchain::read_rom(file);
    const auto width = options.rom_width ? options.rom_width : toolchain::boot_width(bytes);
    if (!width)
      throw InputError(fmt::format(
          "--rom {}: its first word is not 8, 16 or 32, so it does not say how wide it is; --rom-width is expected",
          file));
    const std::vector<Word> words = toolchain::rom_words(bytes, *width);
    const Placed here{address, address + std::uint64_t{words.size()}, file};
    for (const Placed& other : placed)
      if (here.begin < other.end && other.begin < here.end)
        throw InputError(fmt::format("--rom {}: its words {:08X}h to {:08X}h overlap those of {}, {:08X}h to {:08X}h",
                                     file, here.begin, here.end - 1, other.file, other.begin, other.end - 1));
    placed.push_back(here);
    write_words(chip, address, words, "--rom " + file);
  }
}

/// --load and --poke, in this order.
void place_additions(c40::Chip& chip, const ExecOptions& options, const Image& image) {
  for (const std::string& given : options.loads) {
    const auto [file, address] = file_at(given, "--load", image);
    write_words(chip, address, toolchain::rom_words(toolchain::read_rom(file), 32), "--load " + file);
  }
  for (const std::string& given : options.pokes) {
    const std::size_t equals = given.find('=');
    if (equals == std::string::npos) throw InputError(fmt::format("--poke: \"{}\" is not ADDRESS=WORD", given));
    const Word word = parse_address(std::string_view(given).substr(equals + 1), &image, "--poke, behind =");
    write_words(chip, parse_address(std::string_view(given).substr(0, equals), &image, "--poke"), std::span(&word, 1),
                "--poke");
  }
}

}  // namespace

int exec(const ExecOptions& options) {
  if (!options.roms.empty() && !options.boot) throw InputError("--rom: needs --boot ADDRESS or --boot reset");
  if (options.rom_width && options.roms.empty()) throw InputError("--rom-width: needs --rom FILE@ADDRESS");
  if (options.trace_labels && !options.trace) throw InputError("--trace-labels: needs --trace FILE");
  if (options.programs.size() > 1 || options.network || options.topology || !options.links.empty() ||
      !options.nets.empty())
    return exec_network(options);
  if (options.boards.size() > 1) throw InputError("--board: one chip has one board");
  if (options.link_trace) throw InputError("--link-trace: there is no link");
  if (options.perfetto)
    throw InputError("--perfetto: it draws the links of a network; one program has --trace, --events");
  machine::BoardDescription chosen = board_named(options, options.boards.empty() ? "default" : options.boards.front());
  const bool boots_rom = !options.roms.empty() || (!chosen.contents.empty() && options.boot);
  if (options.programs.empty() && !boots_rom)
    throw InputError(
        "exec: PROGRAM is missing; a program is expected, a ROM to boot (--rom, or region.file of the board, and "
        "--boot), or --network FILE.toml");
  add_inputs({{"0", &chosen}}, options);
  machine::BoardDevices around(chosen.devices);
  const Image image = options.programs.empty() ? Image{}
                                               : read_program(options.programs.front(), options.include_directories,
                                                              options.load_at, options.dialect);
  for (const std::string& warning : image.warnings) io::print(stderr, "{}\n", warning);
  io::FileRoles files = files_read(options);
  for (const std::string& given : options.roms) files.reads("--rom", file_at(given, "--rom", image).first);
  for (const std::string& given : options.loads) files.reads("--load", file_at(given, "--load", image).first);
  for (const std::string& source : image.files_read) files.reads("a source", source);
  files.writes("--trace", options.trace.value_or("")).writes("--events", options.events.value_or(""));
  add_device_files(options, files);
  BoardFront front({{"0", &around}}, options, !options.json);
  const Until until = parse_until(options, image);
  std::vector<std::pair<Address, Address>> ranges;
  for (const std::string& text : options.dumps) ranges.push_back(parse_dump(text, image));

  const std::optional<Boot> boot = parse_boot(options, chosen);
  c40::Chip chip(boot ? boot->board : chosen.board);
  for (const auto& [base, words] : chosen.contents) write_words(chip, base, words, "board " + chosen.board.name);
  if (boot) {
    if (boots_rom && !boot->port)
      place_roms(chip, options, image);
    else if (!options.roms.empty())
      throw InputError(
          "--rom: with --boot PORT the program comes through the port; --boot ADDRESS or reset is expected");
    else if (!boot->port)
      place(chip, image, *boot);
    try {
      chip.boot();
    } catch (const std::out_of_range& error) {
      throw InputError(fmt::format("--boot {}: {}", *options.boot, error.what()));
    }
  } else {
    chip.reset();
    load(chip, image, chosen.board);
    chip.set_pc(options.entry ? parse_address(*options.entry, &image, "--entry") : image.entry);
  }
  place_additions(chip, options, image);
  if (until.word) read_dump(chip, until.word->first, 1, "--until");
  for (const auto& [address, count] : ranges) read_dump(chip, address, count);  // refuses bad ranges before the run

  ChipListeners listeners(chip, image, options, 0, options.trace);
  chip.set_trace(listeners.sink());
  std::optional<EventText> events;
  if (options.events) chip.set_peripheral_sink(&events.emplace(*options.events, image));
  Run run(chip, image, until, options.cycles.has_value());
  machine::LoneDevices devices(around, chip);
  run.devices = &devices;
  machine::IgnoredAccesses ignored(chosen.ignored);
  run.ignored = &ignored;
  run.front = &front;
  if (boot && boot->port) run.feeder.emplace(chip, *boot->port, stream_for(image, *boot));
  const io::StopBySignal signals;
  const Outcome outcome = run.run(options.cycles.value_or(options.max_cycles));
  if (events) events->commit();
  listeners.run_ended();

  std::vector<Dump> dumps;
  for (const auto& [address, count] : ranges) dumps.push_back(read_dump(chip, address, count));
  front.run_ended({around.empty() ? std::string() : state::save(chip) + state::save(around)});
  if (options.json) {
    print_json(chip, outcome, dumps, listeners, chosen.clock_mhz, options.peripherals, front, ignored);
  } else {
    io::print("{}", front.text());
    print_text(chip, outcome, dumps, listeners, chosen.clock_mhz, options.peripherals);
    io::print("{}{}", ignored.text(), front.hash_text());
  }
  return outcome.reason == "interrupted" ? signals.status(run_failed) : outcome.status;
}

}  // namespace cli
