// The devices behind the windows of a network's boards, and the nets to the pins that they pull.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Cycles;
using c40::Pin;

void Network::add_devices() {
  for (auto& node : nodes_) {
    const NetworkChip& d = node->description;
    if (d.board.devices.empty() && d.devices.empty()) continue;
    node->devices = std::make_unique<BoardDevices>(d.board.devices);
    try {
      for (const auto& [described, device] : d.devices) node->devices->add(d.board.board, described, device);
    } catch (const std::invalid_argument& error) {
      throw NetworkError(fmt::format("chip {}: {}", node->number, error.what()));
    }
    for (const auto& memory : memories_)
      for (const auto& [chip, base] : memory->description.places)
        for (const auto& [described, device] : node->devices->places())
          if (chip == node->number && described.base < std::uint64_t{base} + memory->description.words &&
              base < std::uint64_t{described.base} + described.words)
            throw NetworkError(fmt::format("memory {}: chip {} has device {} at {:08X}h", memory->description.name,
                                           chip, described.name, described.base));
  }
}

/// Adds a net without a driver for each pin of a chip that its devices or a dual-port memory pull.
void Network::add_pin_nets() {
  const auto add = [&](std::string name, std::size_t chip, Pin pin) {
    NetDescription net;
    net.name = std::move(name);
    net.receivers = {{chip, pin}};
    description_.nets.push_back(std::move(net));
  };
  for (std::size_t n = 0; n < description_.nets.size(); ++n)
    if (description_.nets[n].name.empty()) description_.nets[n].name = fmt::format("{}", n);
  for (const auto& node : nodes_)
    if (node->devices != nullptr)
      for (const Pin pin : node->devices->pins())
        add(fmt::format("devices of chip {}", node->number), node->number, pin);
  for (const auto& memory : memories_)
    for (std::size_t side = 0; side < memory->description.pins.size() && side < 2; ++side)
      if (const auto pin = memory->description.pins[side])
        add(fmt::format("memory {}", memory->description.name), memory->description.places[side].first, *pin);
}

void Network::join_pin_nets() {
  const auto net_to = [&](std::size_t chip, Pin pin) {
    const auto found = std::ranges::find_if(nets_, [&](const auto& net) {
      return std::ranges::find(net->description().receivers, ChipPin{chip, pin}) != net->description().receivers.end();
    });
    return found->get();
  };
  for (auto& node : nodes_) {
    if (node->devices == nullptr) continue;
    if (node->devices->act_on_others()) acting_.push_back(node.get());
    if (node->devices->pins().empty() && !node->devices->act_on_others()) continue;
    node->device_turn = device_turns_.emplace_back(std::make_unique<DeviceTurn>(*node)).get();
    node->devices->on_pin = [this, &node = *node, net_to](Pin pin, bool level, Cycles cycle) {
      net_to(node.number, pin)
          ->script(level ? c40::Drive::none : c40::Drive::low, std::max(now_, node.clock.at(cycle)));
    };
  }
  for (auto& memory : memories_)
    for (std::size_t side = 0; side < memory->description.pins.size() && side < 2; ++side)
      if (const auto pin = memory->description.pins[side]) {
        Net* net = memory->mailbox_nets[side] = net_to(memory->description.places[side].first, *pin);
        net->moved_by(*nodes_[memory->description.places[1 - side].first]);
      }
}

BoardDevices* Network::devices(std::size_t n) { return nodes_.at(n)->devices.get(); }

Cycles Network::present_cycle(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  return std::max(node.chip.cycle(), node.first_cycle(now_));
}

/// At the end of a run: so its end shows what the devices have sent by then. What a device does to a pin or to other
/// chips has its turn.
void Network::settle_devices() {
  for (auto& node : nodes_) {
    if (node->devices == nullptr) continue;
    const bool has_dma = node->chip.dma_active();
    const Cycles settled = node->chip.settled() - (has_dma ? 1 : 0);
    Cycles last = node->first_cycle(now_);
    if (has_dma || node->status == ChipStatus::running) last = std::min(last, settled);
    if (node->device_turn != nullptr) last = std::min(last, node->devices->next_event() - 1);
    node->devices->settle(last);
  }
}

void Network::Node::note_device_event() {
  const Cycles event = device_turn == nullptr ? never_cycle : devices->next_event();
  // Text that its user typed between two runs takes effect at the beginning of the next run.
  device_event = event == never_cycle ? never : std::max(network.now_, clock.at(event));
}

/// The devices could still interrupt the chip.
bool Network::Node::devices_continue() const {
  if (device_turn == nullptr || devices->next_event() == never_cycle) return false;
  if (devices->will_act_on_others()) return true;
  return std::ranges::any_of(devices->pins(), [&](Pin pin) { return listens_to(pin) && reacts_to(pin); });
}

/// At one instant chips act in the order of their numbers; devices that act by themselves come before all chips. A chip
/// that waits or sleeps, and whose turn it is not, does nothing in this instant that others could see.
Cycles Network::Node::last_before_devices() const {
  Cycles last = std::numeric_limits<Cycles>::max();
  const auto bound = [&](Time time, bool with) {
    if (time == never) return;
    const Cycles cycle = first_cycle(time);
    last = std::min(last, with && clock.at(cycle) == time ? cycle : cycle - 1);
  };
  for (const Node* node : network.acting_) {
    if (node == this) continue;
    const bool before_it = number < node->number, armed = node->chip.dma_active();
    bound(node->next_device_event(), false);
    if (node->status == ChipStatus::running)
      bound(node->now(), before_it);
    else if (node->waits_for_device() && !armed)
      bound(node->access_time(), before_it);
    else if (!node->has_ended() || armed)
      bound(network.scheduler_.earliest(), before_it || node->planned() > network.scheduler_.earliest());
  }
  return last;
}

/// An access to a device that acts on others, in its place in the order of the network. It may change devices of other
/// chips.
void Network::perform_device(Node& node) {
  const c40::ExternalAccess& access = node.stop.access;
  const Cycles cycle = node.first_cycle(now_), waited = cycle - access.cycle;
  c40::ExternalAccess there = access;
  there.cycle = cycle;
  const BoardDevices::Answer answer = *node.devices->access(there);
  if (access.write)
    node.chip.complete_write(waited, answer.waits);
  else
    node.chip.complete_read(answer.value, waited, answer.waits);
  if (access.channel >= 0) node.dma_answered = now_;
  node.status = ChipStatus::running;
  devices_acted();
}

/// The effect of one device may show at the pins of other chips.
void Network::devices_acted() {
  something_happened();
  for (Node* node : acting_) {
    node->devices->look(node->first_cycle(now_));
    node->note_device_event();
    node->device_turn->changed();
    node->changed();
  }
}

/// Any other device belongs to the chip alone: the answer comes at once. Its effect on a pin limits how far the chip
/// may run.
bool Network::Node::serve_device(const c40::ExternalAccess& access) {
  serve(*devices, chip, access);
  if (access.write) network.something_happened(clock.at(access.cycle));
  if (device_turn == nullptr) return true;
  note_device_event();
  device_turn->changed();
  if (passing_) return true;
  // The processor finishes the instruction with the access; beside an access of the DMA it begins none.
  const Cycles horizon = first_cycle(horizon_of_follower());
  ends_ = std::min(ends_, access.channel < 0 ? std::max(horizon, chip.cycle() + 1) : horizon);
  return true;
}

}  // namespace machine
