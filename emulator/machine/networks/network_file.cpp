#include "machine/networks/network_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <vector>

#include "io/text_form.hpp"
#include "io/toml_reader.hpp"

namespace machine {
namespace {

using Keys = std::vector<std::string_view>;

const Keys root_keys{"chip", "topology", "link", "memory", "net", "event"};
const Keys chip_keys{"number", "name", "program", "board", "clock_mhz", "entry", "until", "boot"};
const Keys topology_keys{"links", "program", "board", "clock_mhz", "entry", "until", "boot"};
const Keys link_keys{"ports", "word_cycles", "token_cycles", "enter_cycles", "exit_cycles"};
const Keys memory_keys{"name", "kind", "words", "waits", "place"};
const Keys place_keys{"chip", "base", "pin"};
const Keys net_keys{"name", "drivers", "receivers", "open_drain", "rest"};
const Keys event_keys{"at_us", "action", "link", "chip", "net", "width_us", "period_us", "count"};

/// Reads in three steps: chips; what connects them, by their names; events, by the names of both. Each step ends with
/// all errors that it has found. So an error is never the consequence of another one.
class NetworkReader {
 public:
  NetworkReader(std::string file, const ProgramReader& read_program)
      : toml_(std::move(file)), read_program_(read_program) {}

  NetworkDescription read(const toml::table& root) {
    toml_.allow(root, "", root_keys);
    chips(root);
    toml_.finish<NetworkError>();
    toml_.each(root, "link", [&](const toml::table& table) { link(table); });
    toml_.each(root, "memory", [&](const toml::table& table) { memory(table); });
    toml_.each(root, "net", [&](const toml::table& table) { net(table); });
    toml_.finish<NetworkError>();
    toml_.each(root, "event", [&](const toml::table& table) { event(table); });
    toml_.finish<NetworkError>();
    return std::move(network_);
  }

 private:
  /// Adds the line to an error of `ask`.
  template <class Ask>
  auto checked(const toml::node& node, std::string_view prefix, Ask&& ask) {
    try {
      return ask();
    } catch (const std::invalid_argument& error) {
      toml_.fail(node, fmt::format("{}{}", prefix, error.what()));
    }
  }

  void chips(const toml::table& root) {
    bool generated = false;
    if (const auto* topology = root.get("topology"))
      toml_.attempt([&] {
        generated = true;
        generate(*topology);
      });
    toml_.each(root, "chip", [&](const toml::table& table) { chip(table, generated); });
    if (network_.chips.empty() && !generated)
      toml_.note("there is no chip; [[chip]] with a program, or [topology], is expected");
    for (const NetworkChip& chip : network_.chips) {
      const std::size_t n = names_.size();
      if (!given_[n].has_program && !chip.boot)
        toml_.note(*given_[n].table, fmt::format("chip {} has no program, and does not boot; program = \"FILE\" or "
                                                 "boot = true is expected",
                                                 n));
      names_.push_back(chip.name.empty() ? std::to_string(n) : chip.name);
    }
  }

  toolchain::Address address(const toml::node& node, std::string_view key, const NetworkChip& chip) {
    const std::string given = toml_.text(node, key);
    const auto found = toolchain::find_address(given, chip.program.get());
    if (!found) toml_.fail(node, fmt::format("{}: {}", key, toolchain::no_address(given, chip.program.get())));
    return *found;
  }

  std::shared_ptr<const toolchain::Image> program(const toml::node& node) {
    const std::string path = toml_.beside(toml_.text(node, "program"));
    if (std::error_code error; !std::filesystem::exists(path, error))
      toml_.fail(node, fmt::format("program: there is no file {}", path));
    auto& known = programs_[path];
    if (known == nullptr) known = std::make_shared<toolchain::Image>(read_program_(path));
    return known;
  }

  BoardDescription board(const toml::node& node) {
    const std::string given = toml_.text(node, "board");
    const bool is_file = given.ends_with(".toml");
    const std::string name = is_file ? toml_.beside(given) : given;
    if (std::error_code error; is_file && std::filesystem::exists(name, error))
      return read_board(name);  // its errors name the board file and lines
    return checked(node, "", [&] { return read_board(name); });
  }

  void fill(NetworkChip& chip, const toml::table& table) {
    toml_.optional(table, "name", [&](const toml::node& node) { chip.name = toml_.text(node, "name"); });
    toml_.optional(table, "program", [&](const toml::node& node) { chip.program = program(node); });
    toml_.optional(table, "board", [&](const toml::node& node) { chip.board = board(node); });
    toml_.optional(table, "clock_mhz", [&](const toml::node& node) {
      chip.clock_mhz = toml_.real(node, "clock_mhz", slowest_mhz, fastest_mhz);
    });
    toml_.optional(table, "boot", [&](const toml::node& node) { chip.boot = toml_.truth(node, "boot"); });
    if (table.contains("program") && chip.program == nullptr) return;  // its symbols are unknown
    toml_.optional(table, "entry", [&](const toml::node& node) { chip.entry = address(node, "entry", chip); });
    toml_.optional(table, "until", [&](const toml::node& node) { chip.until = address(node, "until", chip); });
  }

