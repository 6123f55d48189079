// c40_asm FILE -o OUT [-I DIR]... [-D NAME=VALUE]... [--section NAME=ADDRESS]... [--entry SYMBOL] [--dialect ti|gnu]
//         [--listing FILE] [--source-map FILE]
//
// Assembles one source file to a COFF executable. Exit status 2 and no output file if anything is wrong.
#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "io/output_file.hpp"
#include "isa/ascii.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/source_map.hpp"

namespace {

struct Arguments {
  std::filesystem::path input, output, listing, source_map;
  toolchain::Options options;
};

constexpr std::string_view usage =
    "usage: c40_asm FILE -o OUT [-I DIR]... [-D NAME=VALUE]... [--section NAME=ADDRESS]... [--entry SYMBOL] [--dialect "
    "ti|gnu] [--listing FILE] [--source-map FILE]";

/// \param equals the place of the equals sign, or npos
std::pair<std::string, toolchain::Word> parse_assignment(const std::string& text, std::size_t equals) {
  const std::string number = equals == std::string::npos ? "1" : text.substr(equals + 1);
  const bool hex = number.starts_with("0x");
  const auto value = ascii::number<toolchain::Word>(number.substr(hex ? 2 : 0), hex ? 16 : 10);
  if (!value || equals == 0)
    throw std::invalid_argument(fmt::format("'{}' is not NAME=NUMBER (decimal or 0x...)\n{}", text, usage));
  return {text.substr(0, equals), *value};
}

Arguments parse(int count, char** values) {
  Arguments out;
  for (int i = 1; i < count; ++i) {
    const std::string argument = values[i];
    const auto next = [&]() -> std::string {
      if (i + 1 >= count) throw std::invalid_argument(fmt::format("'{}' needs a value\n{}", argument, usage));
      return values[++i];
    };
    if (argument == "-o")
      out.output = next();
    else if (argument == "-I")
      out.options.include_dirs.emplace_back(next());
    else if (argument == "-D") {
      const std::string text = next();
      out.options.symbols.insert(parse_assignment(text, text.find('=')));
    } else if (argument == "--section") {
      const std::string text = next();
      const auto [name, address] = parse_assignment(text, text.rfind('='));  // the name may have one
      out.options.sections[name] = address;
    } else if (argument == "--entry")
      out.options.entry = next();
    else if (argument == "--dialect") {
      const std::string text = next();
      out.options.dialect = toolchain::dialect_named(text);
      if (!out.options.dialect)
        throw std::invalid_argument(
            fmt::format("--dialect: '{}' is unknown; ti and gnu are possible\n{}", text, usage));
    } else if (argument == "--listing")
      out.listing = next();
    else if (argument == "--source-map")
      out.source_map = next();
    else if (argument.starts_with("-") || !out.input.empty())
      throw std::invalid_argument(fmt::format("'{}' not understood\n{}", argument, usage));
    else
      out.input = argument;
  }
  if (out.input.empty() || out.output.empty()) throw std::invalid_argument(std::string(usage));
  return out;
}

void write(const std::filesystem::path& path, const std::string& text) {
  io::OutputFile file(path.string());
  file.stream() << text;
  file.commit();
}

}  // namespace

int main(int count, char** values) {
  try {
    const Arguments arguments = parse(count, values);
    toolchain::Image image = toolchain::assemble_file(arguments.input, arguments.options);
    for (const std::string& warning : image.warnings) fmt::print(stderr, "{}\n", warning);
    if (!arguments.listing.empty()) write(arguments.listing, toolchain::listing(image));
    if (!arguments.source_map.empty()) {
      write(arguments.source_map, toolchain::source_map(image, arguments.input.parent_path()));
      image.files.clear(),
          image.lines.clear();  // one file with the lines is enough, and the source map names no folder of this machine
    }
    toolchain::write_coff(image, arguments.output);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
