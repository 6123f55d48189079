// Forward: to the next hit, and steps.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "isa/types.hpp"
#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/expression.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {

/// Whether a hit stops the machine.
bool Debugger::counts(const Hit& hit) {
  const auto found = triggers_.find(hit.trigger);
  if (found == triggers_.end()) return true;
  Trigger& trigger = found->second;
  if (++trigger.hits <= trigger.ignore) return false;
  if (trigger.log.empty()) return true;
  if (output) output(filled_in(trigger.log, debuggee_, programs_, hit.chip.value_or(0)));
  return false;
}

bool Debugger::holds(const Hit& hit) { return !hit.open || recorder_->holds(hit); }

/// All hits at the earliest instant after now with a hit that counts; none if there is none up to `until`, nothing
/// more happens, or a stop was requested. With hits the machine is then at that instant or later; without, at `until`.
std::vector<Hit> Debugger::search(Time until, const Manner& manner) {
  hear_what_is_under_way(manner);
  const auto chip_at_breakpoint = [this] {
    for (std::size_t n = 0; n < programs_.size(); ++n) {
      const Address pc = debuggee_.chip(n).pc();
      const auto word = debuggee_.peek(n, pc);
      if (word && calls_debugger(*word)) return true;
      for (const auto& [number, trigger] : triggers_)
        if (trigger.enabled && trigger.stops(n, pc)) return true;
    }
    return false;
  };
  constexpr int small_steps = 256;
  // Some events are reported late: those up to `until` are known only behind it.
  const Time late = recorder_->learns_late() ? debuggee_.delay() : Time{0};
  const Time last = now() >= until ? until : until > never - late ? never : until + late;
  Time slice = manner.steps ? std::chrono::microseconds{10} : debuggee_.slice();
  for (int turn = 0;; ++turn) {
    if (asked_to_stop() || debuggee_.over() || now() >= last) {
      recorder_->close();
      if (last > until && now() > until && !asked_to_stop()) move_and_listen(until, manner);
      return {};
    }
    Time target = now() + slice;
    if (manner.steps && turn < small_steps) {
      target = debuggee_.time_of(*manner.steps, debuggee_.chip(*manner.steps).cycle() + 1);
      if (target <= now()) target = now() + std::chrono::microseconds{1};
    } else if (manner.steps) {
      slice = std::min(slice * 2, debuggee_.slice());
    }
    const bool values = recorder_->looks_at_values();
    if (values) target = std::min(target, (now() / debuggee_.value_period() + 1) * debuggee_.value_period());
    run_to(std::min(target, last));
    if (values) recorder_->look_at_values(now());
    while (!recorder_->hits.empty() || recorder_->stepped) {
      const auto first = [this] {
        Time earliest = recorder_->stepped.value_or(never);
        for (const Hit& hit : recorder_->hits) earliest = std::min(earliest, hit.time);
        return earliest;
      };
      Time at = first();
      if (at > until) break;
      // A breakpoint at the end of a step is met when its instruction begins.
      if (recorder_->stepped == at && now() <= at && chip_at_breakpoint()) run_to(at + Time{1}), at = first();
      // Hits of other chips may still come before.
      const Time known = at + late;
      if (now() < known) run_to(known), at = first();
      std::vector<Hit> here;
      std::erase_if(recorder_->hits, [&](const Hit& hit) {
        if (hit.time == at) here.push_back(hit);
        return hit.time == at;
      });
      const bool step_ends = recorder_->stepped == at;
      const bool open = std::ranges::any_of(here, &Hit::open);
      if (open) {
        move_and_listen(at, manner);
        std::erase_if(here, [this](const Hit& hit) { return !holds(hit); });
      }
      std::erase_if(here, [this](const Hit& hit) { return !counts(hit); });
      if (step_ends) here.push_back({.trigger = temporary, .time = at, .chip = manner.steps});
      if (!here.empty()) {
        recorder_->close();
        return here;
      }
    }
  }
}

const Stop& Debugger::report(std::vector<Hit> hits) {
  Stop::Reason reason = Stop::Reason::step;
  std::string text;
  std::optional<std::size_t> chip;
  std::erase_if(hits, [&](const Hit& hit) { return hit.text.empty() && hits.size() > 1; });
  std::ranges::stable_sort(hits, {}, [](const Hit& hit) { return hit.chip.value_or(~std::size_t{0}); });
  for (const Hit& hit : hits) {
    const auto trigger = triggers_.find(hit.trigger);
    if (&hit == &hits.front()) {
      chip = hit.chip;
      if (hit.trigger == swi_number) reason = Stop::Reason::software_interrupt;
      if (hit.trigger != temporary && trigger != triggers_.end()) {
        const Trigger::Kind kind = trigger->second.kind;
        reason = kind == Trigger::Kind::code    ? Stop::Reason::breakpoint
                 : kind == Trigger::Kind::event ? Stop::Reason::event
                                                : Stop::Reason::watchpoint;
        if (kind == Trigger::Kind::event && trigger->second.name == "fault") reason = Stop::Reason::fault;
      }
    }
    if (hit.text.empty()) continue;
    if (hit.trigger == temporary) {
      if (trigger != triggers_.end() && trigger->second.kind == Trigger::Kind::event) text += hit.text;
      continue;
    }
    const std::string number = hit.trigger == swi_number ? "" : fmt::format("{}: ", hit.trigger);
    text += fmt::format("{}{}{}", text.empty() ? "" : "; ", number, hit.text);
  }
  std::erase_if(hits, [](const Hit& hit) { return hit.trigger == temporary || hit.trigger == swi_number; });
  return stopped(reason, chip, std::move(text), std::move(hits));
}

