#include "machine/network_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <vector>

#include "io/nearest.hpp"
#include "io/text_form.hpp"
#include "io/toml.hpp"

namespace machine {
namespace {

constexpr std::array<std::string_view, 8> chip_keys{"number",    "name",  "program", "board",
                                                    "clock_mhz", "entry", "until",   "boot"};

class NetworkReader {
 public:
  NetworkReader(std::string file, const ProgramReader& read_program)
      : file_(std::move(file)), read_program_(read_program) {}

  NetworkDescription read(const toml::table& root) {
    allow(root, {"chip", "topology", "link", "memory", "net", "event"}, "");
    const auto* topology = root.get("topology");
    if (topology != nullptr) generate(*topology);
    each(root, "chip",
         [&](const toml::table& table, const toml::node& node) { chip(table, node, topology != nullptr); });
    if (network_.chips.empty())
      throw NetworkError(
          fmt::format("{}: there is no chip; [[chip]] with a program, or [topology], is expected", file_));
    for (const NetworkChip& chip : network_.chips)
      names_.push_back(chip.name.empty() ? std::to_string(names_.size()) : chip.name);
    for (std::size_t n = 0; n < network_.chips.size(); ++n)
      if (network_.chips[n].program == nullptr && !network_.chips[n].boot)
        throw NetworkError(fmt::format("{}: chip {} has no program, and does not boot", file_, n));
    each(root, "link", [&](const toml::table& table, const toml::node& node) { link(table, node); });
    each(root, "memory", [&](const toml::table& table, const toml::node& node) { memory(table, node); });
    each(root, "net", [&](const toml::table& table, const toml::node& node) { net(table, node); });
    each(root, "event", [&](const toml::table& table, const toml::node& node) { event(table, node); });
    return std::move(network_);
  }

 private:
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw NetworkError(fmt::format("{}:{}: {}", file_, node.source().begin.line, what));
  }

  /// Adds the line to an error of `ask`.
  template <class Ask>
  auto checked(const toml::node& node, Ask&& ask) const {
    try {
      return ask();
    } catch (const NetworkError& error) {
      const std::string what = error.what();
      if (what.starts_with(file_)) throw;
      fail(node, what);
    }
  }

  void allow(const toml::table& table, const std::vector<std::string_view>& keys, const std::string& prefix) const {
    for (const auto& [key, node] : table)
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end())
        fail(node, fmt::format("no such key {}{}; known are {}{}", prefix, key.str(), fmt::join(keys, ", "),
                               io::did_you_mean(key.str(), keys)));
  }

  template <class Do>
  void each(const toml::table& root, const char* key, Do&& action) {
    const auto* all = root.get(key);
    if (all == nullptr) return;
    if (!all->is_array()) fail(*all, fmt::format("{}: each is a table, [[{}]]", key, key));
    for (const auto& node : *all->as_array()) {
      if (!node.is_table()) fail(node, fmt::format("{}: each is a table, [[{}]]", key, key));
      action(*node.as_table(), node);
    }
  }

  std::string text(const toml::node& node, std::string_view key) const {
    if (!node.is_string()) fail(node, fmt::format("{}: text in quotes is expected", key));
    return node.as_string()->get();
  }

  std::int64_t number(const toml::node& node, std::string_view key, std::int64_t least, std::int64_t most) const {
    const auto* value = node.as_integer();
    if (value == nullptr || value->get() < least || value->get() > most)
      fail(node, fmt::format("{}: an integer from {} to {} is expected", key, least, most));
    return value->get();
  }

