#include "toolchain/linker/memory_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/text_form.hpp"
#include "io/toml_reader.hpp"
#include "toolchain/objects/section_places.hpp"

namespace toolchain {
namespace {

using isa::Address;
using Keys = std::vector<std::string_view>;

const Keys root_keys{"entry", "others", "c_model", "memory", "sections", "symbols"};
const Keys memory_keys{"origin", "length"};
const Keys section_keys{"memory", "address", "align", "size"};

class MapReader {
 public:
  explicit MapReader(std::string name) : toml_(std::move(name)) {}

  MemoryMap read(const toml::table& root) {
    toml_.allow(root, "", root_keys);
    toml_.optional(root, "entry", [&](const toml::node& node) { map_.entry = toml_.text(node, "entry"); });
    toml_.optional(root, "c_model", [&](const toml::node& node) {
      const auto model = c_model(toml_.text(node, "c_model"));
      if (!model) toml_.fail(node, "c_model: \"rom\" or \"ram\" is expected");
      map_.is_c = true, map_.loader_sets_values = *model;
    });
    each(root, "memory", [&](const std::string& name, const toml::node& node) { add_memory(name, node); });
    const auto* const memories = root.get("memory");
    if (memories == nullptr || (memories->is_table() && memories->as_table()->empty()))
      toml_.note("there is no memory; [memory] with NAME = { origin = ADDRESS, length = WORDS } is expected");
    toml_.finish<MemoryMapError>();  // the others name memories
    map_.others = map_.memories.front().name;
    toml_.optional(root, "others", [&](const toml::node& node) { map_.others = known_memory(node, "others"); });
    each(root, "sections", [&](const std::string& name, const toml::node& node) { add_section(name, node); });
    each(root, "symbols", [&](const std::string& name, const toml::node& node) {
      map_.symbols[name] = number(node, "symbols." + name, 0xFFFFFFFF);
    });
    toml_.finish<MemoryMapError>();
    return std::move(map_);
  }

 private:
  /// The entries of a table in the order of the file; the parser sorts them by name.
  template <class Read>
  void each(const toml::table& root, std::string_view key, Read&& read) {
    toml_.optional(root, key, [&](const toml::node& node) {
      if (!node.is_table()) toml_.fail(node, fmt::format("{}: a table, [{}], is expected", key, key));
      std::vector<std::pair<const toml::key*, const toml::node*>> entries;
      for (const auto& [name, value] : *node.as_table()) entries.emplace_back(&name, &value);
      std::ranges::stable_sort(entries, {}, [](const auto& entry) {
        const toml::source_position begin = entry.first->source().begin;
        return std::pair(begin.line, begin.column);
      });
      for (const auto& [name, value] : entries)
        toml_.attempt([&, &name = name, &value = value] { read(std::string(name->str()), *value); });
    });
  }

  std::uint32_t number(const toml::node& node, std::string_view key, std::int64_t most) {
    return static_cast<std::uint32_t>(toml_.whole(node, key, 0, most));
  }

  void add_memory(const std::string& name, const toml::node& node) {
    const std::string place = "memory." + name;
    if (!node.is_table())
      toml_.fail(node, fmt::format("{}: {{ origin = ADDRESS, length = WORDS }} is expected", place));
    const toml::table& table = *node.as_table();
    toml_.allow(table, place + ".", memory_keys);
    MemoryMap::Memory memory{name, 0, 0};
    bool whole = toml_.needed(table, "origin", place, [&](const toml::node& origin) {
      memory.origin = number(origin, place + ".origin", 0xFFFFFFFF);
    });
    whole &= toml_.needed(table, "length", place, [&](const toml::node& length) {
      const std::int64_t room = (std::int64_t{1} << 32) - memory.origin;
      memory.length = static_cast<std::uint64_t>(toml_.whole(length, place + ".length", 1, room));
    });
    if (!whole) return;
    for (const auto& other : map_.memories)
      if (memory.origin < other.origin + other.length && other.origin < memory.origin + memory.length)
        toml_.fail(node, fmt::format("the memories '{}' and '{}' overlap", other.name, name));
    map_.memories.push_back(std::move(memory));
  }

  std::string known_memory(const toml::node& node, std::string_view key) {
    std::string name = toml_.text(node, key);
    if (map_.memory(name) != nullptr) return name;
    std::vector<std::string_view> names;
    for (const auto& memory : map_.memories) names.push_back(memory.name);
    toml_.fail(node, fmt::format("{}: there is no memory '{}'; {} is expected", key, name, io::one_of(names)));
  }

  void add_section(const std::string& name, const toml::node& node) {
    const std::string& place = name;
    MemoryMap::Placement out;
    out.section = name;
    if (node.is_string()) {
      out.memory = known_memory(node, place);
      map_.sections.push_back(std::move(out));
      return;
    }
    if (!node.is_table())
      toml_.fail(node,
                 fmt::format("{}: the name of a memory, or {{ memory, address, align, size }} is expected", place));
    const toml::table& table = *node.as_table();
    const std::string prefix = place + ".";
    toml_.allow(table, prefix, section_keys);
    toml_.optional(table, "memory",
                   [&](const toml::node& given) { out.memory = known_memory(given, prefix + "memory"); });
    toml_.optional(table, "address",
                   [&](const toml::node& given) { out.address = number(given, prefix + "address", 0xFFFFFFFF); });
    toml_.optional(table, "size",
                   [&](const toml::node& given) { out.size = number(given, prefix + "size", 0xFFFFFFFF); });
    toml_.optional(table, "align", [&](const toml::node& given) {
      out.alignment = number(given, prefix + "align", Address{1} << 31);
      if (out.alignment == 0 || (out.alignment & (out.alignment - 1)) != 0)
        toml_.fail(given, prefix + "align: a power of 2 is expected");
      if (out.address && *out.address % out.alignment != 0)
        toml_.fail(given, fmt::format("{}align: the address {:08X}h is no multiple of it", prefix, *out.address));
    });
    if (out.memory.empty() && !out.address) out.memory = map_.others;
    map_.sections.push_back(std::move(out));
  }

  io::TomlReader toml_;
  MemoryMap map_;
};

}  // namespace

const MemoryMap::Memory* MemoryMap::memory(std::string_view name) const {
  for (const Memory& memory : memories)
    if (memory.name == name) return &memory;
  return nullptr;
}

const MemoryMap::Memory* MemoryMap::memory_at(Address address) const {
  for (const Memory& memory : memories)
    if (address >= memory.origin && address - memory.origin < memory.length) return &memory;
  return nullptr;
}

std::optional<bool> c_model(std::string_view name) {
  if (name == "rom") return false;
  if (name == "ram") return true;
  return {};
}

MemoryMap MemoryMap::standard() {
  MemoryMap map;
  map.memories.push_back({"local", usual_address, 0x100000});
  map.others = "local";
  return map;
}

MemoryMap parse_memory_map(std::string_view toml, const std::string& name) {
  try {
    return MapReader(name).read(io::parse_toml(toml, name));
  } catch (const toml::parse_error& error) {
    throw MemoryMapError(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
}

MemoryMap read_memory_map(const std::filesystem::path& path) {
  return parse_memory_map(io::read_text<MemoryMapError>(path, "a memory map"), path.string());
}

}  // namespace toolchain
