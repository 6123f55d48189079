// Layouts of the dock in TOML. The plant can be built with each layout that is accepted.
#include "plant/parameters/layout_file.hpp"

#include "fuzz/target.hpp"
#include "plant/dock/dock.hpp"
#include "plant/parameters/check.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  plant::DockConfig dock;
  if (!fuzz::done<plant::LayoutError>([&] { plant::apply_layout(dock, input.text(), "input"); })) return 0;
  fuzz::done<std::invalid_argument>([&] { plant::Dock made(dock); });
  return 0;
}
