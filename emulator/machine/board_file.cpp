#include "machine/board_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <optional>

#include "c40/memory.hpp"
#include "c40/timing_parameters.hpp"
#include "io/input_file.hpp"
#include "io/toml.hpp"
#include "machine/board_reserved.hpp"
#include "machine/boot.hpp"
#include "machine/shared_memory.hpp"
#include "toolchain/image.hpp"
#include "toolchain/rom_file.hpp"

namespace machine {
namespace {

using c40::Address;
using c40::Region;

class BoardReader {
 public:
  explicit BoardReader(std::string file) : file_(std::move(file)) {}

  BoardDescription read(const toml::table& root) const {
    allow(root, "", {"name", "clock_mhz", "gmicr", "lmicr", "pins", "reserved", "region", "device"});
    BoardDescription out;
    out.board.name = file_;
    if (const auto* node = root.get("name")) out.board.name = text(*node, "name");
    if (const auto* node = root.get("clock_mhz")) {
      const auto value = node->value<double>();
      if (!node->is_number() || !value || !std::isfinite(*value) || *value < slowest_mhz || *value > fastest_mhz)
        fail(*node,
             fmt::format("clock_mhz: the frequency of CLKIN in MHz is expected, {} to {}", slowest_mhz, fastest_mhz));
      out.clock_mhz = *value;
    }
    if (const auto* node = root.get("gmicr")) out.board.global_interface_control = word(*node, "gmicr", 0xFFFFFFFF);
    if (const auto* node = root.get("lmicr")) out.board.local_interface_control = word(*node, "lmicr", 0xFFFFFFFF);
    const auto* regions = root.get("region");
    if (regions == nullptr || !regions->is_array() || regions->as_array()->empty())
      throw BoardError(
          fmt::format("{}: region: a board needs at least one [[region]] with name, base, words and bus", file_));
    std::vector<c40::AddressRange> kept;
    for (const auto& node : *regions->as_array())
      if (!is_reserved(node)) add(out, node);
    for (const auto& node : *regions->as_array())
      if (is_reserved(node)) add_reserved(out, *node.as_table(), kept);
    const auto* reserved = root.get("reserved");
    if (reserved != nullptr && is_ignored(*reserved, "reserved")) {
      std::ranges::copy(out.ignored, std::back_inserter(kept));
      std::ranges::copy(unoccupied(out.board, kept), std::back_inserter(out.ignored));
    }
    if (const auto* node = root.get("device")) {
      if (!node->is_array()) fail(*node, "device: each is a table, [[device]]");
      for (const auto& each : *node->as_array()) add_device(out, each);
    }
    if (const auto* node = root.get("pins")) {
      out.has_pins = true;
      pins(out.board, *node);
    }
    add_ignored(out.board, out.ignored);  // Devices stand behind windows, but behind none of these.
    return out;
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw BoardError(fmt::format("{}:{}: {}", file_, node.source().begin.line, what));
  }

  void allow(const toml::table& table, const std::string& prefix, std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, node] : table)
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
        fail(node, fmt::format("no such key {}{}; known are {}", prefix, key.str(), fmt::join(keys, ", ")));
  }

  std::string text(const toml::node& node, std::string_view key) const {
    if (!node.is_string()) fail(node, fmt::format("{}: text in quotes is expected", key));
    return node.as_string()->get();
  }

