#pragma once
// What a network is made of, for its own sources only.
#include <optional>
#include <utility>
#include <vector>

#include "machine/address_names.hpp"
#include "machine/boot.hpp"
#include "machine/loop_watch.hpp"
#include "machine/network.hpp"

namespace machine {

struct Network::Memory {
  SharedMemory description;
  std::vector<c40::Word> words;
  Time free{0};                      ///< of the access under way
  std::optional<std::size_t> owner;  ///< of the lock

  void list_state(state::Visitor& list);
};

struct Network::Node : c40::PeripheralSink {
  Node(std::size_t number_, NetworkChip given, Clock clock_)
      : number(number_),
        description(std::move(given)),
        clock(clock_),
        chip(board_of(description)) {}

  /// One that says nothing of its pins is made to boot from the ports.
  static const c40::Board& board_of(NetworkChip& chip) {
    if (chip.boot && !chip.board.has_pins) chip.board.board = with_boot_from_port(std::move(chip.board.board));
    return chip.board.board;
  }

  std::size_t number;
  NetworkChip description;
  Clock clock;
  c40::Chip chip;
  ChipStatus status = ChipStatus::running;
  c40::StopInfo stop;              ///< of a chip that waits, or why it ended
  bool was_ready = false;     ///< what it waits for, when last looked at
  Time ready_since{0};
  c40::Cycles asleep_since = 0;  ///< of one that sleeps in a branch to itself
  std::vector<std::size_t> links;

  /// Whether it polls for ever: looked at when nothing has happened for a while, and then ever more rarely.
  struct Patience {
    static constexpr c40::Cycles first = 10'000;
    static constexpr int growth = 8;
    c40::Cycles since = 0;         ///< nothing has happened anywhere
    c40::Cycles length = first;    ///< until the next look
    std::uint64_t happenings = 0;  ///< as they stood then
    std::optional<LoopWatch> looking;
    std::optional<LoopWatch::Loop> loop;  ///< found; it holds until something happens
    bool is_private = false;              ///< it reads nothing that anybody else could change
    c40::Cycles next_look() const { return since + length + (looking ? length / 10 : 0); }
  } patience;
  c40::TraceSink* trace = nullptr;
  mutable std::optional<AddressNames> named;
  /// Of its program's addresses, made when first asked for.
  const AddressNames& names() const { return named ? *named : named.emplace(*description.program); }
  std::vector<c40::PeripheralEvent> peripheral_events;
  void happened(const c40::PeripheralEvent& event) override { peripheral_events.push_back(event); }

  void list_state(state::Visitor& list);
  bool waits_for_port() const { return status == ChipStatus::waiting && stop.reason != c40::StopInfo::Reason::external_access; }
  bool waits_for_memory() const { return status == ChipStatus::waiting && stop.reason == c40::StopInfo::Reason::external_access; }
  c40::Cycles first_cycle(Time time) const { return clock.tick_at_or_after(time); }
  /// Everything before it is done, by the processor and by the DMA.
  Time now() const { return clock.at(chip.settled()); }
  /// It goes on by itself, and its ports decide how: it must not run past what they do.
  bool follows_ports() const {
    if (status == ChipStatus::running) return chip.watches_ports();
    return status == ChipStatus::waiting && chip.dma_busy();
  }
  bool held() const { return status == ChipStatus::held || status == ChipStatus::pulled_out; }
  bool dma_waits() const {
    const bool lives = status == ChipStatus::running || status == ChipStatus::waiting || status == ChipStatus::sleeping;
    return lives && chip.dma_active() && !chip.dma_busy();
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
