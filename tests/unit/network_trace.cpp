// A network listens to the instructions of a chip while it finds out whether the chip is in a loop that it cannot
// leave. It may listen no longer than that: the listener that it forgets does not exist any more.
#include <doctest/doctest.h>

#include <memory>
#include <string>

#include "machine/networks/network.hpp"
#include "state/archive.hpp"
#include "toolchain/assembler/assembler.hpp"

namespace {

machine::NetworkChip chip(const std::string& text) {
  machine::NetworkChip made;
  made.program = std::make_shared<toolchain::Image>(toolchain::assemble_text(text, "network_trace"));
  return made;
}

// Chip 1 goes round a loop, and the network listens from cycle 10,000 on. Chip 0 sends a word some 500 cycles later:
// the network leaves off, and begins its watch again.
machine::NetworkDescription sender_and_loop() {
  machine::NetworkDescription network;
  network.chips.push_back(
      chip(" .text\nstart: ldhi 10h,ar0\nagain: ldi 10500,rc\n rpts rc\n nop\n sti r0,*+ar0(42h)\n b again\n"));
  network.chips.push_back(chip(" .text\nstart: nop\n b start\n"));
  network.links.push_back(machine::parse_link("0.0:1.3", {"0", "1"}));
  return network;
}

}  // namespace

TEST_CASE("between two runs a network listens to the same chips as one that was loaded from its state") {
  machine::Network network(sender_and_loop()), loaded(sender_and_loop());
  int listens = 0, leaves_off = 0;
  for (std::int64_t cycle = 9'990; cycle <= 10'700; ++cycle) {
    const bool before = network.chip(1).trace() != nullptr;
    network.run_until(machine::Time{cycle * 50'000});
    state::load(loaded, state::save(network));
    const bool now = network.chip(1).trace() != nullptr;
    for (const std::size_t n : {0u, 1u})
      REQUIRE((network.chip(n).trace() != nullptr) == (loaded.chip(n).trace() != nullptr));
    listens += now;
    leaves_off += before && !now;
  }
  CHECK(listens > 0);
  CHECK(leaves_off > 0);
}
