// Configurations in TOML. One that is accepted is printed, and what was printed is read as the same.
#include "cmrc/configuration/config.hpp"

#include "fuzz/target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  std::string printed;
  const auto print = [&] { printed = cmrc::to_toml(cmrc::ConfigBuilder().text(input.text(), "input").build()); };
  if (!fuzz::done<cmrc::ConfigError>(print)) return 0;
  const std::string again = cmrc::to_toml(cmrc::ConfigBuilder().text(printed, "printed").build());
  fuzz::expect(again == printed, "a printed configuration is read as another");
  return 0;
}
