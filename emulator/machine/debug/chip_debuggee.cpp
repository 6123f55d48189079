#include "machine/debug/chip_debuggee.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "c40/values/float40.hpp"
#include "isa/program_end.hpp"
#include "isa/types.hpp"
#include "machine/chips/asleep.hpp"
#include "machine/chips/chip_stop.hpp"
#include "state/archive.hpp"

namespace machine::debug {

ChipDebuggee::ChipDebuggee(c40::Chip& chip, const toolchain::Image& program, BoardDevices* devices, LoneDevices* around,
                           IgnoredAccesses* ignored)
    : chip_(chip),
      devices_(devices),
      around_(around),
      ignored_(ignored),
      program_(program),
      now_(chip.cycle() * period) {
  notice_halt();
}

bool ChipDebuggee::answered(const c40::ExternalAccess& access) {
  return (around_ != nullptr && around_->serve(access)) || (ignored_ != nullptr && ignored_->serve(chip_, access));
}

void ChipDebuggee::set_trace(std::size_t, c40::TraceSink* sink) {
  if (sink == nullptr) return chip_.set_trace(before_);
  before_ = chip_.trace();
  chip_.set_trace(sink);
}

void ChipDebuggee::run_until(Time time) {
  const c40::Cycles limit = (time + period - Time{1}) / period;
  chip_.stop_at_ends(true);
  bool at_end = chip_.program_end() != isa::ProgramEnd::none;  // the next instruction may be the program's last one
  while (!over_ && chip_.cycle() < limit) {
    const c40::Cycles far = around_ != nullptr ? around_->limit(limit) : limit;
    const c40::StopInfo stop = chip_.run_until(std::exchange(at_end, false) ? std::min(far, chip_.cycle() + 1) : far);
    if (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access)) continue;
    if (meaning(stop.reason) == StopMeaning::asks_again) continue;
    at_end = meaning(stop.reason) == StopMeaning::breakpoint;
    over_ = end_of(stop);
    calls_ = stop.reason == c40::StopInfo::Reason::software_interrupt;
  }
  if (around_ != nullptr) around_->run_ended();
  now_ = over_ ? std::max(now_, std::min(time, chip_.cycle() * period)) : std::max(now_, time);
}

std::optional<std::string> ChipDebuggee::end_of(const c40::StopInfo& stop) const {
  switch (meaning(stop.reason)) {
    case StopMeaning::window_access:
      return fmt::format("a {} of the window at {:08X}h waits for its answer", stop.access.write ? "write" : "read",
                         stop.access.address);
    case StopMeaning::port_access:
    case StopMeaning::port_wait: return fmt::format("{} waits", c40::describe(stop.port));
    case StopMeaning::fault:
      if (stop.reason == c40::StopInfo::Reason::software_interrupt) return waits_before_swi(chip_.pc());
      return fault_of(chip_, stop).message;
    case StopMeaning::breakpoint: return rests();
    default: break;
  }
  // At an end of the program it stops by itself: a probe is to hear of the branch first.
  return !chip_.idle() && chip_.program_end() != isa::ProgramEnd::none ? std::nullopt : rests();
}

/// In IDLE, or in a branch to itself. None: neither, or something will take it from there.
std::optional<std::string> ChipDebuggee::rests() const {
  if (!rests_forever(chip_) || (around_ != nullptr && around_->could_wake())) return std::nullopt;
  if (chip_.idle()) return fmt::format("IDLE before {:08X}h, and no interrupt will come", chip_.pc());
  if (chip_.program_end() == isa::ProgramEnd::halt) return fmt::format("branches to itself at {:08X}h", chip_.pc());
  return std::nullopt;
}

/// A fault that the chip met without the debugger.
void ChipDebuggee::notice_halt() {
  if (chip_.halted() && !over_) over_ = "it is halted after a fault";
}

// A chip that has not ended yet finds its end by itself: a probe is to hear of it.
void ChipDebuggee::look_again() {
  notice_halt();
  if (!over_ || chip_.halted()) return;
  over_ = rests();
  calls_ = false;
}

void ChipDebuggee::list_state(state::Visitor& list) {
  list("chip", chip_);
  list("over", over_);
  list("calls", calls_);
  if (ignored_ != nullptr) list("ignored", *ignored_);
  if (devices_ == nullptr) return;
  list("devices", *devices_);
  list("around", *around_);
}

namespace {
struct Listed {
  std::function<void(state::Visitor&)> list;
  void list_state(state::Visitor& visitor) { list(visitor); }
};
}  // namespace

std::string ChipDebuggee::save() {
  return state::save(Listed{[this](state::Visitor& list) { list_state(list); }});
}

void ChipDebuggee::load(std::string_view state) {
  Listed all{[this](state::Visitor& list) { list_state(list); }};
  state::load(all, state);
  notice_halt();
  now_ = chip_.cycle() * period;
}

std::optional<Word> ChipDebuggee::peek(std::size_t, Address address) {
  try {
    return chip_.peek(address);
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

}  // namespace machine::debug
