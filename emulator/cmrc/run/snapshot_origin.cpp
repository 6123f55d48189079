#include "cmrc/run/snapshot_origin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>

#include "cmrc/programs/dsp_image.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "io/input_file.hpp"
#include "report/events/event.hpp"
#include "state/sha256.hpp"

namespace cmrc {
namespace {

std::string words_of(const toolchain::Image& image) {
  std::string all;
  for (const auto& section : image.sections) {
    all += fmt::format("{} {:X} {:X} ", section.name, section.address, section.words.size());
    all.append(reinterpret_cast<const char*>(section.words.data()),
               section.words.size() * sizeof(Word));  // NOLINT: bytes of words
  }
  return all;
}

enum class Missing { is_empty, is_refused };

std::string contents_of_files(const Config& config, Missing missing) {
  std::string all;
  const auto add = [&](std::string_view kind, const std::string& path) {
    const io::Input input = io::read_input(path);
    if (missing == Missing::is_refused && !input.problem.empty())
      throw ConfigError(fmt::format("{}: {}", path, input.problem));
    all.append(kind).append(input.text);
  };
  if (!config.dock.layout.empty()) add("layout ", config.dock.layout);
  if (config.machine.board != "default") add("board ", config.machine.board);
  return all;
}

}  // namespace

std::string key_of(Config config) {
  config.run.turn_order = 0;
  return to_toml(config);
}

std::string without_paths(const std::string& toml) {
  std::string table, line, rest;
  for (std::istringstream lines(toml); std::getline(lines, line);) {
    if (line.starts_with('[')) table = line.substr(1, line.find(']') - 1);
    const std::string name = table + "." + line.substr(0, line.find(' '));
    const auto all = keys();
    if (std::none_of(all.begin(), all.end(), [&](const Key& key) { return key.path && key.name == name; }))
      rest += line + "\n";
  }
  return rest;
}

std::string result_key_of(Config config) {
  config.run.turn_order = 0;
  config.run.strict = false;
  config.machine.programs.clear();
  config.dock.layout.clear();
  config.machine.board = "default";
  return to_toml(config);
}

Config beginning_of(Config config, report::Time time) {
  std::erase_if(config.events, [time](const TimedEvent& event) { return report::from_seconds(event.at_s) >= time; });
  return config;
}

std::vector<std::string> inputs_of(const Config& config) {
  const Config::Machine& machine = config.machine;
  if (machine.programs.empty() && config.dock.layout.empty() && machine.board == "default") return {};
  return {machine.programs, config.dock.layout, machine.board, own_blocks(config.tasks) ? "own blocks" : ""};
}

std::string digest_of_inputs(const Config& config) {
  const std::string program = config.machine.programs.empty() ? "" : words_of(assembled_program(config));
  return state::sha256(program + contents_of_files(config, Missing::is_refused));
}

std::string digest_of_files(const Config& config, const toolchain::Image& image) {
  return state::sha256(words_of(image) + contents_of_files(config, Missing::is_empty));
}

std::string first_other_line(std::string_view one, std::string_view other) {
  std::istringstream a{std::string(one)}, b{std::string(other)};
  std::string table, line, beside;
  while (std::getline(a, line) && std::getline(b, beside) && line == beside)
    if (line.starts_with('[')) table = line + " ";
  return fmt::format("{}{}, here {}", table, line, beside);
}

}  // namespace cmrc
