#pragma once
// cmrc._core.c40.Processor: one chip with its board, as Python holds it.
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/observers/self_check.hpp"
#include "c40/peripherals/events.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/boards/board_reserved.hpp"
#include "python/bindings/c40/devices.hpp"
#include "python/bindings/interpreter/warnings.hpp"
#include "state/file.hpp"
#include "toolchain/objects/image.hpp"

/// A chip that Python runs, and the devices on its board.
class Processor : public c40::PeripheralSink {
 public:
  Processor(const std::string& board, bool checks, const std::vector<py::object>& own)
      : Processor(python::read_board(board), checks, own) {}
  Processor(machine::BoardDescription described, bool checks, const std::vector<py::object>& own);

  void load_words(c40::Address address, const std::vector<c40::Word>& words) { chip.write_block(address, words); }
  void load_image(const toolchain::Image& image);
  py::dict run(c40::Cycles max_cycles, std::optional<c40::Address> until);
  void add_breakpoint(c40::Address address);
  void remove_breakpoint(c40::Address address);
  /// Stops no more at the ends of the program, as a debugger does.
  void forget_ends() { chip.stop_at_ends(false); }
  py::list trace(c40::Cycles max_cycles);

  py::dict step();
  py::list diagnostics() const;

  void record_events() { chip.set_peripheral_sink(this); }
  void happened(const c40::PeripheralEvent& event) override;

  /// \throws StateError with checks on: what they have seen is not saved
  state::Key configuration(const toolchain::Image* program) const;

  std::string board;  ///< what has to be the same for a state to fit
  c40::Board surroundings;
  c40::Chip chip;
  machine::BoardDevices devices;
  std::optional<machine::LoneDevices> around;
  machine::IgnoredAccesses ignored;
  /// The chip, and what is around it.
  void list_state(state::Visitor& list);
  std::optional<c40::SelfCheck> self_check;
  py::list events;

 private:
  std::set<c40::Address> breakpoints_;  ///< those of the caller
  std::optional<c40::Address> until_;   ///< one more, where the last run was to end

  /// A change of breakpoints makes the chip forget its blocks: a caller that calls one routine after the other, each to
  /// the same return address, keeps them.
  void stop_at(std::optional<c40::Address> until);
  bool is_own_breakpoint(c40::Address address) const { return breakpoints_.contains(address) || until_ == address; }
  /// By a device, or as an access to nothing.
  bool answered(const c40::ExternalAccess& access) { return around->serve(access) || ignored.serve(chip, access); }
  c40::StopInfo settle_dma();
  /// In slices, so that Ctrl-C is heard.
  c40::StopInfo run_for(c40::Cycles cycles);
};
