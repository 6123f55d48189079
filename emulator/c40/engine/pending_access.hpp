#pragma once
/// The unanswered access of the instruction at PC, to a window or to a communication port; the outside answers it.
#include <algorithm>
#include <cstddef>

#include "c40/chip/chip.hpp"
#include "c40/chip/state.hpp"

namespace c40 {

/// Keeps State::stalled_on_port, and writes State::answers.
class PendingAccess {
 public:
  explicit PendingAccess(State& state) : state_(state) {}

  /// The instruction's access `slot` begins. If the DMA has an access to a window under way, that one comes first.
  void begin(std::size_t slot, const ExternalAccess& access) {
    window_ = access;
    begin(Kind::window, slot, window_.cycle);
  }
  void begin(std::size_t slot, const PortAccess& access);
  /// The access is not needed any more.
  void forget();

  bool at_window() const { return kind_ == Kind::window; }
  bool at_port() const { return kind_ == Kind::port; }
  bool any() const { return kind_ != Kind::none; }
  /// The instruction at PC has an answer to continue with.
  bool is_answered() const { return state_.answers[0].given || state_.answers[1].given; }
  /// The instruction has this answer.
  bool is_answer_to(std::size_t slot, Address address, bool write) const {
    const Answer& answer = state_.answers[slot];
    return answer.given && answer.address == address && answer.write == write;
  }
  void forget_answer(std::size_t slot) { state_.answers[slot] = {}; }
  /// The access begun last.
  const ExternalAccess& window() const { return window_; }
  const PortAccess& port() const { return port_; }
  /// When the access begins.
  Cycles cycle() const { return at_port() ? port_.cycle : window_.cycle; }

  /// Answers an access to a window. Throws std::logic_error if no such access in this direction waits, and
  /// std::invalid_argument for a negative number of cycles.
  void answer_window(bool write, Word value, Cycles arbitration, Cycles transfer);
  /// The access to the port has taken place in cycle `at`.
  void answer_port(Word value, Cycles at);

  /// Whether the last run ended with a stop: the caller then knows the access and limits the DMA by it.
  void set_reported(bool reported) { reported_ = reported; }
  bool is_reported() const { return any() && reported_; }

  void list_state(state::Visitor& list);

 private:
  enum class Kind : std::uint8_t { none, window, port };
  static constexpr std::size_t no_slot = 2;
  void begin(Kind kind, std::size_t slot, Cycles& cycle) {
    kind_ = kind;
    slot_ = slot;
    held_ = std::max<Cycles>(0, state_.dma.answered_until - cycle);
    cycle += held_;
    state_.stalled_on_port = kind == Kind::port;
  }

  State& state_;
  Kind kind_ = Kind::none;
  std::size_t slot_ = no_slot;  ///< the number of the access within the instruction
  ExternalAccess window_{};
  PortAccess port_{};
  Cycles held_ = 0;  ///< how long the DMA's access to a window delayed it
  bool reported_ = false;
};

}  // namespace c40
