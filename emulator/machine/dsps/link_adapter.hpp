#pragma once
// The link adapter (ruling 27): a target with one C40-compatible communication port per DSP slot, each connected to
// port LINK_PORT of that slot's DSP. The host boots DSPs through it (c40_programs/include/task_block.inc has the
// registers).
//
// The adapter's side of a link runs at the DSPs' nominal rate and has the token after a reset; a reset of the DSP
// resets it too. A write that finds the output FIFO full is retried on the bus; a burst is disconnected when the FIFO
// becomes full. An empty slot and a broken wire are cut links.
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "bus_model/bus.hpp"
#include "c40/chip/chip.hpp"
#include "c40/peripherals/link.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/symbols.hpp"

namespace machine {

class LinkAdapter final : public pci::Target {
 public:
  static constexpr Offset base = 0x11000;
  static constexpr Offset size = 0x1000;

  class Client {
   public:
    virtual ~Client() = default;
    /// The host has accessed the port of this slot: its link's next event may have changed.
    virtual void link_changed(unsigned slot) = 0;
    /// A bit of LINK_REQUEST is set.
    virtual void boot_requested(Time now) = 0;
    virtual void link_event(unsigned slot, const c40::LinkEvent& event) = 0;
  };

  /// Throws std::invalid_argument if the program's registers are outside the adapter's addresses.
  LinkAdapter(const Symbols& symbols, unsigned slots, Clock bus_clock, Clock port_clock, Client& client);

  /// Adds the board of slot 0, then 1, ...: its chip must outlive the adapter. Attach the link's side 1 to the chip.
  void join(c40::Chip& chip, const PacedClock& clock, bool plugged);
  c40::Link& link(unsigned slot) { return *ports_.at(slot).link; }
  const c40::Link& link(unsigned slot) const { return *ports_.at(slot).link; }
  /// The end of the link at the DSP.
  int dsp_port() const { return static_cast<int>(symbols_.link_port); }

  /// The DSP of this slot is being reset; to be called before its chip is reset.
  void reset(unsigned slot, Time now);
  void set_plugged(unsigned slot, bool plugged, Time now);
  void set_broken(unsigned slot, bool broken, Time now);
  /// The DSP has left reset.
  void request(unsigned slot, Time now);
  bool answers(Offset offset, bool write) const;
  /// For every link: words written = read + in FIFOs + under way + lost + discarded. Sentences that name what is wrong;
  /// empty unless the model has a fault.
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
        false;  // from a reset until the host clears the bit of LINK_REQUEST: words of an older stream are ignored
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
