#include "machine/boards/board_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>

#include "c40/memory/memory.hpp"
#include "c40/pipeline/timing_parameters.hpp"
#include "io/text_form.hpp"
#include "machine/boards/board_reserved.hpp"
#include "machine/boards/board_toml.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/chips/boot.hpp"
#include "toolchain/objects/image.hpp"
#include "toolchain/objects/rom_file.hpp"

namespace machine {
namespace {

using c40::Address;
using c40::Region;

constexpr std::array<std::string_view, 8> root_keys{"name", "clock_mhz", "gmicr",  "lmicr",
                                                    "pins", "reserved",  "region", "device"};
constexpr std::array<std::string_view, 11> region_keys{
    "name", "kind", "base", "words", "bus", "waits", "read_waits", "write_waits", "page_waits", "file", "width"};
constexpr std::array<std::string_view, 4> reserved_region_keys{"name", "kind", "base", "words"};
constexpr std::array<std::string_view, 3> pin_keys{"romen", "resetloc", "iiof"};

class BoardReader {
 public:
  BoardReader(std::string file, BoardFiles files) : toml_(std::move(file)) {
    toml_.reads_files = files == BoardFiles::read;
  }

  BoardDescription read(const toml::table& root) {
    toml_.allow(root, "", root_keys);
    BoardDescription out;
    out.board.name = toml_.file();
    toml_.optional(root, "name", [&](const toml::node& node) { out.board.name = toml_.text(node, "name"); });
    toml_.optional(root, "clock_mhz", [&](const toml::node& node) {
      out.clock_mhz = toml_.real(node, "clock_mhz", slowest_mhz, fastest_mhz);
    });
    toml_.optional(root, "gmicr",
                   [&](const toml::node& node) { out.board.global_interface_control = toml_.word(node, "gmicr"); });
    toml_.optional(root, "lmicr",
                   [&](const toml::node& node) { out.board.local_interface_control = toml_.word(node, "lmicr"); });
    const auto* regions = root.get("region");
    if (regions == nullptr || !regions->is_array() || regions->as_array()->empty())
      toml_.note("region: a board needs at least one [[region]] with name, base, words and bus");
    else
      read_regions(out, *regions->as_array(), root);
    read_devices(toml_, out, root);
    toml_.optional(root, "pins", [&](const toml::node& node) {
      out.has_pins = true;
      pins(out.board, node);
    });
    toml_.finish<BoardError>();
    add_ignored(out.board, out.ignored);  // Devices are behind windows, but not behind these.
    return out;
  }

 private:
  void read_regions(BoardDescription& out, const toml::array& regions, const toml::table& root) {
    std::size_t number = 0;  // of the region in the file, for messages about one without a name
    for (const auto& node : regions) {
      ++number;
      if (is_reserved(node)) continue;
      const std::size_t before = out.board.regions.size();
      if (!toml_.attempt([&] { add(out, node, number); }) || out.board.regions.size() == before)
        toml_.regions_known = false;
    }
    std::vector<c40::AddressRange> kept;
    for (const auto& node : regions)
      if (is_reserved(node)) toml_.attempt([&] { add_reserved(out, *node.as_table(), kept); });
    toml_.optional(root, "reserved", [&](const toml::node& node) {
      if (!is_ignored(node, "reserved")) return;
      std::ranges::copy(out.ignored, std::back_inserter(kept));
      std::ranges::copy(unoccupied(out.board, kept), std::back_inserter(out.ignored));
    });
  }

  void add(BoardDescription& description, const toml::node& node, std::size_t number) {
    c40::Board& board = description.board;
    if (!node.is_table()) toml_.fail(node, "region: each is a table, [[region]]");
    const toml::table& table = *node.as_table();
    toml_.allow(table, "region.", region_keys);
    bool whole = true;
    // A key that is missing or wrong does not hide what is wrong in the others.
    const auto needed = [&](std::string_view key, auto&& read) {
      const toml::node* given = table.get(key);
      if (given == nullptr) toml_.note(node, fmt::format("region {}: {} is missing", number, key));
      whole &= given != nullptr && toml_.attempt([&] { read(*given); });
    };
    Region region;
    region.name = std::to_string(number);
    bool has_base = false;
    needed("name", [&](const toml::node& given) { region.name = toml_.text(given, "region.name"); });
    needed("base", [&](const toml::node& given) {
      region.base = toml_.word(given, "region.base");
      has_base = true;
    });
    needed("words", [&](const toml::node& given) { region.words = words_of(given, region); });
    toml_.optional(table, "kind", [&](const toml::node& kind) { region.kind = kind_of(kind, region); });
    const bool window = region.kind == Region::Kind::external_window;
    if (whole && !window && region.words > most_words)
      toml_.note(*table.get("words"),
                 fmt::format("region.words of {}: a board has at most {} words of RAM", region.name, most_words));
    needed("bus", [&](const toml::node& given) { region.bus = bus_of(given, region, has_base); });
    waits(table, region);
    if (whole) check_place(board, region, node);
    if (const auto* file = table.get("file")) {
      if (toml_.reads_files)
        toml_.attempt([&] {
          description.contents.push_back({region.base, contents(description, region, *file, table.get("width"))});
        });
    } else if (const auto* width = table.get("width")) {
      toml_.note(*width, fmt::format("region.width of {}: is for a file, and `file` is missing", region.name));
    }
    if (whole) board.regions.push_back(std::move(region));
  }

