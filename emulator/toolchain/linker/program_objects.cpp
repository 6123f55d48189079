#include "toolchain/linker/program_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "isa/types.hpp"
#include "toolchain/linker/linker.hpp"

namespace toolchain {
namespace {

void pull_from_library(std::vector<Object>& objects, const std::vector<Object>& library, const MemoryMap& map) {
  std::map<std::string, std::size_t, std::less<>> offers;
  for (std::size_t i = 0; i < library.size(); ++i)
    for (const ObjectSymbol& symbol : library[i].symbols)
      if (symbol.defines()) offers.emplace(symbol.name, i);
  std::set<std::string, std::less<>> defined;
  std::set<std::size_t> taken;
  for (const auto& [name, value] : map.symbols) defined.insert(name);
  for (const Object& object : objects)
    for (const ObjectSymbol& symbol : object.symbols)
      if (symbol.defines()) defined.insert(symbol.name);
  const auto want = [&](const std::string& name) {
    const auto offer = offers.find(name);
    if (defined.contains(name) || offer == offers.end() || !taken.insert(offer->second).second) return;
    objects.push_back(library[offer->second]);
    for (const ObjectSymbol& symbol : objects.back().symbols)
      if (symbol.defines()) defined.insert(symbol.name);
  };
  if (!map.entry.empty()) want(map.entry);
  if (map.entry.empty() && map.is_c) want("_c_int00");
  for (std::size_t i = 0; i < objects.size(); ++i) {  // Grows while it is walked.
    const auto symbols = objects[i].symbols;
    for (const ObjectSymbol& symbol : symbols)
      if (symbol.section == ObjectSymbol::undefined) want(symbol.name);
  }
}

bool holds_words(const Object& object) {
  return std::ranges::any_of(object.sections, [](const ObjectSection& section) { return section.size != 0; });
}

/// The first object with a word decides the program's processor; an object without words does not.
isa::Cpu processor_of(const std::vector<Object>& objects) {
  const auto found = std::ranges::find_if(objects, holds_words);
  const Object& leader = found == objects.end() ? objects.front() : *found;
  std::vector<std::string> errors;
  for (const Object& object : objects)
    if (object.cpu != leader.cpu && holds_words(object))
      errors.push_back(
          fmt::format("{}: is for the {}, and {} for the {}; all objects of a program must be for one processor",
                      object.name, isa::title(object.cpu), leader.name, isa::title(leader.cpu)));
  if (!errors.empty()) throw LinkError(std::move(errors));
  return leader.cpu;
}

/// Undefined symbols that have a size, and that no object defines, get this number of words of .bss.
void add_common(std::vector<Object>& objects, isa::Cpu cpu) {
  std::map<std::string, Word> wanted;
  std::set<std::string> defined;
  for (const Object& object : objects)
    for (const ObjectSymbol& symbol : object.symbols) {
      if (symbol.defines()) defined.insert(symbol.name);
      if (symbol.section == ObjectSymbol::undefined && symbol.value != 0)
        wanted[symbol.name] = std::max(wanted[symbol.name], symbol.value);
    }
  Object common;
  common.name = "common storage";
  common.cpu = cpu;
  ObjectSection bss;
  bss.name = ".bss";
  bss.loaded = false;
  for (const auto& [name, size] : wanted) {
    if (defined.contains(name)) continue;
    common.symbols.push_back(
        {.name = name, .value = bss.size, .section = 0, .global = true, .stands_for_section = false});
    bss.size += size;
  }
  if (common.symbols.empty()) return;
  common.sections.push_back(std::move(bss));
  objects.push_back(std::move(common));
}

}  // namespace

isa::Cpu complete(std::vector<Object>& objects, const std::vector<Object>& library, const MemoryMap& map) {
  pull_from_library(objects, library, map);
  const isa::Cpu cpu = processor_of(objects);
  add_common(objects, cpu);
  return cpu;
}

}  // namespace toolchain
