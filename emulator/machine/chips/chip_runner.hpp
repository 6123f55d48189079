#pragma once
/// The loop that runs a chip, and the only place that distinguishes its stops: for exec, networks and the dock.
#include <optional>

#include "c40/chip/chip.hpp"
#include "machine/chips/chip_stop.hpp"

namespace machine {

/// The driver of a chip: how far the chip may run, and what to do at each stop. If the answer is `true`, the chip runs
/// on.
class ChipRunner {
 public:
  /// The arguments of c40::Chip::run_until.
  struct Span {
    c40::Cycles limit = 0;
    c40::Cycles known = 0;         ///< the chip's ports are known up to here
    bool one_instruction = false;  ///< only the next instruction, wherever it ends
  };

  ChipRunner() = default;
  ChipRunner(const ChipRunner&) = delete;
  ChipRunner& operator=(const ChipRunner&) = delete;
  virtual ~ChipRunner() = default;

 protected:
  /// Runs the chip until a stop ends the run, or there is no span.
  void run_chip(c40::Chip& chip);

 private:
  virtual std::optional<Span> span() = 0;
  virtual bool at_limit() = 0;
  virtual bool asks_again() = 0;
  virtual bool at_breakpoint() = 0;
  virtual bool window_access(const c40::ExternalAccess& access) = 0;
  virtual bool port_access(const c40::PortAccess& access) = 0;
  virtual bool port_wait(const c40::PortAccess& access) = 0;
  virtual bool faulted(const c40::Fault& fault) = 0;

  bool continues(const c40::Chip& chip, const c40::StopInfo& stop);
};

}  // namespace machine