  std::uint64_t words_of(const toml::node& node, const Region& region) {
    const auto* words = node.as_integer();
    const std::int64_t room = (std::int64_t{1} << 32) - region.base;
    if (words == nullptr || words->get() < 1 || words->get() > room)
      toml_.fail(node, fmt::format("region.words of {}: 1 to {} words are possible from {:08X}h", region.name, room,
                                   region.base));
    return static_cast<std::uint64_t>(words->get());
  }

  void waits(const toml::table& table, Region& region) {
    const bool window = region.kind == Region::Kind::external_window;
    for (const auto& [key, fields] :
         {std::pair<std::string_view, std::vector<int*>>{"waits", {&region.read_waits, &region.write_waits}},
          {"read_waits", {&region.read_waits}},
          {"write_waits", {&region.write_waits}},
          {"page_waits", {&region.page_waits}}})
      toml_.optional(table, key, [&, &k = key, &f = fields](const toml::node& node) {
        if (window)
          toml_.fail(node, fmt::format("region.{} of {}: a window has no wait states of its own, it waits for its bus",
                                       k, region.name));
        for (int* field : f)
          *field = static_cast<int>(toml_.word(node, fmt::format("region.{}", k), c40::timing::max_region_waits));
      });
  }

  bool is_ignored(const toml::node& node, std::string_view key) {
    const std::string what = toml_.text(node, key);
    if (what != "fault" && what != "ignore") toml_.fail(node, fmt::format("{}: fault or ignore is expected", key));
    return what == "ignore";
  }

  /// A region without any device or memory.
  static bool is_reserved(const toml::node& node) {
    const auto* table = node.as_table();
    const std::string kind = table == nullptr ? "" : (*table)["kind"].value_or(std::string());
    return kind == "fault" || kind == "ignore";
  }

  /// A region of kind "fault" stays a fault, whatever the board's `reserved` is.
  void add_reserved(BoardDescription& description, const toml::table& table, std::vector<c40::AddressRange>& kept) {
    const toml::node& node = table;
    toml_.allow(table, "region.", reserved_region_keys);
    const bool ignored = is_ignored(*table.get("kind"), "region.kind");
    bool whole = true;
    for (const std::string_view key : {"name", "base", "words"})
      if (table.get(key) == nullptr) {
        toml_.note(node, fmt::format("region of kind \"{}\": {} is missing", ignored ? "ignore" : "fault", key));
        whole = false;
      }
    if (!whole) return;
    Region region;
    whole &= toml_.attempt([&] { region.name = toml_.text(*table.get("name"), "region.name"); });
    whole &= toml_.attempt([&] { region.base = toml_.word(*table.get("base"), "region.base"); });
    whole &= toml_.attempt([&] { region.words = words_of(*table.get("words"), region); });
    if (!whole) return;
    if (!is_free(description, kept, region))
      toml_.fail(
          node,
          fmt::format(
              "region {} ({:08X}h, {} words): another region, the boot ROM, or an address of the chip itself is there",
              region.name, region.base, region.words));
    (ignored ? description.ignored : kept).push_back({region.base, static_cast<c40::Word>(region.words)});
  }

  static bool is_free(const BoardDescription& description, const std::vector<c40::AddressRange>& kept,
                      const Region& region) {
    c40::Board others = description.board;
    add_ignored(others, kept);
    add_ignored(others, description.ignored);
    return std::ranges::any_of(unoccupied(others, {}), [&](const c40::AddressRange& gap) {
      return region.base >= gap.first && region.base + region.words <= std::uint64_t{gap.first} + gap.words;
    });
  }

