// Programs of hexadecimal words, and the place that a user gives one.
#include "cli/arguments/program.hpp"

#include "fuzz/target.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/objects/coff.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  if (size > most) return 0;
  static const fuzz::InputFile file("program.hex");
  fuzz::Input input(data, size);
  const std::string place(input.part());
  const std::string& path = file.write(input.text());
  fuzz::done<cli::InputError>([&] {
    const toolchain::Image image = cli::read_program(path, {}, place.empty() ? std::nullopt : std::optional(place));
    fuzz::expect(image.sections.size() == 1 && image.sections[0].words.size() == image.sections[0].size,
                 "words are missing");
  });
  return 0;
}
