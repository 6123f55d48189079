#pragma once
// Links between communication ports of the dock's DSP boards: ports 0, 1, 2 of one slot to ports 4, 5 of another (port
// 3 belongs to the link adapter, machine/dsps/link_adapter.hpp).
//
// If a slot is empty, or its program has not yet reported that it runs, the link is cut: words on the wires are lost.
// When both programs run, both ports are reset and the wires are connected; words in the ports are discarded. Lost and
// discarded words are counted.
#include <cstdint>
#include <string>
#include <vector>

#include "c40/peripherals/link.hpp"
#include "machine/time/scheduler.hpp"
#include "machine/time/time.hpp"

namespace state {
class Visitor;
}

namespace machine {

class Dsp;

/// One end of such a link.
struct SlotPort {
  unsigned slot = 0;
  int port = 0;
  friend bool operator==(const SlotPort&, const SlotPort&) = default;
};

struct SlotLink {
  SlotPort a, b;  ///< a has the token after a reset
};

/// "0.1:1.4, 1.0:2.5". \throws std::invalid_argument with what would be right
std::vector<SlotLink> parse_slot_links(std::string_view text);
std::string to_text(const SlotPort& port);
std::string to_text(const SlotLink& link);
/// \throws std::invalid_argument for a slot or port that does not exist, a port with another link, and ends that cannot
/// be connected
void check(const std::vector<SlotLink>& links, unsigned slots);

/// The words of one direction.
struct SlotLinkTraffic {
  std::uint64_t sent = 0, arrived = 0, lost = 0;
  std::uint64_t discarded = 0;  ///< in the FIFOs of both ports, when the ports were reset
  friend bool operator==(const SlotLinkTraffic&, const SlotLinkTraffic&) = default;
};

/// One of the links, as an actor.
class SlotWire final : public Scheduler::Actor {
 public:
  SlotWire(SlotLink ends, Dsp& a, Dsp& b);

  Time next() const override;
  void act(Time now) override;
  /// The program of one of the slots has started or stopped.
  void slots_changed(Time now);

  const SlotLink& ends() const { return ends_; }
  const c40::Link& link() const { return link_; }
  c40::Link& link() { return link_; }
  /// \param side 0: from a to b
  SlotLinkTraffic traffic(int side) const;
  /// How often the wires have been connected.
  std::uint64_t joined() const { return joined_; }
  void list_state(state::Visitor& list);
  void append_state(std::vector<std::uint64_t>& words) const;

 private:
  void reset_ports(Time now);

  SlotLink ends_;
  Dsp& a_;
  Dsp& b_;
  c40::Link link_;
  Time joins_ = never;  ///< when both programs run
  std::uint64_t joined_ = 0;
};

}  // namespace machine
