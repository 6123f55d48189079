#include "cmrc/run/snapshot_origin.hpp"

#include <fmt/format.h>

#include <sstream>

#include "io/input_file.hpp"
#include "state/sha256.hpp"

namespace cmrc {

std::string key_of(Config config) {
  config.run.turn_order = 0;
  return to_toml(config);
}

std::string result_key_of(Config config) {
  config.run.turn_order = 0;
  config.run.strict = false;
  config.machine.programs.clear();
  config.dock.layout.clear();
  config.machine.board = "default";
  return to_toml(config);
}

std::string digest_of_files(const Config& config, const toolchain::Image& image) {
  std::string all;
  for (const auto& section : image.sections) {
    all += fmt::format("{} {:X} {:X} ", section.name, section.address, section.words.size());
    all.append(reinterpret_cast<const char*>(section.words.data()),
               section.words.size() * sizeof(Word));  // NOLINT: bytes of words
  }
  if (!config.dock.layout.empty()) all += io::read_input(config.dock.layout).text;
  if (config.machine.board != "default") all += io::read_input(config.machine.board).text;
  return state::sha256(all);
}

std::string first_other_line(std::string_view one, std::string_view other) {
  std::istringstream a{std::string(one)}, b{std::string(other)};
  std::string table, line, beside;
  while (std::getline(a, line) && std::getline(b, beside) && line == beside)
    if (line.starts_with('[')) table = line + " ";
  return fmt::format("{}{}, here {}", table, line, beside);
}

}  // namespace cmrc
