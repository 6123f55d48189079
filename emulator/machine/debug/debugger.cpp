// The debugger as such: how it begins, and its stops.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "c40/chip/state.hpp"
#include "io/stop.hpp"
#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {

std::string_view name(Stop::Reason reason) {
  switch (reason) {
    case Stop::Reason::start: return "start";
    case Stop::Reason::breakpoint: return "breakpoint";
    case Stop::Reason::watchpoint: return "watchpoint";
    case Stop::Reason::event: return "event";
    case Stop::Reason::step: return "step";
    case Stop::Reason::moved: return "moved";
    case Stop::Reason::paused: return "paused";
    case Stop::Reason::over: return "over";
    case Stop::Reason::fault: return "fault";
    case Stop::Reason::software_interrupt: return "software_interrupt";
  }
  return "?";
}

std::string waits_before_swi(Address pc) {
  return fmt::format("SWI at {:08X}h calls the debugger; the chip stands before it, and continues where its PC is set",
                     pc);
}

std::optional<std::string> Debuggee::holds_pc(std::size_t n) {
  if (!chip(n).halted()) return std::nullopt;
  return chip(n).state().faulted ? "a fault has halted the chip, and only a reset ends that; go back before it"
                                 : "the chip is held in reset";
}

Debugger::Debugger(Debuggee& debuggee, HistoryLimits limits)
    : debuggee_(debuggee), history_(std::make_unique<History>(limits)) {
  for (std::size_t n = 0; n < debuggee.chips(); ++n) programs_.emplace_back(debuggee.program(n));
  recorder_ = std::make_unique<HitRecorder>(debuggee_, programs_);
  stopped(Stop::Reason::start, 0, "the beginning of the run");
  if (now() != Time{0}) stop_.text = fmt::format("at {}", seconds(now()));
  const auto begin = std::chrono::steady_clock::now();
  const std::string state = debuggee_.save();
  history_->add({now(), 0}, state, std::chrono::steady_clock::now() - begin);
}

Debugger::~Debugger() = default;

bool Debugger::asked_to_stop() { return interrupted_ || io::stop_asked(); }

const Stop& Debugger::stopped(Stop::Reason reason, std::optional<std::size_t> chip, std::string text,
                              std::vector<Hit> hits) {
  stop_ = {reason, now(), chip ? chip : stop_.chip, std::move(hits), std::move(text)};
  return stop_;
}

const Stop& Debugger::paused() {
  return stopped(Stop::Reason::paused, {}, fmt::format("paused at {}", seconds(now())));
}

/// Nothing more happens.
const Stop& Debugger::ended() {
  const std::optional<std::size_t> chip = debuggee_.calls();
  return stopped(chip ? Stop::Reason::software_interrupt : Stop::Reason::over, chip, *debuggee_.over());
}

void Debugger::require_chip(std::size_t chip) const {
  if (chip >= programs_.size())
    throw DebugError(fmt::format("there is no chip {}; 0 to {} are there", chip, programs_.size() - 1));
}

std::string at_stack(Address sp) { return fmt::format("sp == {}", sp); }
std::string seconds(Time time) { return fmt::format("{:.12g} s", static_cast<double>(time.count()) * 1e-12); }

}  // namespace machine::debug
