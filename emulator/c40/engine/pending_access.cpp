#include "c40/engine/pending_access.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "state/visitor.hpp"

namespace c40 {

void PendingAccess::begin(std::size_t slot, const PortAccess& access) {
  port_ = access;
  begin(Kind::port, slot, port_.cycle);
}

void PendingAccess::forget() {
  kind_ = Kind::none;
  reported_ = false;
  slot_ = no_slot;
  state_.stalled_on_port = false;
}

void PendingAccess::answer_window(bool write, Word value, Cycles arbitration, Cycles transfer) {
  if (!at_window() || window_.write != write)
    throw std::logic_error(fmt::format("the chip does not wait for a {}", write ? "write" : "read"));
  if (arbitration < 0 || transfer < 0) throw std::invalid_argument("a chip cannot wait a negative number of cycles");
  state_.answers[slot_] = {true, write, window_.address, value, arbitration + held_, transfer, 0};
  forget();
}

void PendingAccess::answer_port(Word value, Cycles at) {
  state_.answers[slot_] = {true, port_.write, port_.address, value, 0, 0, at - port_.cycle + held_};
  forget();
}

// The rest of an answered access has no meaning.
void PendingAccess::list_state(state::Visitor& list) {
  std::size_t window_slot = at_window() ? slot_ : no_slot, port_slot = at_port() ? slot_ : no_slot;
  list("waiting_access", window_slot);
  list("port_slot", port_slot);
  ExternalAccess window = at_window() ? window_ : ExternalAccess{};
  PortAccess port = at_port() ? port_ : PortAccess{};
  Cycles held = any() ? held_ : 0;
  list("access", window);
  list("port_access", port);
  list("held", held);
  bool reported = is_reported();
  list("reported", reported);
  if (!list.loads()) return;
  kind_ = window_slot < no_slot ? Kind::window : port_slot < no_slot ? Kind::port : Kind::none;
  slot_ = at_window() ? window_slot : at_port() ? port_slot : no_slot;
  window_ = window, port_ = port, held_ = held, reported_ = reported;
}

}  // namespace c40
