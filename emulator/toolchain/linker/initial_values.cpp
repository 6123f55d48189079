#include "toolchain/linker/initial_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "toolchain/objects/coff.hpp"

namespace toolchain {

std::vector<std::string> doubts_about_initial_values(const OutputSection& table, const std::vector<Word>& records,
                                                     const std::vector<Object>& objects, const std::string& program) {
  std::vector<std::string> warnings;
  if (records.empty()) return warnings;
  std::size_t end = 0;
  try {
    Image unused;
    end = add_initial_values(unused, table.name, records, fmt::format("{}: warning", program));
  } catch (const CoffError& error) {
    if (!table.for_loader) warnings.emplace_back(error.what());  // else it is an error of set_initial_values()
    return warnings;
  }
  if (end >= records.size())
    warnings.push_back(
        fmt::format("{}: warning: the last record of {} asks for one word more than it has", program, table.name));
  const auto lost = std::find_if(records.begin() + static_cast<std::ptrdiff_t>(std::min(end, records.size())),
                                 records.end(), [](Word word) { return word != 0; });
  if (lost == records.end()) return warnings;
  const auto place = static_cast<Address>(lost - records.begin());
  const auto next = std::ranges::find_if(table.parts, [&](const auto& part) { return part.offset > place; });
  const OutputSection::Part& part = *std::prev(next);
  warnings.push_back(
      fmt::format("{}: {}+{:X}h: warning: the initial values from here on are not set; a 0 before them, in word {} "
                  "of {}, closes the table",
                  objects[part.source.object].name, table.name, place - part.offset, end, table.name));
  return warnings;
}

void set_initial_values(Image::Section table, Image& image, const std::string& program) {
  const std::vector<Word> records = std::exchange(table.words, {});
  table.loaded = false;
  const std::string name = table.name;
  image.sections.push_back(std::move(table));
  add_initial_values(image, name, records, program);
}

}  // namespace toolchain
