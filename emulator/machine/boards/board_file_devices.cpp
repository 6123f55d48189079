// [[device]] tables of a board file.
#include <filesystem>

#include "io/text_form.hpp"
#include "isa/ascii.hpp"
#include "machine/boards/board_devices.hpp"
#include "machine/boards/board_toml.hpp"
#include "state/sha256.hpp"

namespace machine {
namespace {

bool has_key(const DeviceKindRow& row, std::string_view key) {
  const auto keys = ascii::words(row.keys, " ");
  return std::ranges::find(keys, key) != keys.end();
}

class DeviceReader {
 public:
  DeviceReader(BoardToml& toml, BoardDescription& board) : toml_(toml), board_(board) {}

  void read(const toml::table& table) {
    device_.name = std::to_string(board_.devices.size() + 1);  // for errors, if it has no name
    const std::string device = "device " + device_.name;
    toml_.needed(table, "name", device, [&](const toml::node& name) { name_of(name); });
    const DeviceKindRow& row = kind(table, device);
    device_.words = std::max<c40::Address>(row.words, 1);
    std::vector<std::string_view> keys{"name", "kind", "base", "waits"};
    for (const std::string_view key : ascii::words(row.keys, " ")) keys.push_back(key);
    unknown_keys(table, row, keys);
    parameters(table, row, device);
    input(table);
    vme(table);
    if (row.words != 0) device_.words = (row.words - 1) * device_.stride + 1;
    toml_.needed(table, "base", device, [&](const toml::node& base) { place(base); });
    board_.devices.push_back(std::move(device_));
  }

 private:
  /// Options and actions say NAME=FILE.
  void name_of(const toml::node& node) {
    const std::string name = toml_.text(node, "device.name");
    if (name.empty() || name.find('=') != std::string::npos)
      toml_.fail(node,
                 fmt::format("device.name: \"{}\" cannot be used: a name is a text without '=', and not empty", name));
    device_.name = name;
  }

  /// A key that belongs to another kind gets a message of its own.
  void unknown_keys(const toml::table& table, const DeviceKindRow& row, const std::vector<std::string_view>& keys) {
    for (const auto& [key, node] : table) {
      if (std::ranges::find(keys, key.str()) != keys.end()) continue;
      std::vector<std::string_view> others;
      for (const DeviceKindRow& other : device_kinds())
        if (has_key(other, key.str())) others.push_back(other.name);
      if (others.empty())
        toml_.note(node, fmt::format("no such key device.{}; known are {}{}", key.str(), fmt::join(keys, ", "),
                                     io::did_you_mean(key.str(), keys)));
      else if (key.str() == "words" && row.words != 0)
        toml_.note(node, fmt::format("device.words of {}: a {} has its {} words", device_.name, row.name, row.words));
      else
        toml_.note(node, fmt::format("device.{} of {}: a {} has none; {} has", key.str(), device_.name, row.name,
                                     fmt::join(others, ", ")));
    }
  }

  const DeviceKindRow& kind(const toml::table& table, std::string_view device) {
    const DeviceKindRow* found = nullptr;
    toml_.needed(table, "kind", device, [&](const toml::node& given) {
      const std::string text = toml_.text(given, "device.kind");
      std::vector<std::string_view> names;
      for (const DeviceKindRow& row : device_kinds()) {
        if (row.name == text) found = &row;
        names.push_back(row.name);
      }
      if (found == nullptr)
        toml_.fail(given, fmt::format("device.kind of {}: \"{}\" is unknown; {} is expected{}", device_.name, text,
                                      fmt::join(names, ", "), io::did_you_mean(text, names)));
    });
    if (found == nullptr) throw BoardToml::Noted{};  // the other keys have no meaning yet
    device_.kind = found->kind;
    return *found;
  }

  void parameters(const toml::table& table, const DeviceKindRow& row, std::string_view device) {
    const auto allowed = [&](std::string_view key) { return key == "waits" || has_key(row, key); };
    const auto number = [&](std::string_view key, std::int64_t least, std::int64_t most, auto& field) {
      if (!allowed(key)) return;
      toml_.optional(table, key, [&](const toml::node& node) {
        field = static_cast<std::remove_reference_t<decltype(field)>>(
            toml_.whole(node, fmt::format("device.{} of {}", key, device_.name), least, most));
      });
    };
    constexpr std::int64_t most_words = 1 << 20, most_vme_words = std::int64_t{1} << 31, most_cycles = 1'000'000'000;
    number("words", 1, row.needs_words ? most_vme_words : most_words, device_.words);
    if (row.needs_words) toml_.needed(table, "words", device, [](const toml::node&) {});
    if (row.kind == DeviceKind::vic068a) device_.value = 0xF1;  // one of the revisions in vic068.h
    number("waits", 0, 1'000'000, device_.waits);
    number("value", 0, row.kind == DeviceKind::vic068a ? 0xFF : 0xFFFFFFFF, device_.value);
    number("depth", 1, 1 << 20, device_.depth);
    number("input_cycles", 0, most_cycles, device_.input_cycles);
    number("output_cycles", 0, most_cycles, device_.output_cycles);
    number("count_cycles", 1, most_cycles, device_.count_cycles);
    number("stride", 1, 1 << 16, device_.stride);
    number("shift", 0, 24, device_.shift);
    toml_.optional(table, "pin", [&](const toml::node& node) {
      device_.pin = interrupt_pin_named(toml_.text(node, "device.pin"));
      if (!device_.pin)
        toml_.fail(node, fmt::format("device.pin of {}: IIOF0 to IIOF3 or NMI is expected", device_.name));
    });
  }

