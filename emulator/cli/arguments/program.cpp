#include "cli/arguments/program.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>

#include "cli/arguments/options.hpp"
#include "io/print.hpp"
#include "io/text_form.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/source_map.hpp"

namespace cli {
namespace {

using toolchain::Address;
using toolchain::Image;
using toolchain::Word;

Image read_hex(const std::string& path, Address load_at, isa::Cpu cpu) {
  std::istringstream in(io::read_text<InputError>(path, "a file with a word per line"));
  std::vector<Word> words;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::string text(ascii::trimmed(line));
    if (text.empty()) continue;
    const auto word = toolchain::find_address(text + "h", nullptr);
    if (!word || text.size() > 8)
      throw InputError(fmt::format("{}:{}: \"{}\" is not a word; up to 8 hexadecimal digits per line are expected",
                                   path, number, text.substr(0, 40)));
    words.push_back(*word);
  }
  if (words.empty()) throw InputError(fmt::format("{}: contains no word", path));
  if (const std::uint64_t end = std::uint64_t{load_at} + words.size(); end > isa::address_space(cpu))
    throw InputError(
        fmt::format("{}: {} words at {:X}h pass the end of the address space", path, words.size(), load_at));
  Image image;
  image.cpu = cpu;
  image.entry = load_at;
  const auto size = static_cast<Address>(words.size());
  image.sections.push_back(
      {.name = ".hex", .address = load_at, .size = size, .words = std::move(words), .loaded = true});
  return image;
}

bool is_source(const std::string& suffix) { return suffix == ".asm" || suffix == ".s" || suffix == ".S"; }

}  // namespace

io::FileRoles files_read(const ExecOptions& options) {
  io::FileRoles files;
  for (const std::string& program : options.programs) files.reads("PROGRAM", program);
  for (const std::string& board : options.boards)
    if (board != "default" && board != "flat") files.reads("--board", board);
  files.reads("--network", options.network.value_or(""));
  return files;
}

void require_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(fmt::format("{}: no such file", path));
  if (std::filesystem::is_directory(path, error))
    throw InputError(fmt::format("{}: is a directory; a program is expected", path));
  // Not opened: a pipe that is opened twice has lost its writer in between.
  if (::access(path.c_str(), R_OK) != 0) throw InputError(fmt::format("{}: cannot be read", path));
}

bool is_coff_name(const std::string& path) {
  const std::string suffix = std::filesystem::path(path).extension().string();
  return suffix != ".hex" && !is_source(suffix);
}

Image read_program(const std::string& path, const std::vector<std::string>& include_directories,
                   const std::optional<std::string>& load_at, const std::optional<std::string>& dialect) {
  Image image = read_any_program(path, include_directories, load_at, dialect, {});
  toolchain::require_c40(image, path);
  return image;
}

Image read_any_program(const std::string& path, const std::vector<std::string>& include_directories,
                       const std::optional<std::string>& load_at, const std::optional<std::string>& dialect,
                       const std::optional<std::string>& cpu) {
  require_file(path);
  const std::string suffix = std::filesystem::path(path).extension().string();
  if (dialect && !is_source(suffix))
    throw InputError(fmt::format("--dialect: {} is not a source file; only .asm and .s have a dialect", path));
  if (cpu && is_coff_name(path))
    throw InputError(fmt::format("--cpu: {} is a COFF file, which names its processor itself", path));
  const isa::Cpu wanted = cpu ? isa::cpu_named(*cpu).value() : isa::Cpu::c40;
  if (suffix == ".hex") return read_hex(path, load_at ? parse_address(*load_at, nullptr, "--load-at") : 0, wanted);
  if (load_at) throw InputError("--load-at: is for .hex files only; other programs contain their addresses");
  if (is_source(suffix)) {
    toolchain::Options options;
    for (const std::string& directory : include_directories) options.include_dirs.emplace_back(directory);
    if (dialect) options.dialect = toolchain::dialect_named(*dialect);
    options.cpu = wanted;
    Image image = toolchain::assemble_file(path, options);
    if (image.sections.empty()) throw InputError(fmt::format("{}: contains no word; a program has at least one", path));
    return image;
  }
  toolchain::Object object = toolchain::read_object(path);
  Image image = object.executable ? toolchain::image_of(object)
                                  : toolchain::link({std::move(object)}, {}, toolchain::MemoryMap::standard()).image;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  toolchain::add_source_text(image, folder);
  toolchain::name_sources_as_found(image, folder);
  return image;
}

bool is_source_name(const std::string& path) { return is_source(std::filesystem::path(path).extension().string()); }

Address parse_address(std::string_view text, const Image* image, std::string_view what) {
  if (const auto address = toolchain::find_address(text, image)) return *address;
  throw InputError(fmt::format("{}: {}", what, toolchain::no_address(text, image)));
}

ChipText chip_text(std::string_view text, std::size_t chips, std::string_view what) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return {{}, text};
  const std::string_view number = text.substr(0, colon);
  const auto chip = toolchain::find_address(number, nullptr);
  if (!chip || *chip >= chips)
    throw InputError(
        fmt::format("{} {}: there is no chip \"{}\"; 0 to {} are possible", what, text, number, chips - 1));
  return {*chip, text.substr(colon + 1)};
}

machine::BoardDescription board_named(const ExecOptions& options, const std::string& name) {
  machine::BoardDescription description = machine::read_board(name);
  for (const std::string& warning : description.warnings) io::print(stderr, "{}\n", warning);
  if (!options.memory_max) return description;
  if (!description.board.is_flat)
    throw InputError(fmt::format("--memory-max: board {} has as much RAM as it says; --board flat is expected", name));
  constexpr std::uint64_t words_per_mib = (std::uint64_t{1} << 20) / sizeof(c40::Word);
  description.board.flat_words_max = *options.memory_max * words_per_mib;
  return description;
}

}  // namespace cli
