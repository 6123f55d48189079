#pragma once
/// The communication ports of a chip, and the links at their other ends.
#include <array>

#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/events.hpp"

namespace c40 {

class Ports {
 public:
  Ports(std::array<CommPort, port_count>& sides, const PeripheralNotifier& tell) : sides_(sides), tell_(tell) {}

  CommPort& operator[](int n) { return sides_[static_cast<std::size_t>(n)]; }
  /// Null detaches.
  void attach(int n, PortListener* link);
  PortListener* listener(int n) const { return listeners_[static_cast<std::size_t>(n)]; }
  /// Bit n: port n has a listener.
  Word attached() const { return attached_; }

  /// An access that takes place without telling the outside before.
  bool is_free(const PortAccess& access) const {
    return listener(access.port) == nullptr && access.ready(sides_[static_cast<std::size_t>(access.port)]);
  }
  /// Reports an access that has taken place in cycle `at`.
  /// \param read the value of a read
  /// \param channel the DMA channel; -1: the processor
  void accessed(const PortAccess& access, Word read, Cycles at, int channel);

  void about_to_reset(Cycles at);
  void reset(Cycles at);

 private:
  std::array<CommPort, port_count>& sides_;
  const PeripheralNotifier& tell_;
  std::array<PortListener*, port_count> listeners_{};
  Word attached_ = 0;
};

}  // namespace c40
