#include "cli/arguments/settings.hpp"

#include <fmt/format.h>

#include "cmrc/programs/dsp_image.hpp"
#include "isa/ascii.hpp"
#include "report/events/event.hpp"

namespace cli {
namespace {

std::optional<std::int64_t> parse_integer(std::string_view text) {
  return text.starts_with("0x") ? ascii::number<std::int64_t>(text.substr(2), 16) : ascii::number<std::int64_t>(text);
}

void add_setting(cmrc::ConfigBuilder& builder, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw InputError(fmt::format("--set: \"{}\" is not KEY=VALUE", text));
  builder.set(text.substr(0, equals), parse_value(text.substr(equals + 1)), {.name = "--set"});
}

}  // namespace

cmrc::Value parse_value(const std::string& text) {
  if (text == "true") return true;
  if (text == "false") return false;
  if (const auto integer = parse_integer(text)) return *integer;
  if (const auto number = ascii::number<double>(text)) return *number;
  return text;
}

std::optional<report::Time> parse_seconds(std::string_view text) {
  const auto seconds = ascii::number<double>(text);
  if (!seconds || !(*seconds >= 0) || *seconds > 1e6) return std::nullopt;
  return report::from_seconds(*seconds);
}

cmrc::Config build_config(const RunOptions& options, std::string_view base, const std::string& base_name) {
  cmrc::ConfigBuilder builder;
  if (!base.empty()) builder.text(base, base_name);
  if (options.config) builder.file(*options.config);
  if (options.preset) builder.preset(*options.preset, {.name = "--preset"});
  for (const std::string& setting : options.settings) add_setting(builder, setting);
  const auto set = [&builder](const char* key, const auto& value, const char* flag) {
    if (value) builder.set(key, *value, {.name = flag});
  };
  set("machine.dsps", options.dsps, "--dsps");
  set("run.duration_s", options.duration_s, "--duration");
  set("run.seed", options.seed, "--seed");
  set("run.turn_order", options.turn_order, "--turn-order");
  set("machine.programs", options.programs, "--programs");
  set("machine.board", options.board, "--board");
  set("bus.topology", options.topology, "--topology");
  set("machine.idle_policy", options.idle_policy, "--idle-policy");
  set("scheduling.equation", options.equation7, "--eq7");
  if (options.strict) builder.set("run.strict", true, {.name = "--strict"});
  return builder.build();
}

io::FileRoles files_read(const RunOptions& options, const cmrc::Config& config) {
  io::FileRoles files;
  files.reads("--config", options.config.value_or(""));
  if (config.machine.board != "default") files.reads("machine.board", config.machine.board);
  files.reads("dock.layout", config.dock.layout).reads_folder("machine.programs", config.machine.programs);
  // A source may include files from outside the folder, or be a link that leads there.
  if (!config.machine.programs.empty())
    for (const std::string& source : cmrc::assembled_program(config).files_read) files.reads("a DSP program", source);
  return files;
}

report::Window parse_window(std::string_view option, const std::string& text) {
  const auto refuse = [&](std::string_view why) { throw InputError(fmt::format("{}: \"{}\" {}", option, text, why)); };
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) refuse("is not A:B, in seconds");
  report::Window window;
  const std::string_view from = std::string_view(text).substr(0, colon);
  const std::string_view to = std::string_view(text).substr(colon + 1);
  const auto begin = from.empty() ? window.from : parse_seconds(from);
  const auto end = to.empty() ? window.to : parse_seconds(to);
  if (!begin || !end) refuse("is not A:B, in seconds");
  if (*begin >= *end) refuse("is empty; A has to be less than B");
  return {*begin, *end};
}

}  // namespace cli
