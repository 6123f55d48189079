#include "c40/peripherals/ports.hpp"

namespace c40 {

void Ports::attach(int n, PortListener* link) {
  listeners_[static_cast<std::size_t>(n)] = link;
  attached_ = (attached_ & ~(1u << n)) | (link != nullptr ? 1u << n : 0u);
}

void Ports::accessed(const PortAccess& access, Word read, Cycles at, int channel) {
  using Kind = PeripheralEvent::Kind;
  if (access.reg == PortRegister::output && access.write)
    tell_({Kind::port_write, at, access.port, access.value, channel});
  if (access.reg == PortRegister::input && !access.write) tell_({Kind::port_read, at, access.port, read, channel});
  if (PortListener* link = listener(access.port); link != nullptr) link->changed((*this)[access.port], at);
}

void Ports::about_to_reset(Cycles at) {
  for (PortListener* link : listeners_)
    if (link != nullptr) link->about_to_reset(at);
}

void Ports::reset(Cycles at) {
  for (int n = 0; n < port_count; ++n) {
    CommPort& side = (*this)[n];
    side.reset(n);
    if (PortListener* link = listener(n); link != nullptr) link->was_reset(side, at);
  }
}

}  // namespace c40
