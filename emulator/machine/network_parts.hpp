#pragma once
// What a network is made of, for its own sources only.
#include <optional>
#include <utility>
#include <vector>

#include "machine/boot.hpp"
#include "machine/network.hpp"

namespace machine {

struct Network::Memory {
  SharedMemory description;
  std::vector<c40::Word> words;
  Time free{0};                      ///< of the access under way
  std::optional<std::size_t> owner;  ///< of the lock
};

struct Network::Node {
  Node(std::size_t number_, NetworkChip given, Clock clock_)
      : number(number_),
        description(std::move(given)),
        clock(clock_),
        chip(description.boot ? with_boot_from_port(description.board.board) : description.board.board) {}

  std::size_t number;
  NetworkChip description;
  Clock clock;
  c40::Chip chip;
  ChipStatus status = ChipStatus::running;
  c40::StopInfo stop;              ///< of a chip that waits, or why it ended
  bool was_ready = false;     ///< what it waits for, when last looked at
  Time ready_since{0};
  std::vector<std::size_t> links;

  bool waits_for_port() const { return status == ChipStatus::waiting && stop.reason != c40::StopInfo::Reason::external_access; }
  bool waits_for_memory() const { return status == ChipStatus::waiting && stop.reason == c40::StopInfo::Reason::external_access; }
  c40::Cycles first_cycle(Time time) const { return clock.tick_at_or_after(time); }
  /// Everything before it is done, by the processor and by the DMA.
  Time now() const { return clock.at(chip.settled()); }
  /// It goes on by itself, and its ports decide how: it must not run past what they do.
  bool follows_ports() const {
    if (status == ChipStatus::running) return chip.watches_ports();
    return status == ChipStatus::waiting && chip.dma_active();
  }
};

/// Keeps what happens on one link.
struct Network::LinkTap final : c40::LinkListener {
  LinkTap(Network& network_, std::size_t number_) : network(network_), number(number_) {}
  void happened(const c40::LinkEvent& e) override {
    const bool common = e.kind == c40::LinkEvent::Kind::word || e.kind == c40::LinkEvent::Kind::token;
    if (common && !network.records_words_) return;
    network.events_.push_back({static_cast<NetworkEvent::Kind>(e.kind), e.time, number, e.side, e.word, e.bytes});
  }
  Network& network;
  std::size_t number;
};

}  // namespace machine
