#include "cmrc/programs/dsp_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>

#include "c40_programs/image.hpp"
#include "cmrc/programs/kernels.hpp"
#include "isa/ascii.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/source_map.hpp"

namespace cmrc {
namespace {

/// A built-in COFF file and its source map.
toolchain::Image with_source(std::span<const std::byte> program, std::span<const std::byte> map) {
  toolchain::Image image = toolchain::read_coff(program);
  toolchain::add_source_map(image, {reinterpret_cast<const char*>(map.data()), map.size()});
  return image;
}

}  // namespace

toolchain::Image assembled_program(const Config& config) {
  const bool own = own_blocks(config.tasks);
  if (config.machine.programs.empty())
    return with_source(c40_programs::built_in_image(own), c40_programs::built_in_source_map(own));
  const std::filesystem::path directory = config.machine.programs;
  const std::filesystem::path source = directory / "dsp.asm";
  if (std::error_code error; !std::filesystem::is_regular_file(source, error)) {
    throw ConfigError(fmt::format("machine.programs: {} is not there; a directory with dsp.asm is expected",
                                  std::filesystem::absolute(source).string()));
  }
  toolchain::Options options;
  options.include_dirs = {directory, directory / "include"};
  if (own) options.symbols["OWN_BLOCKS"] = 1;
  toolchain::Image image = toolchain::assemble_file(source, options);
  if (own && !image.symbols.contains("own_claim")) {
    throw ConfigError(
        fmt::format("tasks.dsp: the executive in {} does not support blocks for one DSP alone; the files "
                    "executive.asm, dsp.asm and claim_own.asm of this emulator's programs are expected",
                    directory.string()));
  }
  return image;
}

namespace {

/// The executive knows a policy by the number IDLE_NAME, which has to be the number of the configuration.
void check_idle_policy(const toolchain::Image& image, const Config& config) {
  const auto key = std::ranges::find(keys(), "machine.idle_policy", &Key::name);
  const std::string word = std::get<std::string>(key->read(config));
  const std::string symbol = "IDLE_" + ascii::upper(word);
  const auto expected = static_cast<toolchain::Word>(config.machine.idle_policy);
  const auto found = image.symbols.find(symbol);
  if (found != image.symbols.end() && found->second == expected) return;
  throw ConfigError(
      fmt::format("machine.idle_policy: the DSPs' executive does not know \"{}\"; executive.asm with "
                  "{} .set {} is expected",
                  word, symbol, expected));
}

}  // namespace

toolchain::Image dsp_image(const Config& config) {
  toolchain::Image image = assembled_program(config);
  place_kernels(image, config);
  check_idle_policy(image, config);
  return image;
}

toolchain::Image boot_rom_image() {
  return with_source(c40_programs::built_in_boot_rom(), c40_programs::built_in_boot_rom_source_map());
}

}  // namespace cmrc
