#include "cmrc/programs/program_constants.hpp"

#include <fmt/format.h>

#include "cmrc/configuration/rows/value.hpp"
#include "cmrc/tasks/ti_float.hpp"

namespace cmrc {

std::vector<double> program_constants(const toolchain::Image& image, std::string_view label, std::size_t count) {
  const auto place = image.symbols.find(label), lift = image.symbols.find("LIFT");
  if (place != image.symbols.end() && lift != image.symbols.end()) {
    const toolchain::Address from = place->second + lift->second;
    for (const toolchain::Image::Section& section : image.sections) {
      if (from < section.address || from - section.address + count > section.words.size()) continue;
      std::vector<double> all;
      for (std::size_t i = 0; i < count; ++i) all.push_back(from_ti_float(section.words[from - section.address + i]));
      return all;
    }
  }
  throw ConfigError(fmt::format("machine.programs: {} is not among the programs' constants; {} there {} expected",
                                label, count == 1 ? "a number" : fmt::format("{} numbers", count),
                                count == 1 ? "is" : "are"));
}

}  // namespace cmrc