  void input(const toml::table& table) {
    const toml::node *words = table.get("input"), *script = table.get("script");
    if (words != nullptr && script != nullptr)
      toml_.note(*script, fmt::format("device.script of {}: the words come from input already", device_.name));
    const toml::node* given = script != nullptr ? script : words;
    if (given == nullptr || !toml_.reads_files) return;
    toml_.attempt([&] {
      const std::string key = script != nullptr ? "device.script" : "device.input";
      const std::string name = toml_.text(*given, key);
      try {
        device_.input = read_device_input(toml_.beside(name), device_.kind, script != nullptr);
      } catch (const std::invalid_argument& error) {
        toml_.fail(*given, fmt::format("{} of {}: {}", key, device_.name, error.what()));
      }
    });
  }

  void vme(const toml::table& table) {
    if (device_.kind != DeviceKind::vme) return;
    toml_.optional(table, "answer", [&](const toml::node& node) {
      const std::string answer = toml_.text(node, "device.answer");
      if (answer != "bus error" && answer != "ignored")
        toml_.fail(node, fmt::format("device.answer of {}: \"bus error\" or \"ignored\" is expected", device_.name));
      device_.bus_error = answer == "bus error";
    });
    toml_.optional(table, "vic", [&](const toml::node& node) {
      device_.vic = toml_.text(node, "device.vic");
      const bool there = std::ranges::any_of(board_.devices, [&](const DeviceDescription& other) {
        return other.name == device_.vic && other.kind == DeviceKind::vic068a;
      });
      if (!there)
        toml_.fail(node, fmt::format("device.vic of {}: no [[device]] of kind \"vic068a\" named {} comes before it",
                                     device_.name, std::exchange(device_.vic, "")));
    });
  }

  void place(const toml::node& node) {
    device_.base = toml_.word(node, "device.base");
    const std::uint64_t end = std::uint64_t{device_.base} + device_.words;
    if (!behind_window(board_.board, device_.base, device_.words) && toml_.regions_known)
      toml_.note(node, fmt::format("device.base of {}: a device needs a [[region]] of kind \"window\", and no such "
                                   "region has {:08X}h to {:08X}h",
                                   device_.name, device_.base, end - 1));
    for (const DeviceDescription& other : board_.devices) {
      if (device_.base < std::uint64_t{other.base} + other.words && other.base < end)
        toml_.note(node,
                   fmt::format("device.base of {}: {} is there, at {:08X}h", device_.name, other.name, other.base));
      if (!device_.name.empty() && other.name == device_.name)
        toml_.note(node, fmt::format("device.name: two devices have the name {}", device_.name));
    }
  }

  BoardToml& toml_;
  BoardDescription& board_;
  DeviceDescription device_;
};

}  // namespace

DeviceInput device_input(std::string text, const std::string& source, DeviceKind kind, bool script) {
  DeviceInput input{.source = source, .sha256 = state::sha256(text), .steps = {}};
  const bool any_bytes = !script && kind == DeviceKind::console;  // as they were typed
  if (!any_bytes) text = io::checked_text<HostScriptError>(std::move(text), source);
  input.steps = script                        ? parse_host_script(text, source)
                : kind == DeviceKind::console ? characters(text)
                                              : parse_host_words(text, source);
  return input;
}

DeviceInput read_device_input(const std::string& path, DeviceKind kind, bool script) {
  const std::string expected = script                        ? "a host script (docs/boards.md)"
                               : kind == DeviceKind::console ? "the input of the console"
                                                             : "a file of words in hexadecimal";
  return device_input(io::read_file<HostScriptError>(path, expected), std::filesystem::path(path).filename().string(),
                      kind, script);
}

void read_devices(BoardToml& toml, BoardDescription& board, const toml::table& root) {
  toml.each(root, "device", [&](const toml::table& table) { DeviceReader(toml, board).read(table); });
}

}  // namespace machine