  /// The image of a ROM, in the folder of the board file.
  std::vector<c40::Word> contents(BoardDescription& description, const Region& region, const toml::node& file,
                                  const toml::node* width) {
    if (region.kind == Region::Kind::external_window)
      toml_.fail(file, fmt::format("region.file of {}: a window has no contents", region.name));
    const std::string path = toml_.beside(toml_.text(file, "region.file"));
    try {
      std::optional<unsigned> bits;
      if (width != nullptr) bits = toml_.word(*width, "region.width", 32);
      if (bits && *bits != 8 && *bits != 16 && *bits != 32)
        toml_.fail(*width, fmt::format("region.width of {}: 8, 16 or 32 is expected", region.name));
      const std::vector<std::uint8_t> bytes = toolchain::read_rom(path);
      std::vector<c40::Word> words = toolchain::rom_words_of(path, bytes, bits, "region.width");
      if (words.size() > region.words)
        toml_.fail(file, fmt::format("region.file of {}: {} words do not go into {}", region.name, words.size(),
                                     region.words));
      if (const std::string warning = toolchain::width_contradiction(bytes, bits, "region.width"); !warning.empty())
        description.warnings.push_back(fmt::format("{}:{}: warning: region.file of {}: {}", toml_.file(),
                                                   width->source().begin.line, region.name, warning));
      return words;
    } catch (const toolchain::RomError& error) {
      toml_.fail(file, fmt::format("region.file of {}: {}", region.name, error.what()));
    }
  }

  // c40-hardware.md 1.2, 9.1
  void pins(c40::Board& board, const toml::node& node) {
    if (!node.is_table()) toml_.fail(node, "pins: a table, [pins], is expected");
    const toml::table& table = *node.as_table();
    toml_.allow(table, "pins.", pin_keys);
    bool rom = false;
    toml_.optional(table, "romen", [&](const toml::node& romen) {
      if (!romen.is_boolean()) toml_.fail(romen, "pins.romen: true (the boot ROM is at 0) or false is expected");
      rom = romen.as_boolean()->get();
    });
    c40::Board::Pins tied;
    toml_.optional(table, "resetloc", [&](const toml::node& location) {
      tied.reset_location = static_cast<int>(toml_.word(location, "pins.resetloc", 3));
    });
    toml_.optional(table, "iiof", [&](const toml::node& levels) { tied.iiof = levels_of(levels); });
    if (rom) {
      for (const Region& region : board.regions)
        if (region.base < c40::rom_words)
          toml_.fail(node, fmt::format("pins.romen: the boot ROM is at 0 to FFFh, and so is region {}", region.name));
      board.rom = with_boot_from_port({}).rom;
    }
    board.pins = tied;
    if (!rom || tied.reset_location != 0) return;
    if ((tied.iiof & 1) == 0)
      toml_.fail(
          node,
          "pins.iiof: the last level, IIOF0, must be 1 for the boot loader, which romen = true and resetloc = 0 start");
    if (tied.iiof >> 1 == 0)
      toml_.fail(
          node,
          "pins.iiof: 000 of IIOF3 to IIOF1 is reserved; the boot loader would read the pins forever. 111 means the "
          "communication ports");
  }

  /// "1101": IIOF3 to IIOF0.
  c40::Word levels_of(const toml::node& node) {
    const std::string levels = toml_.text(node, "pins.iiof");
    if (levels.size() != 4 || levels.find_first_not_of("01") != std::string::npos)
      toml_.fail(node, "pins.iiof: the levels of IIOF3 to IIOF0 are expected, as \"1111\"");
    return static_cast<c40::Word>(std::stoul(levels, nullptr, 2));
  }

  // The address decides which bus the chip uses (c40-hardware.md 1.1).
  Region::Bus bus_of(const toml::node& node, const Region& region, bool has_base) {
    const std::string bus = toml_.text(node, "region.bus");
    if (bus != "local" && bus != "global")
      toml_.fail(node, fmt::format("region.bus of {}: local or global is expected", region.name));
    const bool upper = region.base >= 0x80000000u;
    const std::uint64_t end = region.base + region.words;
    if (!has_base) return bus == "local" ? Region::Bus::local : Region::Bus::global;
    if (upper != (bus == "global") || (!upper && end > 0x80000000ull))
      toml_.fail(node, fmt::format("region.bus of {}: the local bus is below 80000000h, the global bus from there on",
                                   region.name));
    return bus == "local" ? Region::Bus::local : Region::Bus::global;
  }

  Region::Kind kind_of(const toml::node& node, const Region& region) {
    const std::string kind = toml_.text(node, "region.kind");
    if (kind != "ram" && kind != "window")
      toml_.fail(node, fmt::format("region.kind of {}: ram, window (to a shared bus), fault or ignore is expected",
                                   region.name));
    return kind == "ram" ? Region::Kind::ram : Region::Kind::external_window;
  }

