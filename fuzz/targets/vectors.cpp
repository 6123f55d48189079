// Files of single-step vectors, plain or compressed, through the command itself.
#include "cli/arguments/options.hpp"
#include "cli/arguments/text_lines.hpp"
#include "cli/arguments/vector_line.hpp"
#include "fuzz/target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  constexpr std::uint64_t most_lines = 2000, most_steps = 2000;
  if (size > most) return 0;
  static const fuzz::InputFile file("vectors.txt");
  fuzz::Input input(data, size);
  const std::string& path = file.write(input.text());
  std::uint64_t steps = 0, lines = 0;
  const bool read = fuzz::done<cli::InputError>([&] {
    cli::TextLines text(path);
    for (std::string line; lines <= most_lines && text.next(line); ++lines)
      fuzz::done<cli::VectorError>([&] { steps += cli::parse_vector(line).steps; });
  });
  if (!read || lines > most_lines || steps > most_steps) return 0;
  fuzz::done<cli::InputError>([&] { cli::vectors({.files = {path}, .every_access = true}); });
  return 0;
}
