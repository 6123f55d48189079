#include "toolchain/linker/link_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "io/print.hpp"

namespace toolchain {

std::string link_map(const Image& image, const MemoryMap& map, const Placement& placement,
                     const std::vector<Object>& objects) {
  std::string out = fmt::format("entry {:08X}h\n\nmemory            origin     length       used\n", image.entry);
  for (const auto& memory : map.memories) {
    std::uint64_t used = 0;
    for (const OutputSection& section : placement.sections())
      if (!section.for_loader && section.address >= memory.origin && section.address - memory.origin < memory.length)
        used += section.size;
    out += fmt::format("{:<16} {:08X}h {:>9X}h {:>9X}h\n", memory.name, memory.origin, memory.length, used);
  }
  out += "\nsection          address         size  from\n";
  for (const OutputSection& section : placement.sections()) {
    if (section.size == 0 && section.parts.empty()) continue;
    out += fmt::format("{:<16} {:08X}h {:>9X}h{}\n", section.name, section.address, section.size,
                       section.for_loader ? "  for the loader"
                       : section.loaded   ? ""
                                          : "  reserved");
    for (const auto& part : section.parts) {
      const Object& object = objects[part.source.object];
      const Address size = object.sections[part.source.section].size;
      if (size != 0)
        out += fmt::format("{:<16} {:08X}h {:>9X}h  {}\n", "", section.address + part.offset, size, object.name);
    }
  }
  out += "\naddress    symbol\n";
  std::vector<std::pair<Word, std::string_view>> by_address;
  for (const auto& [name, value] : image.names()) by_address.emplace_back(value, name);
  std::sort(by_address.begin(), by_address.end());
  for (const auto& [value, name] : by_address) out += fmt::format("{:08X}h  {}\n", value, name);
  return io::printable(out);
}

}  // namespace toolchain