  c40::Word word(const toml::node& node, std::string_view key, std::int64_t most) const {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < 0 || value->get() > most)
      fail(node, fmt::format("{}: a whole number from 0 to {} is expected", key, most));
    return static_cast<c40::Word>(value->get());
  }

  void add(BoardDescription& description, const toml::node& node) const {
    c40::Board& board = description.board;
    if (!node.is_table()) fail(node, "region: each is a table, [[region]]");
    const toml::table& table = *node.as_table();
    const auto needed = [&](std::string_view key) -> const toml::node& {
      const auto* found = table.get(key);
      if (found == nullptr) fail(node, fmt::format("region {}: {} is missing", board.regions.size() + 1, key));
      return *found;
    };
    allow(
        table, "region.",
        {"name", "kind", "base", "words", "bus", "waits", "read_waits", "write_waits", "page_waits", "file", "width"});
    Region region;
    region.name = text(needed("name"), "region.name");
    region.base = word(needed("base"), "region.base", 0xFFFFFFFF);
    const auto* words = needed("words").as_integer();
    const std::int64_t room = (std::int64_t{1} << 32) - region.base;
    if (words == nullptr || words->get() < 1 || words->get() > room)
      fail(needed("words"),
           fmt::format("region.words of {}: 1 to {} words are possible from {:08X}h", region.name, room, region.base));
    region.words = static_cast<std::uint64_t>(words->get());
    if (const auto* kind = table.get("kind")) region.kind = kind_of(*kind, region);
    const bool window = region.kind == Region::Kind::external_window;
    if (!window && region.words > most_words)
      fail(needed("words"), fmt::format("region.words of {}: at most {} words of RAM", region.name, most_words));
    region.bus = bus_of(needed("bus"), region);
    for (const char* key : {"waits", "read_waits", "write_waits", "page_waits"})
      if (const auto* waits = table.get(key); window && waits != nullptr)
        fail(*waits,
             fmt::format("region.{} of {}: a window waits for its bus, and for nothing else", key, region.name));
    if (const auto* waits = table.get("waits"))
      region.read_waits = region.write_waits = wait_states(*waits, "region.waits");
    if (const auto* waits = table.get("read_waits")) region.read_waits = wait_states(*waits, "region.read_waits");
    if (const auto* waits = table.get("write_waits")) region.write_waits = wait_states(*waits, "region.write_waits");
    if (const auto* waits = table.get("page_waits")) region.page_waits = wait_states(*waits, "region.page_waits");
    check_place(board, region, node);
    if (const auto* file = table.get("file"))
      description.contents.push_back({region.base, contents(region, *file, table.get("width"))});
    else if (const auto* width = table.get("width"))
      fail(*width, fmt::format("region.width of {}: it is that of a file, and there is none", region.name));
    board.regions.push_back(std::move(region));
  }

  bool is_ignored(const toml::node& node, std::string_view key) const {
    const std::string what = text(node, key);
    if (what != "fault" && what != "ignore") fail(node, fmt::format("{}: fault or ignore is expected", key));
    return what == "ignore";
  }

  /// A region at which nothing is.
  static bool is_reserved(const toml::node& node) {
    const auto* table = node.as_table();
    const std::string kind = table == nullptr ? "" : (*table)["kind"].value_or(std::string());
    return kind == "fault" || kind == "ignore";
  }

  /// One of kind "fault" stays what it is, whatever the board's `reserved` says.
  void add_reserved(BoardDescription& description, const toml::table& table,
                    std::vector<c40::AddressRange>& kept) const {
    const toml::node& node = table;
    allow(table, "region.", {"name", "kind", "base", "words"});
    for (const char* key : {"name", "base", "words"})
      if (!table.contains(key))
        fail(node, fmt::format("region of kind \"{}\": {} is missing", *table["kind"].value<std::string>(), key));
    Region region;
    region.name = text(*table.get("name"), "region.name");
    region.base = word(*table.get("base"), "region.base", 0xFFFFFFFF);
    region.words = word(*table.get("words"), "region.words", (std::int64_t{1} << 32) - 1);
    const std::uint64_t end = region.base + region.words;
    if (region.words == 0 || end > std::uint64_t{1} << 32)
      fail(*table.get("words"), fmt::format("region.words of {}: 1 to {} words are possible from {:08X}h", region.name,
                                            (std::uint64_t{1} << 32) - region.base, region.base));
    c40::Board others = description.board;
    add_ignored(others, kept);
    add_ignored(others, description.ignored);
    const bool free = std::ranges::any_of(unoccupied(others, {}), [&](const c40::AddressRange& gap) {
      return region.base >= gap.first && end <= std::uint64_t{gap.first} + gap.words;
    });
    if (!free)
      fail(node, fmt::format("region {} ({:08X}h, {} words): another region, the boot ROM, or something of the chip's "
                             "own is there",
                             region.name, region.base, region.words));
    (is_ignored(*table.get("kind"), "region.kind") ? description.ignored : kept)
        .push_back({region.base, static_cast<c40::Word>(region.words)});
  }

  /// The image of a ROM, beside the board file.
  std::vector<c40::Word> contents(const Region& region, const toml::node& file, const toml::node* width) const {
    if (region.kind == Region::Kind::external_window)
      fail(file, fmt::format("region.file of {}: a window holds nothing by itself", region.name));
    const std::filesystem::path given = text(file, "region.file");
    const std::filesystem::path path = given.is_absolute() ? given : std::filesystem::path(file_).parent_path() / given;
    try {
      const auto bytes = toolchain::read_rom(path);
      std::optional<unsigned> bits = toolchain::boot_width(bytes);
      if (width != nullptr) bits = word(*width, "region.width", 32);
      if (!bits || (*bits != 8 && *bits != 16 && *bits != 32))
        fail(width != nullptr ? *width : file,
             fmt::format("region.width of {}: 8, 16 or 32 is expected; the file does not say it", region.name));
      std::vector<c40::Word> words = toolchain::rom_words(bytes, *bits);
      if (words.size() > region.words)
        fail(file,
             fmt::format("region.file of {}: {} words do not go into {}", region.name, words.size(), region.words));
      return words;
    } catch (const toolchain::RomError& error) {
      fail(file, fmt::format("region.file of {}: {}", region.name, error.what()));
    }
  }

  void add_device(BoardDescription& description, const toml::node& node) const {
    if (!node.is_table()) fail(node, "device: each is a table, [[device]]");
    const toml::table& table = *node.as_table();
    const auto needed = [&](std::string_view key) -> const toml::node& {
      const auto* found = table.get(key);
      if (found == nullptr) fail(node, fmt::format("device {}: {} is missing", description.devices.size() + 1, key));
      return *found;
    };
    allow(table, "device.", {"name", "kind", "base", "words", "waits", "value"});
    DeviceDescription device;
    device.name = text(needed("name"), "device.name");
    const auto kind = device_kind_named(text(needed("kind"), "device.kind"));
    if (!kind)
      fail(needed("kind"), fmt::format("device.kind of {}: console, registers or led is expected", device.name));
    device.kind = *kind;
    device.base = word(needed("base"), "device.base", 0xFFFFFFFF);
    if (device.kind == DeviceKind::console) device.words = 2;
    if (const auto* words = table.get("words")) {
      if (device.kind == DeviceKind::console)
        fail(*words, fmt::format("device.words of {}: a console has its 2 words", device.name));
      device.words = word(*words, "device.words", most_device_words);
      if (device.words == 0)
        fail(*words, fmt::format("device.words of {}: 1 to {} words are possible", device.name, most_device_words));
    }
    if (const auto* waits = table.get("waits"))
      device.waits = static_cast<int>(word(*waits, "device.waits", 1'000'000));
    if (const auto* value = table.get("value")) {
      if (device.kind == DeviceKind::console)
        fail(*value, fmt::format("device.value of {}: a console holds nothing", device.name));
      device.value = word(*value, "device.value", 0xFFFFFFFF);
    }
    const std::uint64_t end = std::uint64_t{device.base} + device.words;
    const auto& regions = description.board.regions;
    const bool behind_window = std::ranges::any_of(regions, [&](const Region& region) {
      return region.kind == Region::Kind::external_window && device.base >= region.base &&
             end <= std::uint64_t{region.base} + region.words;
    });
    if (!behind_window)
      fail(needed("base"), fmt::format("device.base of {}: a device stands behind a [[region]] of kind \"window\", and "
                                       "none has {:08X}h to {:08X}h",
                                       device.name, device.base, end - 1));
    for (const DeviceDescription& other : description.devices)
      if (device.base < std::uint64_t{other.base} + other.words && other.base < end)
        fail(needed("base"), fmt::format("device.base of {}: {} is there", device.name, other.name));
    description.devices.push_back(std::move(device));
  }

  // c40-hardware.md 1.2, 9.1
  void pins(c40::Board& board, const toml::node& node) const {
    if (!node.is_table()) fail(node, "pins: a table, [pins], is expected");
    const toml::table& table = *node.as_table();
    allow(table, "pins.", {"romen", "resetloc", "iiof"});
    bool rom = false;
    if (const auto* romen = table.get("romen")) {
      if (!romen->is_boolean()) fail(*romen, "pins.romen: true (the boot ROM is at 0) or false is expected");
      rom = romen->as_boolean()->get();
    }
    c40::Board::Pins tied;
    if (const auto* location = table.get("resetloc"))
      tied.reset_location = static_cast<int>(word(*location, "pins.resetloc", 3));
    if (const auto* levels = table.get("iiof")) tied.iiof = levels_of(*levels);
    if (rom) {
      for (const Region& region : board.regions)
        if (region.base < c40::rom_words)
          fail(node, fmt::format("pins.romen: the boot ROM is at 0 to FFFh, and so is region {}", region.name));
      board.rom = with_boot_from_port({}).rom;
    }
    board.pins = tied;
    if (!rom || tied.reset_location != 0) return;
    if ((tied.iiof & 1) == 0)
      fail(
          node,
          "pins.iiof: the last level, IIOF0, must be 1 for the boot loader, which romen = true and resetloc = 0 start");
    if (tied.iiof >> 1 == 0)
      fail(node,
           "pins.iiof: 000 of IIOF3 to IIOF1 is reserved; the boot loader would read the pins for ever. 111 means the "
           "communication ports");
  }

  /// "1101": IIOF3 to IIOF0.
  c40::Word levels_of(const toml::node& node) const {
    const std::string levels = text(node, "pins.iiof");
    if (levels.size() != 4 || levels.find_first_not_of("01") != std::string::npos)
      fail(node, "pins.iiof: the levels of IIOF3 to IIOF0 are expected, as \"1111\"");
    return static_cast<c40::Word>(std::stoul(levels, nullptr, 2));
  }

  // The address decides which bus the chip drives (c40-hardware.md 1.1).
  Region::Bus bus_of(const toml::node& node, const Region& region) const {
    const std::string bus = text(node, "region.bus");
    if (bus != "local" && bus != "global")
      fail(node, fmt::format("region.bus of {}: local or global is expected", region.name));
    const bool upper = region.base >= 0x80000000u;
    const std::uint64_t end = region.base + region.words;
    if (upper != (bus == "global") || (!upper && end > 0x80000000ull))
      fail(node, fmt::format("region.bus of {}: the local bus is below 80000000h, the global bus from there on",
                             region.name));
    return bus == "local" ? Region::Bus::local : Region::Bus::global;
  }

  Region::Kind kind_of(const toml::node& node, const Region& region) const {
    const std::string kind = text(node, "region.kind");
    if (kind != "ram" && kind != "window")
      fail(node,
           fmt::format("region.kind of {}: ram, window (to a shared bus), fault or ignore is expected", region.name));
    return kind == "ram" ? Region::Kind::ram : Region::Kind::external_window;
  }

  int wait_states(const toml::node& node, std::string_view key) const {
    return static_cast<int>(word(node, key, c40::timing::max_region_waits));
  }

  void check_place(const c40::Board& board, const Region& region, const toml::node& node) const {
    const std::uint64_t end = region.base + region.words;
    if (region.base < first_external && end > chip_begin)
      fail(node,
           fmt::format(
               "region.base of {}: {:08X}h to {:08X}h are the chip's own; a board has what lies before and behind",
               region.name, chip_begin, first_external - 1));
    for (const Region& other : board.regions)
      if (region.base < other.base + other.words && other.base < end)
        fail(node, fmt::format("region {} ({:08X}h, {} words) overlaps {} ({:08X}h, {} words)", region.name,
                               region.base, region.words, other.name, other.base, other.words));
  }

  static constexpr Address chip_begin = 0x00100000u, first_external = 0x00300000u;
  static constexpr std::int64_t most_device_words = 1 << 20;
  static constexpr std::uint64_t most_words = std::uint64_t{1} << 28;
  static constexpr double slowest_mhz = 0.001, fastest_mhz = 1000;
  std::string file_;
};

}  // namespace

