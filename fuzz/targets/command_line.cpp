// Arguments, one per line, and the configuration that those of a run make. No file that they name is opened.
#include "cli/arguments/command_line.hpp"

#include "cli/arguments/settings.hpp"
#include "fuzz/target.hpp"

namespace {

constexpr std::string_view naming_files[] = {"layout", "programs", "board"};

/// The checks of one command's options before the command runs.
struct Check {
  void operator()(cli::RunOptions options) const {
    options.config = options.programs = options.board = {};
    std::erase_if(options.settings, [](const std::string& setting) {
      for (const std::string_view key : naming_files)
        if (setting.find(key) != std::string::npos) return true;
      return false;
    });
    const cmrc::Config config = cli::build_config(options);
    if (options.trace_window) cli::parse_window("--trace-window", *options.trace_window);
    const std::string printed = cmrc::to_toml(config);
    fuzz::expect(cmrc::to_toml(cmrc::ConfigBuilder().text(printed, "printed").build()) == printed,
                 "a printed configuration is read as another");
  }
  void operator()(const cli::ConfigOptions& options) const { (*this)(options.run); }
  void operator()(const cli::CompareOptions& options) const { (*this)(options.run); }
  template <class Others>
  void operator()(const Others&) const {}
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 4096, most_arguments = 64;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  std::vector<std::string> words{"emulator"};
  for (std::string_view text = input.text(); !text.empty() && words.size() < most_arguments;) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    words.emplace_back(text.substr(0, end).substr(0, text.find('\0')));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  fuzz::done<cli::InputError, cmrc::ConfigError>([&] {
    const auto asked = cli::parse_command_line(static_cast<int>(arguments.size()), arguments.data());
    if (const auto* request = std::get_if<cli::Request>(&asked)) std::visit(Check{}, *request);
  });
  return 0;
}
