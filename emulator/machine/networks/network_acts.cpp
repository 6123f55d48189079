// What actions do to a network: links are cut, nets driven, chips held, reset and pulled out.
#include "c40/peripherals/comm_port.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

void Network::actions_happen(Time time) {
  now_ = time;
  // An action on a chip in the middle of an instruction waits for its end, and the chip's DMA comes there.
  for (auto& node : nodes_) {
    const bool meant = next_action_on(*node) != never_cycle;
    const bool only_dma = node->status == ChipStatus::waiting && node->dma_waits();  // as in follow_to
    if (node->follows() || only_dma || (meant && node->status == ChipStatus::running && node->chip.dma_active()))
      node->run_to(time);
    else if (meant && node->status == ChipStatus::sleeping)
      node->bring_to(time, false);
  }
  for (std::size_t i = 0; i < actions_.size() && actions_[i].time <= time;) {
    if (effective(actions_[i]) > time) {
      ++i;
      continue;
    }
    const NetworkAction action = actions_[i];
    actions_.erase(actions_.begin() + static_cast<std::ptrdiff_t>(i));
    const Node* meant = target_of(action.kind) == ActionTarget::chip ? nodes_[action.target].get() : nullptr;
    for (auto& node : nodes_)
      if (node->status == ChipStatus::sleeping) node->bring_to(time, node.get() != meant);
    something_happened();
    changed_ = time;
    perform(action);
    for (auto& node : nodes_) node->note_ready(time), node->wake_up();
  }
  scheduler_.all_changed();
}

void Network::perform(const NetworkAction& action) {
  using enum NetworkAction::Kind;
  if (action.kind == cut) return links_[action.target]->cut(now_);
  if (action.kind == restore) return links_[action.target]->restore(now_);
  if (target_of(action.kind) == ActionTarget::net) {
    Net& net = *nets_[action.target];
    if (action.kind == pulse) return net.script(PulseTrain{now_, action.width, action.period, action.count});
    return net.script(action.kind == low    ? c40::Drive::low
                      : action.kind == high ? c40::Drive::high
                                            : c40::Drive::none,
                      now_);
  }
  Node& node = *nodes_[action.target];
  if (node.status == ChipStatus::pulled_out) return;  // an edge of its RESET pin at the instant at which it left
  const auto kind = action.kind == reset     ? NetworkEvent::Kind::reset
                    : action.kind == hold    ? NetworkEvent::Kind::hold
                    : action.kind == release ? NetworkEvent::Kind::release
                                             : NetworkEvent::Kind::pull_out;
  events_.push_back({kind, now_, node.number, 0, 0, 0});
  if (action.kind == release && node.status != ChipStatus::held) return;  // no hold ends
  node.bring_to(now_, false);
  node.patience = {};
  node.chip.set_trace(node.trace);
  switch (action.kind) {
    case reset:
      if (node.reset_is_low()) return;
      return reset_chip(node);
    case release:
      if (node.reset_is_low()) return;
      node.chip.hold(false);
      node.status = node.chip.halted() ? ChipStatus::fault : ChipStatus::running;
      return node.note_idle();  // where the chip is, not where its next run will end
    case pull_out:
      for (const std::size_t link : node.links) links_[link]->cut(now_);
      free_locks(node);
      return freeze(node, ChipStatus::pulled_out);
    default:
      if (node.reset_is_low()) free_locks(node);
      freeze(node, ChipStatus::held);
  }
}

/// Its DMA and its timers, too, have done everything before this instant, and do nothing from now on.
void Network::freeze(Node& node, ChipStatus status) {
  if (!node.held()) node.chip.let_peripherals_reach(node.chip.cycle());
  node.chip.hold(true);
  node.status = status;
}

/// Of a chip in reset.
void Network::free_locks(const Node& node) {
  for (auto& memory : memories_)
    if (memory->owner == node.number) memory->owner.reset();
}

void Network::reset_chip(Node& node) {
  for (int n = 0; n < c40::port_count; ++n)
    for (const c40::Fifo* fifo : {&node.chip.port(n).output, &node.chip.port(n).input})
      for (const c40::Word word : fifo->words())
        events_.push_back(
            {NetworkEvent::Kind::discarded, now_, node.number, n, word, fifo == &node.chip.port(n).input ? 1 : 0});
  free_locks(node);
  if (!node.description.boot) node.chip.reset();  // booting resets it already
  start(node);
  node.chip.hold(false);  // after the reset: its timers drive their pins no more
}

}  // namespace machine
