#include "cli/arguments/network_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "cli/arguments/program.hpp"
#include "cli/exec/board_front.hpp"
#include "cli/exec/exec_memory.hpp"
#include "io/print.hpp"
#include "machine/networks/network_file.hpp"

namespace cli {
namespace {

machine::NetDescription net_of(const std::string& text, const std::vector<std::string>& chips) {
  try {
    return machine::parse_net(text, chips);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--net: {}", error.what()));
  }
}

/// [CHIP:]SYMBOL or ADDRESS. Without CHIP: for all chips that have no --until of their own.
void set_until(machine::NetworkDescription& network, const std::string& text) {
  if (text.find("==") != std::string::npos)
    throw InputError(fmt::format(
        "--until {}: the value of a word ends a run of one chip only; for a network [CHIP:]SYMBOL or ADDRESS is "
        "expected, or `watch` in `emulator debug`",
        text));
  const ChipText given = chip_text(text, network.chips.size(), "--until");
  bool set = false;
  for (std::size_t n = 0; n < network.chips.size(); ++n) {
    machine::NetworkChip& chip = network.chips[n];
    if (given.chip.value_or(n) != n || (!given.chip && chip.until)) continue;
    if (given.chip && chip.until)
      throw InputError(fmt::format("--until {}: chip {} ends at {:08X}h already; a chip of a network has one end", text,
                                   n, *chip.until));
    chip.until = parse_address(given.rest, chip.program.get(), "--until");
    set = true;
  }
  if (!set) throw InputError(fmt::format("--until {}: every chip has an end already", text));
}

/// --boot and --rom: the one chip starts as its pins say.
void set_boot(machine::NetworkChip& chip, const ExecOptions& options) {
  const std::optional<Boot> boot = parse_boot(options, chip.board);
  if (boot->port)
    throw InputError(
        "--boot PORT: nobody sends the program here; --boot ADDRESS or reset is expected, or --network with boot = "
        "true of a [[chip]] and a link to it");
  chip.is_in_rom = boots_rom(options, chip.board);
  if (chip.program == nullptr && !chip.is_in_rom)
    throw InputError("--boot: a PROGRAM, or a ROM to boot (--rom, or region.file of the board), is expected");
  for (auto& rom : rom_contents(options, chip.program.get())) chip.board.contents.push_back(std::move(rom));
  chip.board.board = boot->board;
  chip.board.has_pins = chip.boot = true;
}

/// --until as exec has it; words are for whoever runs the chip.
void set_ends(machine::NetworkChip& chip, const ExecOptions& options) {
  for (const std::string& text : options.until)
    if (text.find("==") == std::string::npos)
      chip.other_ends.push_back(parse_address(chip_text(text, 1, "--until").rest, chip.program.get(), "--until"));
}

machine::NetworkDescription read_description(const ExecOptions& options) {
  if (options.network) {
    if (!options.programs.empty() || !options.links.empty() || !options.nets.empty() || options.topology ||
        !options.boards.empty() || !options.until.empty() || options.entry || options.load_at || options.memory_max)
      throw InputError(
          "--network: programs, boards, links, nets, and where a chip starts and ends are given in the file, not on "
          "the command line");
    require_file(*options.network);
    machine::NetworkDescription read = machine::read_network(*options.network, [&](const std::string& path) {
      return read_program(path, options.include_directories, {}, is_source_name(path) ? options.dialect : std::nullopt);
    });
    std::set<std::string> said;  // several chips may have one board
    for (const machine::NetworkChip& chip : read.chips)
      for (const std::string& warning : chip.board.warnings)
        if (said.insert(warning).second) io::print(stderr, "{}\n", warning);
    return read;
  }
  machine::NetworkDescription network;
  std::size_t chips = options.boot ? std::max(options.programs.size(), std::size_t{1}) : options.programs.size();
  if (options.topology) {
    try {
      chips = machine::set_topology(network, *options.topology);
    } catch (const machine::NetworkError& error) {
      throw InputError(fmt::format("--topology: {}", error.what()));
    }
    if (options.programs.size() != 1 && options.programs.size() != chips)
      throw InputError(
          fmt::format("--topology {} has {} chips: one program for all or {} programs are expected, not {}",
                      *options.topology, chips, chips, options.programs.size()));
  }
  if (options.boards.size() > 1 && options.boards.size() != chips)
    throw InputError(
        fmt::format("--board: one for all chips or {} are expected, not {}", chips, options.boards.size()));
  const bool alone = is_alone(options);
  if (options.memory_max && options.boards.empty() && !alone)
    throw InputError("--memory-max: --board flat is expected; other boards have as much RAM as they say");
  std::vector<machine::BoardDescription> boards;
  for (const std::string& board : options.boards) boards.push_back(board_named(options, board));
  if (boards.empty() && alone) boards.push_back(board_named(options, "default"));
  std::vector<std::shared_ptr<const toolchain::Image>> images;
  for (const std::string& program : options.programs)
    images.push_back(std::make_shared<toolchain::Image>(read_program(
        program, options.include_directories, alone || program.ends_with(".hex") ? options.load_at : std::nullopt,
        alone || is_source_name(program) ? options.dialect : std::nullopt)));
  std::vector<std::string> names;
  for (std::size_t n = 0; n < chips; ++n) {
    machine::NetworkChip chip;
    if (!images.empty()) chip.program = images[images.size() == 1 ? 0 : n];
    if (!boards.empty()) chip.board = boards[boards.size() == 1 ? 0 : n];
    chip.is_alone = alone;
    if (options.entry) chip.entry = parse_address(*options.entry, chip.program.get(), "--entry");
    network.chips.push_back(std::move(chip));
    names.push_back(fmt::format("{}", n));
  }
  if (options.boot) {
    if (chips != 1) throw InputError(fmt::format("--boot: one chip boots so, and {} are given", chips));
    set_boot(network.chips.front(), options);
  }
  if (alone) set_ends(network.chips.front(), options);
  for (const std::string& text : options.until)
    if (!alone) set_until(network, text);
  for (const std::string& link : options.links) network.links.push_back(machine::parse_link(link, names));
  for (const std::string& net : options.nets) network.nets.push_back(net_of(net, names));
  return network;
}

/// --load FILE@CHIP:ADDRESS and --poke CHIP:ADDRESS=WORD, in this order. CHIP may be left out where there is one.
void add_words(machine::NetworkDescription& network, const ExecOptions& options) {
  struct Additions {
    std::vector<std::string> loads, pokes;
  };
  std::vector<Additions> additions(network.chips.size());
  const auto add = [&](std::string_view what, std::string_view text, const std::string& file, const char* form) {
    const ChipText given = chip_text(text, network.chips.size(), what);
    if (!given.chip && network.chips.size() > 1)
      throw InputError(fmt::format("{}: \"{}{}\" is not {}, which a network needs", what, file, text, form));
    Additions& of_chip = additions[given.chip.value_or(0)];
    (file.empty() ? of_chip.pokes : of_chip.loads).push_back(file + std::string(given.rest));
  };
  for (const std::string& text : options.loads) {
    const std::size_t at = text.rfind('@') == std::string::npos ? 0 : text.rfind('@') + 1;
    if (at < 2 && is_alone(options)) throw InputError(fmt::format("--load: \"{}\" is not FILE@ADDRESS", text));
    if (at < 2) throw InputError(fmt::format("--load: \"{}\" is not FILE@CHIP:ADDRESS, which a network needs", text));
    add("--load", std::string_view(text).substr(at), text.substr(0, at), "FILE@CHIP:ADDRESS");
  }
  for (const std::string& text : options.pokes) add("--poke", text, "", "CHIP:ADDRESS=WORD");
  for (std::size_t n = 0; n < network.chips.size(); ++n) {
    if (additions[n].loads.empty() && additions[n].pokes.empty()) continue;
    machine::NetworkChip& chip = network.chips[n];
    chip.add_words = [given = additions[n], program = chip.program](c40::Chip& made) {
      place_additions(made, given.loads, given.pokes, program.get());
    };
  }
}

}  // namespace

bool is_alone(const ExecOptions& options) {
  return options.programs.size() <= 1 && !options.network && !options.topology && options.links.empty() &&
         options.nets.empty();
}

machine::NetworkDescription described(const ExecOptions& options) {
  machine::NetworkDescription network = read_description(options);
  NamedBoards boards;
  for (std::size_t n = 0; n < network.chips.size(); ++n)
    boards.emplace_back(network.chips[n].name.empty() ? fmt::format("{}", n) : network.chips[n].name,
                        &network.chips[n].board);
  add_inputs(boards, options);
  add_words(network, options);
  return network;
}

machine::NetworkAction action_of(const std::string& text, const machine::Network& network) {
  try {
    return machine::parse_action(text, network.description());
  } catch (const machine::NetworkError& error) {
    throw InputError(fmt::format("--action {}: {}", text, error.what()));
  }
}

}  // namespace cli