  double real(const toml::node& node, std::string_view key, double most) const {
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !(*value >= 0) || *value > most)
      fail(node, fmt::format("{}: a number from 0 to {} is expected", key, most));
    return *value;
  }

  const toml::node& needed(const toml::table& table, const toml::node& node, const char* key, const char* of) const {
    const auto* found = table.get(key);
    if (found == nullptr) fail(node, fmt::format("{}: {} is missing", of, key));
    return *found;
  }

  std::string beside(const std::string& path) const {
    return (std::filesystem::path(file_).parent_path() / path).string();
  }

  toolchain::Address address(const toml::node& node, const char* key, const NetworkChip& chip) const {
    const std::string given = text(node, key);
    const auto found = toolchain::find_address(given, chip.program.get());
    if (!found) fail(node, fmt::format("{}: {}", key, toolchain::no_address(given, chip.program.get())));
    return *found;
  }

  void fill(NetworkChip& chip, const toml::table& table) {
    if (const auto* node = table.get("name")) chip.name = text(*node, "name");
    if (const auto* node = table.get("program")) {
      const std::string path = beside(text(*node, "program"));
      auto& known = programs_[path];
      if (known == nullptr) known = std::make_shared<toolchain::Image>(read_program_(path));
      chip.program = known;
    }
    if (const auto* node = table.get("board")) {
      const std::string board = text(*node, "board");
      try {
        chip.board = read_board(board.ends_with(".toml") ? beside(board) : board);
      } catch (const BoardError& error) {
        if (board.ends_with(".toml")) throw;  // it names the board file and its lines
        fail(*node, error.what());
      }
    }
    if (const auto* node = table.get("clock_mhz")) chip.clock_mhz = real(*node, "clock_mhz", 1000);
    if (const auto* node = table.get("boot")) {
      if (!node->is_boolean()) fail(*node, "boot: true or false is expected");
      chip.boot = node->as_boolean()->get();
    }
    if (const auto* node = table.get("entry")) chip.entry = address(*node, "entry", chip);
    if (const auto* node = table.get("until")) chip.until = address(*node, "until", chip);
  }

  void generate(const toml::node& node) {
    if (!node.is_table()) fail(node, "topology: a table, [topology], is expected");
    const toml::table& table = *node.as_table();
    allow(table, {"links", "program", "board", "clock_mhz", "entry", "until", "boot"}, "topology.");
    NetworkChip chip;
    fill(chip, table);
    const toml::node& links = needed(table, node, "links", "topology");
    network_.chips.assign(checked(links, [&] { return set_topology(network_, text(links, "topology.links")); }), chip);
  }

  void chip(const toml::table& table, const toml::node& node, bool generated) {
    allow(table, {chip_keys.begin(), chip_keys.end()}, "chip.");
    if (!generated) {
      if (const auto* given = table.get("number"))
        fail(*given,
             "chip.number: chips are numbered in the order of the file; a number is possible only with [topology]");
      network_.chips.emplace_back();
      return fill(network_.chips.back(), table);
    }
    const auto n = number(needed(table, node, "number", "chip"), "chip.number", 0,
                          static_cast<std::int64_t>(network_.chips.size()) - 1);
    fill(network_.chips[static_cast<std::size_t>(n)], table);
  }

  void link(const toml::table& table, const toml::node& node) {
    allow(table, {"ports", "word_cycles", "token_cycles", "enter_cycles", "exit_cycles"}, "link.");
    const toml::node& ports = needed(table, node, "ports", "link");
    NetworkLink link = checked(ports, [&] { return parse_link(text(ports, "link.ports"), names_); });
    c40::LinkParameters& p = link.parameters;
    for (const auto& [key, value] : {std::pair{"word_cycles", &p.word_cycles},
                                     {"token_cycles", &p.token_cycles},
                                     {"enter_cycles", &p.enter_cycles},
                                     {"exit_cycles", &p.exit_cycles}})
      if (const auto* given = table.get(key)) *value = static_cast<int>(number(*given, key, 0, 1'000'000));
    network_.links.push_back(link);
  }

  std::size_t chip_at(const toml::node& node) const {
    if (node.is_integer())
      return static_cast<std::size_t>(number(node, "chip", 0, static_cast<std::int64_t>(names_.size()) - 1));
    return checked(node, [&] { return chip_named(text(node, "chip"), names_); });
  }

  void memory(const toml::table& table, const toml::node& node) {
    allow(table, {"name", "kind", "words", "waits", "place"}, "memory.");
    SharedMemory memory;
    memory.name = text(needed(table, node, "name", "memory"), "memory.name");
    memory.words =
        static_cast<c40::Address>(number(needed(table, node, "words", "memory"), "memory.words", 1, 1 << 24));
    if (const auto* waits = table.get("waits"))
      memory.waits = static_cast<int>(number(*waits, "memory.waits", 0, 1000));
    if (const auto* kind = table.get("kind")) {
      const std::string given = text(*kind, "memory.kind");
      if (given != "shared" && given != "dual-port")
        fail(*kind, "memory.kind: \"shared\" or \"dual-port\" is expected");
      memory.dual_port = given == "dual-port";
    }
    each(table, "place", [&](const toml::table& place, const toml::node& at) {
      allow(place, {"chip", "base", "pin"}, "memory.place.");
      auto& pin = memory.pins.emplace_back();
      if (const auto* given = place.get("pin")) {
        pin = interrupt_pin_named(text(*given, "memory.place.pin"));
        if (!pin) fail(*given, "memory.place.pin: IIOF0 to IIOF3 or NMI is expected");
      }
      memory.places.emplace_back(chip_at(needed(place, at, "chip", "memory.place")),
                                 static_cast<c40::Address>(number(needed(place, at, "base", "memory.place"),
                                                                  "memory.place.base", 0, 0xFFFFFFFF)));
    });
    network_.memories.push_back(std::move(memory));
  }

  std::vector<ChipPin> pins(const toml::node& node, const char* key) const {
    std::vector<ChipPin> found;
    const auto pin = [&](const toml::node& one) {
      try {
        found.push_back(parse_pin(text(one, key), names_));
      } catch (const NetworkError&) {
        throw;
      } catch (const std::invalid_argument& error) {
        fail(one, fmt::format("{}: {}", key, error.what()));
      }
    };
    if (const auto* all = node.as_array()) {
      for (const toml::node& one : *all) pin(one);
    } else {
      pin(node);
    }
    return found;
  }

  void net(const toml::table& table, const toml::node& node) {
    allow(table, {"name", "drivers", "receivers", "open_drain", "rest"}, "net.");
    NetDescription net;
    if (const auto* name = table.get("name")) net.name = text(*name, "net.name");
    if (const auto* drivers = table.get("drivers")) net.drivers = pins(*drivers, "net.drivers");
    net.receivers = pins(needed(table, node, "receivers", "net"), "net.receivers");
    if (const auto* open = table.get("open_drain")) {
      if (!open->is_boolean()) fail(*open, "net.open_drain: true or false is expected");
      net.open_drain = open->as_boolean()->get();
    }
    if (const auto* rest = table.get("rest")) {
      const std::string level = text(*rest, "net.rest");
      if (level != "high" && level != "low") fail(*rest, "net.rest: \"high\" or \"low\" is expected");
      net.rest = level == "high";
    }
    if (net.name.empty()) net.name = fmt::format("{}", network_.nets.size());
    network_.nets.push_back(std::move(net));
    try {
      check(network_.nets, names_.size());
    } catch (const std::invalid_argument& error) {
      fail(node, error.what());
    }
  }

  void event(const toml::table& table, const toml::node& node) {
    allow(table, {"at_us", "action", "link", "chip", "net", "width_us", "period_us", "count"}, "event.");
    NetworkAction action;
    action.time = Time{std::llround(real(needed(table, node, "at_us", "event"), "event.at_us", 1e12) * 1e6)};
    const toml::node& what = needed(table, node, "action", "event");
    action.kind = checked(what, [&] { return action_named(text(what, "event.action")); });
    const std::string key(name(target_of(action.kind)));
    for (const char* other : {"link", "chip", "net"})
      if (key != other && table.contains(other))
        fail(node, fmt::format("event: {} needs a {}", name(action.kind), key));
    const toml::node& target = needed(table, node, key.c_str(), "event");
    action.target = target.is_integer() && key == "chip" ? chip_at(target) : checked(target, [&] {
      return action_target_named(action.kind, text(target, "event." + key), network_);
    });
    pulses(table, node, action);
    network_.actions.push_back(action);
  }

  void pulses(const toml::table& table, const toml::node& node, NetworkAction& action) const {
    if (action.kind != NetworkAction::Kind::pulse) {
      for (const char* key : {"width_us", "period_us", "count"})
        if (const auto* given = table.get(key)) fail(*given, fmt::format("event.{}: only a pulse has one", key));
      return;
    }
    const double width = real(needed(table, node, "width_us", "event"), "event.width_us", 1e12);
    std::optional<double> period;
    std::optional<std::uint64_t> count;
    if (const auto* given = table.get("period_us")) period = real(*given, "event.period_us", 1e12);
    if (const auto* given = table.get("count"))
      count = static_cast<std::uint64_t>(number(*given, "event.count", 1, 1'000'000'000));
    set_pulses(action, width, period, count);
  }

  std::string file_;
  const ProgramReader& read_program_;
  NetworkDescription network_;
  std::vector<std::string> names_;
  std::map<std::string, std::shared_ptr<const toolchain::Image>> programs_;
};

}  // namespace

NetworkDescription read_network(const std::string& path, const ProgramReader& read_program) {
  const std::string text = io::read_text<NetworkError>(path, "a network file (docs/networks.md)");
  try {
    return NetworkReader(path, read_program).read(io::parse_toml(text, path));
  } catch (const toml::parse_error& error) {
    throw NetworkError(fmt::format("{}:{}: {}", path, error.source().begin.line, error.description()));
  }
}

}  // namespace machine
