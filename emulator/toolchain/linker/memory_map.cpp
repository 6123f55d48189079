#include "toolchain/linker/memory_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "io/text_form.hpp"
#include "io/toml.hpp"

namespace toolchain {
namespace {

using isa::Address;

class MapReader {
 public:
  explicit MapReader(std::string name) : name_(std::move(name)) {}

  MemoryMap read(const toml::table& table) {
    allow(table, {"entry", "others", "c_model", "memory", "sections", "symbols"});
    MemoryMap map;
    if (const auto* node = table.get("entry")) map.entry = text(*node, "entry");
    if (const auto* node = table.get("c_model")) {
      const auto model = c_model(text(*node, "c_model"));
      if (!model) fail(node->source(), "c_model: \"rom\" or \"ram\" is expected");
      map.is_c = true, map.loader_sets_values = *model;
    }
    for (const auto& [key, node] : in_order(child(table, "memory"))) add_memory(map, key, *node);
    if (map.memories.empty()) throw MemoryMapError(fmt::format("{}: no memory; [memory] needs at least one", name_));
    map.others = map.memories.front().name;
    if (const auto* node = table.get("others")) map.others = known_memory(map, *node, "others");
    for (const auto& [key, node] : in_order(child(table, "sections"))) add_section(map, key, *node);
    for (const auto& [key, node] : in_order(child(table, "symbols"))) map.symbols[key] = number(*node, key, 0xFFFFFFFF);
    return map;
  }

 private:
  using Entries = std::vector<std::pair<std::string, const toml::node*>>;

  [[noreturn]] void fail(const toml::source_region& where, const std::string& what) const {
    throw MemoryMapError(fmt::format("{}:{}:{}: {}", name_, where.begin.line, where.begin.column, what));
  }

  void allow(const toml::table& table, std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, node] : table) {
      if (std::find(keys.begin(), keys.end(), key.str()) != keys.end()) continue;
      fail(key.source(), fmt::format("no such key '{}'; known are {}", key.str(), fmt::join(keys, ", ")));
    }
  }

  const toml::table* child(const toml::table& table, std::string_view key) const {
    const auto* node = table.get(key);
    if (node == nullptr) return nullptr;
    if (!node->is_table()) fail(node->source(), fmt::format("'{}' is a table", key));
    return node->as_table();
  }

  /// A table's entries in the order of the file; the parser sorts them by name.
  static Entries in_order(const toml::table* table) {
    std::vector<std::pair<toml::source_position, std::pair<std::string, const toml::node*>>> found;
    if (table != nullptr)
      for (const auto& [key, node] : *table) found.push_back({key.source().begin, {std::string(key.str()), &node}});
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
      return std::pair(a.first.line, a.first.column) < std::pair(b.first.line, b.first.column);
    });
    Entries out;
    for (auto& entry : found) out.push_back(std::move(entry.second));
    return out;
  }

  std::string text(const toml::node& node, std::string_view key) const {
    if (!node.is_string()) fail(node.source(), fmt::format("{}: a name in quotes is expected", key));
    return node.as_string()->get();
  }

  std::uint32_t number(const toml::node& node, std::string_view key, std::int64_t most) const {
    if (!node.is_integer()) fail(node.source(), fmt::format("{}: a number is expected, such as 0x300000", key));
    const std::int64_t value = node.as_integer()->get();
    if (value < 0 || value > most) fail(node.source(), fmt::format("{}: {} is not within 0 to {}", key, value, most));
    return static_cast<std::uint32_t>(value);
  }

  void add_memory(MemoryMap& map, const std::string& name, const toml::node& node) const {
    if (!node.is_table())
      fail(node.source(), fmt::format("{}: {{ origin = ADDRESS, length = WORDS }} is expected", name));
    const toml::table& table = *node.as_table();
    allow(table, {"origin", "length"});
    const auto *origin = table.get("origin"), *length = table.get("length");
    if (origin == nullptr || length == nullptr)
      fail(node.source(), fmt::format("{}: origin and length are needed", name));
    MemoryMap::Memory memory{name, number(*origin, "origin", 0xFFFFFFFF), 0};
    if (!length->is_integer() || length->as_integer()->get() < 1 ||
        length->as_integer()->get() > (std::int64_t{1} << 32) - memory.origin)
      fail(length->source(),
           fmt::format("{}: length: 1 to {} words are possible there", name, (std::int64_t{1} << 32) - memory.origin));
    memory.length = static_cast<std::uint64_t>(length->as_integer()->get());
    for (const auto& other : map.memories)
      if (memory.origin < other.origin + other.length && other.origin < memory.origin + memory.length)
        fail(node.source(), fmt::format("the memories '{}' and '{}' overlap", other.name, name));
    map.memories.push_back(std::move(memory));
  }

  std::string known_memory(const MemoryMap& map, const toml::node& node, std::string_view key) const {
    std::string name = text(node, key);
    if (map.memory(name) == nullptr) fail(node.source(), fmt::format("{}: there is no memory '{}'", key, name));
    return name;
  }

  void add_section(MemoryMap& map, const std::string& name, const toml::node& node) const {
    MemoryMap::Placement out;
    out.section = name;
    if (node.is_string()) {
      out.memory = known_memory(map, node, name);
      map.sections.push_back(std::move(out));
      return;
    }
    if (!node.is_table())
      fail(node.source(),
           fmt::format("{}: the name of a memory, or {{ memory, address, align, size }} is expected", name));
    const toml::table& table = *node.as_table();
    allow(table, {"memory", "address", "align", "size"});
    if (const auto* value = table.get("memory")) out.memory = known_memory(map, *value, "memory");
    if (const auto* value = table.get("address")) out.address = number(*value, "address", 0xFFFFFFFF);
    if (const auto* value = table.get("size")) out.size = number(*value, "size", 0xFFFFFFFF);
    if (const auto* value = table.get("align")) {
      out.alignment = number(*value, "align", Address{1} << 31);
      if (out.alignment == 0 || (out.alignment & (out.alignment - 1)) != 0)
        fail(value->source(), "align: a power of 2 is expected");
      if (out.address && *out.address % out.alignment != 0)
        fail(value->source(), "align: the address is no multiple of it");
    }
    if (out.memory.empty() && !out.address) out.memory = map.others;
    map.sections.push_back(std::move(out));
  }

  std::string name_;
};

}  // namespace

const MemoryMap::Memory* MemoryMap::memory(std::string_view name) const {
  for (const Memory& memory : memories)
    if (memory.name == name) return &memory;
  return nullptr;
}

std::optional<bool> c_model(std::string_view name) {
  if (name == "rom") return false;
  if (name == "ram") return true;
  return {};
}

MemoryMap MemoryMap::standard() {
  MemoryMap map;
  map.memories.push_back({"local", 0x300000, 0x100000});
  map.others = "local";
  return map;
}

MemoryMap parse_memory_map(std::string_view toml, const std::string& name) {
  try {
    return MapReader(name).read(io::parse_toml(toml, name));
  } catch (const toml::parse_error& error) {
    throw MemoryMapError(
        fmt::format("{}:{}:{}: {}", name, error.source().begin.line, error.source().begin.column, error.description()));
  }
}

MemoryMap read_memory_map(const std::filesystem::path& path) {
  return parse_memory_map(io::read_text<MemoryMapError>(path, "a memory map"), path.string());
}

}  // namespace toolchain