  void generate(const toml::node& node) {
    if (!node.is_table()) toml_.fail(node, "topology: a table, [topology], is expected");
    const toml::table& table = *node.as_table();
    toml_.allow(table, "topology.", topology_keys);
    NetworkChip chip;
    fill(chip, table);
    toml_.needed(table, "links", "topology", [&](const toml::node& links) {
      const std::string text = toml_.text(links, "topology.links");
      network_.chips.assign(checked(links, "topology.links: ", [&] { return set_topology(network_, text); }), chip);
      given_.assign(network_.chips.size(), {&table, table.contains("program")});
    });
  }

  void chip(const toml::table& table, bool generated) {
    toml_.allow(table, "chip.", chip_keys);
    if (generated) {
      if (network_.chips.empty()) return;  // the topology had an error
      toml_.needed(table, "number", "chip", [&](const toml::node& number) {
        const auto last = static_cast<std::int64_t>(network_.chips.size()) - 1;
        const auto n = static_cast<std::size_t>(toml_.whole(number, "chip.number", 0, last));
        given_[n].has_program |= table.contains("program");
        fill(network_.chips[n], table);
      });
      return;
    }
    toml_.optional(table, "number", [&](const toml::node& number) {
      toml_.fail(number,
                 "chip.number: chips are numbered in the order of the file; a number is possible only with [topology]");
    });
    given_.push_back({&table, table.contains("program")});
    fill(network_.chips.emplace_back(), table);
  }

  void link(const toml::table& table) {
    toml_.allow(table, "link.", link_keys);
    c40::LinkParameters given;
    for (const auto& [key, value] : {std::pair{"word_cycles", &given.word_cycles},
                                     {"token_cycles", &given.token_cycles},
                                     {"enter_cycles", &given.enter_cycles},
                                     {"exit_cycles", &given.exit_cycles}})
      toml_.optional(table, key, [&, &key = key, &value = value](const toml::node& node) {
        *value = static_cast<int>(toml_.whole(node, key, 0, 1'000'000));
      });
    toml_.needed(table, "ports", "link", [&](const toml::node& ports) {
      const std::string text = toml_.text(ports, "link.ports");
      checked(ports, "", [&] {
        std::vector<NetworkLink> links = network_.links;
        links.push_back(parse_link(text, names_));
        links.back().parameters = given;
        check(links, names_.size());
        network_.links = std::move(links);
      });
    });
  }

  std::size_t chip_at(const toml::node& node) {
    if (node.is_integer())
      return static_cast<std::size_t>(toml_.whole(node, "chip", 0, static_cast<std::int64_t>(names_.size()) - 1));
    const std::string text = toml_.text(node, "chip");
    return checked(node, "", [&] { return chip_named(text, names_); });
  }

  void memory(const toml::table& table) {
    toml_.allow(table, "memory.", memory_keys);
    SharedMemory memory;
    toml_.needed(table, "name", "memory",
                 [&](const toml::node& node) { memory.name = toml_.text(node, "memory.name"); });
    toml_.needed(table, "words", "memory", [&](const toml::node& node) {
      memory.words = static_cast<c40::Address>(toml_.whole(node, "memory.words", 1, 1 << 24));
    });
    toml_.optional(table, "waits", [&](const toml::node& node) {
      memory.waits = static_cast<int>(toml_.whole(node, "memory.waits", 0, 1000));
    });
    toml_.optional(table, "kind", [&](const toml::node& node) {
      const std::string given = toml_.text(node, "memory.kind");
      if (given != "shared" && given != "dual-port")
        toml_.fail(node, "memory.kind: \"shared\" or \"dual-port\" is expected");
      memory.dual_port = given == "dual-port";
    });
    toml_.each(table, "place", [&](const toml::table& place) { add_place(memory, place); });
    network_.memories.push_back(std::move(memory));
  }

