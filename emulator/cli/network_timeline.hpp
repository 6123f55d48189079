#pragma once
// exec --perfetto: what happened in a network of chips as a Perfetto trace (docs/timelines.md).
#include <iosfwd>

namespace machine {
class Network;
}

namespace cli {

/// After a run with record_words and record_peripherals.
void draw_network(const machine::Network& network, std::ostream& out);

}  // namespace cli
