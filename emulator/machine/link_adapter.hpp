#pragma once
// The link adapter (ruling 27): a target with one C40-compatible communication port per DSP slot, each wired to
// port LINK_PORT of that slot's DSP. The host boots DSPs through it (c40_programs/include/task_block.inc has the
// registers).
//
// The adapter's side of a link runs at the DSPs' nominal rate and begins with the token; a reset of the DSP resets it
// too. A write that finds the output FIFO full is retried on the bus; a burst is disconnected where it becomes full. An
// empty slot, and a broken wire, is a cut link.
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "bus_model/bus.hpp"
#include "c40/chip.hpp"
#include "c40/peripherals/link.hpp"
#include "machine/machine.hpp"
#include "machine/symbols.hpp"

namespace machine {

class LinkAdapter final : public pci::Target {
 public:
  static constexpr Offset base = 0x11000;
  static constexpr Offset size = 0x1000;

  class Client {
   public:
    virtual ~Client() = default;
    /// The host has used the port of this slot: its link's next event may be another.
    virtual void link_changed(unsigned slot) = 0;
    /// A bit of LINK_REQUEST is set.
    virtual void boot_requested(Time now) = 0;
    virtual void link_event(unsigned slot, const c40::LinkEvent& event) = 0;
  };

  /// Throws std::invalid_argument where the program's registers do not lie in the adapter.
  LinkAdapter(const Symbols& symbols, unsigned slots, Clock bus_clock, Clock port_clock, Client& client);

  /// The board of slot 0, then 1, ...: its chip must outlive the adapter. The link's side 1 is to be attached to it.
  void join(c40::Chip& chip, const PacedClock& clock, bool plugged);
  c40::Link& link(unsigned slot) { return *ports_.at(slot).link; }
  const c40::Link& link(unsigned slot) const { return *ports_.at(slot).link; }
  /// The end of the link at the DSP.
  int dsp_port() const { return static_cast<int>(symbols_.link_port); }

  /// The DSP of this slot is being reset; call before its chip is.
  void reset(unsigned slot, Time now);
  void set_plugged(unsigned slot, bool plugged, Time now);
  void set_broken(unsigned slot, bool broken, Time now);
  /// The DSP has left reset.
  void request(unsigned slot, Time now);
  bool answers(Offset offset, bool write) const;
  /// For every link: what was written = read + in FIFOs + under way + lost + discarded. Empty unless the model has a
  /// fault.
  std::vector<std::string> audit() const;
  void append_state(std::vector<std::uint64_t>& words) const;
  void list_state(state::Visitor& list);

  pci::Answer answer(pci::Address offset, unsigned words, bool write, const pci::Access& access) override;
  unsigned most(pci::Address offset, unsigned words, bool write, const pci::Access& access) override;
  Word read(pci::Address offset, const pci::Access& access) override;
  void write(pci::Address offset, Word value, const pci::Access& access) override;

 private:
  struct Port final : c40::LinkListener {
    Port(unsigned number, Client& its_client) : slot{number}, client{its_client} {}
    void happened(const c40::LinkEvent& event) override { client.link_event(slot, event); }
    unsigned slot;
    Client& client;
    c40::CommPort port;
    std::optional<c40::Link> link;
    bool plugged = true, broken = false;
    void list_state(state::Visitor& list) {
      list("port", port);
      list("link", *link);
      list("plugged", plugged);
      list("broken", broken);
      list("closed", closed);
    }
    bool closed =
        false;  // since a reset, until the host clears the bit of LINK_REQUEST: words of an older stream are ignored
  };
  void join(Port& port, Time now);
  void changed(Port& port, const pci::Access& access);

  const Symbols& symbols_;
  unsigned slots_;
  Clock clock_, port_clock_;
  Client& client_;
  std::deque<Port> ports_;
  Word requests_ = 0;
};

}  // namespace machine
