#pragma once
// Links between communication ports of the dock's DSP boards: ports 0, 1, 2 of one slot with 4, 5 of another (port 3 is
// the link adapter's, machine/link_adapter.hpp).
//
// A slot that is empty, or whose program has not yet said that it runs, is a cut link: what is on the wires is lost.
// When both programs run, both ports are reset and the wires are joined; what the ports held is discarded. Lost and
// discarded words are counted.
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "c40/peripherals/link.hpp"
#include "machine/scheduler.hpp"
#include "machine/time.hpp"

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
/// \throws std::invalid_argument for a slot or port that there is not, a port that is taken, and ends that cannot be
/// joined
void check(const std::vector<SlotLink>& links, unsigned slots);

/// Of one direction, in words.
struct SlotLinkTraffic {
  std::uint64_t sent = 0, arrived = 0, lost = 0;
  std::uint64_t discarded = 0;  ///< in the FIFOs of both ports, when the ports were reset
  friend bool operator==(const SlotLinkTraffic&, const SlotLinkTraffic&) = default;
};

/// One of them, as an actor.
class SlotWire final : public Scheduler::Actor {
 public:
  SlotWire(SlotLink ends, Dsp& a, Dsp& b);

  Time next() const override;
  void act(Time now) override;
  /// Whether the program of one of the slots runs has changed.
  void slots_changed(Time now);

  const SlotLink& ends() const { return ends_; }
  const c40::Link& link() const { return link_; }
  c40::Link& link() { return link_; }
  /// \param side 0: from a to b
  SlotLinkTraffic traffic(int side) const;
  /// How often the wires have been joined.
  std::uint64_t joined() const { return joined_; }
  void list_state(state::Visitor& list);
  void append_state(std::vector<std::uint64_t>& words) const;

 private:
  void reset_ports(Time now);

  SlotLink ends_;
  Dsp& a_;
  Dsp& b_;
  c40::Link link_;
  Time joins_ = never;  ///< both programs run
  std::uint64_t joined_ = 0;
};

}  // namespace machine
