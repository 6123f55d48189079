// emulator asm, emulator link, emulator disasm
#include <fmt/format.h>

#include "cli/arguments/options.hpp"
#include "cli/arguments/program.hpp"
#include "io/file_roles.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "isa/types.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/disassembler/disassembly.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/objects/coff.hpp"

namespace cli {
namespace {

/// NAME=NUMBER; without a number the value is `otherwise`, if there is one.
/// \param equals the place of the equals sign, or npos
std::pair<std::string, toolchain::Word> assignment(const std::string& text, std::string_view option, std::size_t equals,
                                                   std::optional<toolchain::Word> otherwise) {
  const std::string name = text.substr(0, equals);
  if (name.empty() || (equals == std::string::npos && !otherwise))
    throw InputError(fmt::format("{}: \"{}\" is not NAME=NUMBER", option, text));
  if (equals == std::string::npos) return {name, *otherwise};
  return {name, parse_address(std::string_view(text).substr(equals + 1), nullptr, option)};
}

toolchain::Options toolchain_options(const AssembleOptions& options) {
  toolchain::Options out;
  for (const std::string& directory : options.include_directories) out.include_dirs.emplace_back(directory);
  for (const std::string& define : options.defines) out.symbols.insert(assignment(define, "-D", define.find('='), 1));
  for (const std::string& section : options.sections) {
    // The name of a section may have an equals sign.
    const auto [name, address] = assignment(section, "--section", section.rfind('='), std::nullopt);
    out.sections[name] = address;
  }
  out.entry = options.entry.value_or("");
  out.undefined_external = options.undefined_external;
  if (options.dialect) out.dialect = toolchain::dialect_named(*options.dialect);
  if (options.cpu) out.cpu = isa::cpu_named(*options.cpu).value();
  return out;
}

/// \param read the input files: sources with what they include, or objects
void check_files(const std::vector<std::string>& read, const std::string& output, const std::string& role,
                 const std::optional<std::string>& text_path) {
  io::FileRoles files;
  for (const std::string& path : read) files.reads("an input", path);
  files.writes("-o", output).writes(role, text_path.value_or(""));
}

/// Writes the object file, and the listing or map if one is wanted.
void write(toolchain::Object object, int version, const std::string& path, const std::optional<std::string>& text_path,
           const std::string& text) {
  object.version = version;
  io::OutputFile output(path);
  std::optional<io::OutputFile> text_output;
  if (text_path) text_output.emplace(*text_path);
  toolchain::write_coff(object, output.stream());
  if (text_output) text_output->stream() << text;
  output.commit_or_note();
  if (text_output) text_output->commit_or_note();
}

void print_warnings(const toolchain::Image& image) {
  for (const std::string& warning : image.warnings) io::print(stderr, "{}\n", warning);
}

}  // namespace

int assemble(const AssembleOptions& options) {
  require_file(options.source);
  check_files({options.source}, options.output, "--listing", options.listing);
  const toolchain::Options how = toolchain_options(options);
  if (options.object) {
    if (options.entry)
      throw InputError("--entry: the linker decides where a program starts; use emulator link --entry");
    if (!options.sections.empty())
      throw InputError("--section: the linker assigns the addresses; use emulator link --map");
    const auto assembled = toolchain::assemble_object_file(options.source, how);
    check_files(assembled.listed.files_read, options.output, "--listing", options.listing);
    print_warnings(assembled.listed);
    write(assembled.object, options.version, options.output, options.listing,
          options.listing ? toolchain::listing(assembled.listed) : std::string());
    return success;
  }
  const toolchain::Image image = toolchain::assemble_file(options.source, how);
  check_files(image.files_read, options.output, "--listing", options.listing);
  print_warnings(image);
  write(toolchain::executable_of(image), options.version, options.output, options.listing,
        options.listing ? toolchain::listing(image) : std::string());
  return success;
}

int link(const LinkOptions& options) {
  std::vector<std::filesystem::path> files;
  for (const std::string& input : options.inputs) {
    require_file(input);
    files.emplace_back(input);
  }
  if (options.memory_map) require_file(*options.memory_map);
  std::vector<std::string> read = options.inputs;
  read.push_back(options.memory_map.value_or(""));
  check_files(read, options.output, "--map-output", options.map_output);
  toolchain::MemoryMap map =
      options.memory_map ? toolchain::read_memory_map(*options.memory_map) : toolchain::MemoryMap::standard();
  if (options.entry) map.entry = *options.entry;
  if (options.c_model) map.is_c = true, map.loader_sets_values = toolchain::c_model(*options.c_model).value();
  const toolchain::Linked linked = toolchain::link_files(files, map);
  print_warnings(linked.image);
  write(toolchain::executable_of(linked.image), options.version, options.output, options.map_output, linked.map);
  return success;
}

int disassemble(const DisassembleOptions& options) {
  require_file(options.program);
  if (is_coff_name(options.program) && !options.source && !options.cpu) {
    const toolchain::Object object = toolchain::read_object(options.program);
    io::print("{}",
              object.executable ? toolchain::disassembly(toolchain::image_of(object)) : toolchain::disassembly(object));
    return success;
  }
  const toolchain::Image image =
      read_any_program(options.program, options.include_directories, options.load_at, options.dialect, options.cpu);
  io::print("{}", options.source ? toolchain::source_of(image) : toolchain::disassembly(image));
  return success;
}

}  // namespace cli