/// The stop condition of a step, which must not outlive it, however the step ends.
class Debugger::Temporary {
 public:
  explicit Temporary(std::map<unsigned, Trigger>& triggers) : triggers_(triggers) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() { triggers_.erase(temporary); }

 private:
  std::map<unsigned, Trigger>& triggers_;
};

const Stop& Debugger::resume(Time until, const Manner& manner) {
  const Temporary step(triggers_);
  interrupted_ = false;
  debuggee_.look_again();
  if (debuggee_.over()) return ended();
  std::vector<Hit> hits;
  try {
    hits = search(until, manner);
  } catch (const DebugError&) {
    recorder_->close();
    paused();
    throw;
  }
  if (!hits.empty()) {
    const Time at = hits.front().time;
    move_and_listen(at, manner);
    if (now() == at) return report(std::move(hits));
  }
  if (asked_to_stop()) return paused();
  if (debuggee_.over()) return ended();
  return stopped(Stop::Reason::moved, {}, fmt::format("at {}", seconds(now())));
}

const Stop& Debugger::go(Time until) { return resume(until, {}); }

const Stop& Debugger::step(std::size_t chip, Step step) {
  require_chip(chip);
  switch (step) {
    case Step::instruction: return resume(never, {.steps = chip});
    case Step::over: return step_over(chip);
    case Step::line: return step_lines(chip, false);
    case Step::next_line: return step_lines(chip, true);
    case Step::out: {
      const std::vector<Frame> frames = call_stack(debuggee_, chip, programs_[chip]);
      if (frames.size() < 2)
        throw DebugError(fmt::format("{}: no caller of {} is found on its stack", debuggee_.chip_name(chip),
                                     programs_[chip].name(frames[0].pc)));
      const Frame& caller = frames[1];
      return run_to_code(chip, caller.returns_to, caller.at ? at_stack(*caller.at - 1) : "");
    }
    case Step::claim:
    case Step::refresh:
    case Step::event: break;
  }
  triggers_.insert_or_assign(temporary, event_of(chip, step));
  return resume(never, {});
}

/// The event that ends a step other than an instruction's.
Trigger Debugger::event_of(std::size_t chip, Step step) {
  Trigger trigger{.kind = Trigger::Kind::event,
                  .name = step == Step::claim     ? "claim"
                          : step == Step::refresh ? "refresh"
                                                  : "any"};
  if (step == Step::claim) trigger.chip = chip;
  check(trigger);
  return trigger;
}

const Stop& Debugger::run_to_code(std::size_t chip, Address address, std::string condition) {
  triggers_.insert_or_assign(temporary, Trigger{.kind = Trigger::Kind::code,
                                                .chip = chip,
                                                .places = {{std::nullopt, address}},
                                                .condition = std::move(condition)});
  return resume(never, {});
}

const Stop& Debugger::step_over(std::size_t chip) {
  const Address pc = debuggee_.chip(chip).pc();
  const auto word = debuggee_.peek(chip, pc);
  const auto back = word ? returns_from_call(pc, *word) : std::nullopt;
  if (!back) return resume(never, {.steps = chip});
  return run_to_code(chip, *back,
                     at_stack(static_cast<Address>(debuggee_.chip(chip).register_value(isa::Register::SP))));
}

/// Steps to an instruction of another source line. Code without lines is stepped by instructions.
const Stop& Debugger::step_lines(std::size_t chip, bool over_calls) {
  const auto line_at = [&] {
    const auto place = programs_[chip].source(debuggee_.chip(chip).pc());
    return place ? std::pair(place->file, place->line) : std::pair(std::string(), 0);
  };
  const auto first = line_at();
  for (;;) {
    const Stop& stop = over_calls ? step_over(chip) : resume(never, {.steps = chip});
    if (stop.reason != Stop::Reason::step || stop.chip != chip) return stop;
    const auto line = line_at();
    if (first.second == 0 || (line != first && line.second != 0)) return stop;
  }
}

}  // namespace machine::debug