  void add_place(SharedMemory& memory, const toml::table& table) {
    toml_.allow(table, "memory.place.", place_keys);
    auto& pin = memory.pins.emplace_back();
    toml_.optional(table, "pin", [&](const toml::node& node) {
      pin = interrupt_pin_named(toml_.text(node, "memory.place.pin"));
      if (!pin) toml_.fail(node, "memory.place.pin: IIOF0 to IIOF3 or NMI is expected");
    });
    auto& place = memory.places.emplace_back();
    toml_.needed(table, "chip", "memory.place", [&](const toml::node& node) { place.first = chip_at(node); });
    toml_.needed(table, "base", "memory.place", [&](const toml::node& node) {
      place.second = static_cast<c40::Address>(toml_.whole(node, "memory.place.base", 0, 0xFFFFFFFF));
    });
  }

  std::vector<ChipPin> pins(const toml::node& node, std::string_view key) {
    std::vector<ChipPin> found;
    const auto pin = [&](const toml::node& one) {
      const std::string text = toml_.text(one, key);
      found.push_back(checked(one, fmt::format("{}: ", key), [&] { return parse_pin(text, names_); }));
    };
    if (const auto* all = node.as_array()) {
      for (const toml::node& one : *all) toml_.attempt([&] { pin(one); });
    } else {
      pin(node);
    }
    return found;
  }

  void net(const toml::table& table) {
    toml_.allow(table, "net.", net_keys);
    NetDescription net;
    net.name = fmt::format("{}", network_.nets.size());
    toml_.optional(table, "name", [&](const toml::node& node) { net.name = toml_.text(node, "net.name"); });
    toml_.optional(table, "drivers", [&](const toml::node& node) { net.drivers = pins(node, "net.drivers"); });
    toml_.optional(table, "open_drain",
                   [&](const toml::node& node) { net.open_drain = toml_.truth(node, "net.open_drain"); });
    toml_.optional(table, "rest", [&](const toml::node& node) {
      const std::string level = toml_.text(node, "net.rest");
      if (level != "high" && level != "low") toml_.fail(node, "net.rest: \"high\" or \"low\" is expected");
      net.rest = level == "high";
    });
    toml_.needed(table, "receivers", "net",
                 [&](const toml::node& node) { net.receivers = pins(node, "net.receivers"); });
    if (net.receivers.empty()) return;
    checked(table, "", [&] {
      std::vector<NetDescription> nets = network_.nets;
      nets.push_back(std::move(net));
      check(nets, names_.size());
      network_.nets = std::move(nets);
    });
  }

  void event(const toml::table& table) {
    toml_.allow(table, "event.", event_keys);
    NetworkAction action;
    toml_.needed(table, "at_us", "event", [&](const toml::node& node) {
      action.time = Time{std::llround(toml_.real(node, "event.at_us", 0, 1e12) * 1e6)};
    });
    toml_.needed(table, "action", "event", [&](const toml::node& node) {
      const std::string text = toml_.text(node, "event.action");
      action.kind = checked(node, "", [&] { return action_named(text); });
      toml_.attempt([&] { target(table, action); });
      pulses(table, action);
      network_.actions.push_back(action);
    });
  }

  void target(const toml::table& table, NetworkAction& action) {
    const std::string key(name(target_of(action.kind)));
    for (const char* other : {"link", "chip", "net"})
      if (key != other && table.contains(other))
        toml_.fail(*table.get(other), fmt::format("event: {} needs a {}", name(action.kind), key));
    toml_.needed(table, key, "event", [&](const toml::node& node) {
      if (node.is_integer() && key == "chip") {
        action.target = chip_at(node);
        return;
      }
      const std::string text = toml_.text(node, "event." + key);
      action.target = checked(node, "", [&] { return action_target_named(action.kind, text, network_); });
    });
  }

  void pulses(const toml::table& table, NetworkAction& action) {
    if (action.kind != NetworkAction::Kind::pulse) {
      for (const char* key : {"width_us", "period_us", "count"})
        if (const auto* given = table.get(key)) toml_.note(*given, fmt::format("event.{}: only a pulse has one", key));
      return;
    }
    double width = 0;
    std::optional<double> period;
    std::optional<std::uint64_t> count;
    toml_.needed(table, "width_us", "event",
                 [&](const toml::node& node) { width = toml_.real(node, "event.width_us", 0, 1e12); });
    toml_.optional(table, "period_us",
                   [&](const toml::node& node) { period = toml_.real(node, "event.period_us", 0, 1e12); });
    toml_.optional(table, "count", [&](const toml::node& node) {
      count = static_cast<std::uint64_t>(toml_.whole(node, "event.count", 1, 1'000'000'000));
    });
    set_pulses(action, width, period, count);
  }

  io::TomlReader toml_;
  const ProgramReader& read_program_;
  NetworkDescription network_;
  struct Given {
    const toml::table* table;
    bool has_program;
  };
  std::vector<Given> given_;        ///< where the file describes each chip
  std::vector<std::string> names_;  ///< of the chips
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
