#pragma once
/// The loop that runs a chip, and the only place that tells apart why it stopped: for exec, networks and the dock.
#include <optional>

#include "c40/chip.hpp"
#include "machine/chip_stop.hpp"

namespace machine {

/// Who drives a chip: how far it may run, and what comes of each stop. Every answer `true` lets the chip go on.
class ChipRunner {
 public:
  /// As c40::Chip::run_until takes them.
  struct Span {
    c40::Cycles limit = 0;
    c40::Cycles known = 0;         ///< so far is known what its ports do
    bool one_instruction = false;  ///< the next instruction and no more, wherever it ends
  };

  ChipRunner() = default;
  ChipRunner(const ChipRunner&) = delete;
  ChipRunner& operator=(const ChipRunner&) = delete;
  virtual ~ChipRunner() = default;

 protected:
  /// Runs the chip until a stop ends it, or there is no span.
  void run_chip(c40::Chip& chip);

 private:
  virtual std::optional<Span> span() = 0;
  virtual bool at_limit() = 0;
  virtual bool asks_anew() = 0;
  virtual bool at_breakpoint() = 0;
  virtual bool window_access(const c40::ExternalAccess& access) = 0;
  virtual bool port_access(const c40::PortAccess& access) = 0;
  virtual bool port_wait(const c40::PortAccess& access) = 0;
  virtual bool faulted(const c40::Fault& fault) = 0;

  bool goes_on(const c40::Chip& chip, const c40::StopInfo& stop);
};

}  // namespace machine