  void check_place(const c40::Board& board, const Region& region, const toml::node& node) {
    const std::uint64_t end = region.base + region.words;
    if (region.base < first_external && end > chip_begin)
      toml_.note(
          node,
          fmt::format(
              "region.base of {}: {:08X}h to {:08X}h belong to the chip; a board has the addresses before and after",
              region.name, chip_begin, first_external - 1));
    for (const Region& other : board.regions)
      if (region.base < other.base + other.words && other.base < end)
        toml_.note(node, fmt::format("region {} ({:08X}h, {} words) overlaps {} ({:08X}h, {} words)", region.name,
                                     region.base, region.words, other.name, other.base, other.words));
  }

  static constexpr Address chip_begin = 0x00100000u, first_external = 0x00300000u;
  static constexpr std::uint64_t most_words = std::uint64_t{1} << 28;
  BoardToml toml_;
};

}  // namespace

BoardDescription read_board(const std::string& name, BoardFiles files) {
  if (name == "default") return {.board = c40::Board::default_board()};
  if (name == "flat") return {.board = c40::Board::flat()};
  if (!name.ends_with(".toml"))
    throw BoardError(
        fmt::format("there is no board \"{}\"; default, flat, or a file that ends in .toml is expected", name));
  const std::string text = io::read_text<BoardError>(name, "a board file (docs/boards.md)");
  try {
    return BoardReader(name, files).read(io::parse_toml(text, name));
  } catch (const toml::parse_error& error) {
    throw BoardError(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
}

void refuse_devices(const BoardDescription& board, std::string_view where) {
  if (!board.devices.empty())
    throw BoardError(fmt::format(
        "board {}: device {}: {} has no devices of a board file: behind the windows of its DSPs are buses A and B "
        "(docs/buses.md). `emulator exec --board` runs a program with this board, alone or in a network; for the dock, "
        "leave [[device]] out (docs/boards.md)",
        board.board.name, board.devices.front().name, where));
  if (!board.contents.empty())
    throw BoardError(fmt::format(
        "board {}: region.file: {} loads no ROMs: its host boots the DSPs over their links. `emulator exec --board` "
        "boots a ROM; for the dock, leave `file` out (docs/boards.md)",
        board.board.name, where));
}

void refuse_ignored(const BoardDescription& board) {
  if (!board.ignored.empty())
    throw BoardError(fmt::format(
        "board {}: reserved: a DSP of the dock that leaves its memory has failed, and the run says where; \"fault\" is "
        "expected, for regions too. \"ignore\" is for `emulator exec` (docs/boards.md)",
        board.board.name));
}

std::int64_t instruction_cycles_per_second(double clock_mhz) { return std::llround(clock_mhz * 1e6 / 2); }

namespace {

/// \param reach least number of words of the board's window
void require_window(const c40::Board& board, char bus, Address base, std::uint64_t reach) {
  for (const Region& region : board.regions) {
    if (region.kind != Region::Kind::external_window || region.base != base) continue;
    if (region.words >= reach) return;
    throw BoardError(
        fmt::format("board {}: region.words of {}: the window to bus {} has {} words; the devices on the bus need {}",
                    board.name, region.name, bus, region.words, reach));
  }
  throw BoardError(
      fmt::format("board {}: region: the DSPs reach bus {} at {:08X}h, and there is no window; one with kind = "
                  "\"window\", base = 0x{:X} is "
                  "expected",
                  board.name, bus, base, base));
}

}  // namespace

void require_dsp_board(const c40::Board& board, const toolchain::Image& program, const Symbols& symbols) {
  require_window(board, 'A', symbols.window_a, SharedRegisters::base + SharedRegisters::size);
  require_window(board, 'B', symbols.window_b, 1);
  for (const Region& region : board.regions)
    if (region.kind == Region::Kind::external_window && region.base != symbols.window_a &&
        region.base != symbols.window_b)
      throw BoardError(
          fmt::format("board {}: region.base of {}: a window at {:08X}h leads nowhere; those to buses A and B are at "
                      "{:08X}h and {:08X}h",
                      board.name, region.name, region.base, symbols.window_a, symbols.window_b));
  const c40::Memory memory(board);
  for (const toolchain::Image::Section& section : program.sections) {
    if (section.size == 0) continue;
    const c40::Memory::Area* area = memory.find(section.address);
    const bool holds = area != nullptr && area->data != nullptr &&
                       section.address - area->base + std::uint64_t{section.size} <= area->words;
    if (!holds)
      throw BoardError(fmt::format("board {}: region: no RAM holds section {} of the DSP programs, {} words at {:08X}h",
                                   board.name, section.name, section.size, section.address));
  }
}

}  // namespace machine
