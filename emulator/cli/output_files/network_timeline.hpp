#pragma once
// exec --perfetto: the events of a network of chips as a Perfetto trace (docs/timelines.md).
#include <iosfwd>

namespace machine {
class Network;
}

namespace cli {

/// To be called after a run with record_words and record_peripherals.
void draw_network(const machine::Network& network, std::ostream& out);

}  // namespace cli