BoardDescription read_board(const std::string& name) {
  if (name == "default") return {.board = c40::Board::default_board()};
  if (name == "flat") return {.board = c40::Board::flat()};
  if (!name.ends_with(".toml"))
    throw BoardError(fmt::format("there is no board \"{}\"; default, flat and files that end in .toml are", name));
  const std::string text = io::read_file<BoardError>(name, "a board file (docs/cli.md)");
  try {
    return BoardReader(name).read(io::parse_toml(text, name));
  } catch (const toml::parse_error& error) {
    throw BoardError(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
}

void refuse_devices(const BoardDescription& board, std::string_view where) {
  if (!board.devices.empty())
    throw BoardError(
        fmt::format("board {}: device: {} has no devices of a board; a program alone has (exec, cmrc.c40.Processor)",
                    board.board.name, where));
  if (!board.contents.empty())
    throw BoardError(
        fmt::format("board {}: region.file: {} loads no ROMs; a program alone does (exec, cmrc.c40.Processor)",
                    board.board.name, where));
}

void refuse_ignored(const BoardDescription& board) {
  if (!board.ignored.empty())
    throw BoardError(fmt::format(
        "board {}: reserved: a DSP of the dock stops at addresses without memory; \"ignore\" is for programs "
        "alone and networks",
        board.board.name));
}

std::int64_t instruction_cycles_per_second(double clock_mhz) { return std::llround(clock_mhz * 1e6 / 2); }

namespace {

/// \param reach words that the board's window must at least have
void require_window(const c40::Board& board, char bus, Address base, std::uint64_t reach) {
  for (const Region& region : board.regions) {
    if (region.kind != Region::Kind::external_window || region.base != base) continue;
    if (region.words >= reach) return;
    throw BoardError(
        fmt::format("board {}: region.words of {}: the window to bus {} has {} words; what answers on the bus needs {}",
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
