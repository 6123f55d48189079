#include "machine/debug/debugger.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ranges>
#include <utility>

#include "c40/float40.hpp"
#include "c40/self_check.hpp"
#include "io/stop.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr Time replay_slice = milliseconds{20};
constexpr Time recent = microseconds{200};
constexpr unsigned temporary = 0;  ///< number of the trigger of a step
constexpr std::size_t most_hits_kept = 100'000;

/// The 40 bits of the nearest number that a register can hold. \throws DebugError for a number that is too large
std::uint64_t float_bits(double value) {
  if (value == 0) return c40::float40::bits(c40::float40::zero());
  int exponent = 0;
  auto mantissa = std::llround(std::ldexp(std::frexp(value, &exponent), 32));
  --exponent;
  if (mantissa == c40::float40::one * 2) mantissa /= 2, ++exponent;
  if (mantissa == -c40::float40::one) mantissa *= 2, --exponent;
  if (!std::isfinite(value) || exponent < -127 || exponent > 127)
    throw DebugError(fmt::format("{:g} is beyond what a register holds", value));
  return c40::float40::bits(c40::float40::pack(exponent, mantissa));
}

/// Without a step's breakpoint, of which no hit can be outstanding.
std::map<unsigned, Trigger> lasting(std::map<unsigned, Trigger> triggers) {
  if (const auto step = triggers.find(temporary); step != triggers.end() && step->second.kind == Trigger::Kind::code)
    triggers.erase(step);
  return triggers;
}

std::string seconds(Time time) { return fmt::format("{:.12g} s", static_cast<double>(time.count()) * 1e-12); }

}  // namespace

std::string_view name(Stop::Reason reason) {
  switch (reason) {
    case Stop::Reason::start: return "start";
    case Stop::Reason::breakpoint: return "breakpoint";
    case Stop::Reason::watchpoint: return "watchpoint";
    case Stop::Reason::happening: return "happening";
    case Stop::Reason::step: return "step";
    case Stop::Reason::moved: return "moved";
    case Stop::Reason::paused: return "paused";
    case Stop::Reason::over: return "over";
    case Stop::Reason::fault: return "fault";
  }
  return "?";
}

/// The manner of a search.
struct Debugger::Manner {
  std::optional<std::size_t> steps;  ///< the search ends at this chip's next instruction
};

Debugger::Debugger(Debuggee& debuggee, HistoryLimits limits)
    : debuggee_(debuggee), history_(std::make_unique<History>(limits)) {
  for (std::size_t n = 0; n < debuggee.chips(); ++n) programs_.emplace_back(debuggee.program(n));
  recorder_ = std::make_unique<HitRecorder>(debuggee_, programs_);
  stopped(Stop::Reason::start, 0, "the beginning of the run");
  if (now() != Time{0}) stop_.text = fmt::format("at {}", seconds(now()));
  const auto begin = Clock::now();
  const std::string state = debuggee_.save();
  history_->add({now(), 0}, state, Clock::now() - begin);
}

Debugger::~Debugger() = default;

bool Debugger::asked_to_stop() { return interrupted_ || io::stop_asked(); }

const Stop& Debugger::stopped(Stop::Reason reason, std::optional<std::size_t> chip, std::string text,
                              std::vector<Hit> hits) {
  stop_ = {reason, now(), chip ? chip : stop_.chip, std::move(hits), std::move(text)};
  return stop_;
}

void Debugger::require_chip(std::size_t chip) const {
  if (chip >= programs_.size())
    throw DebugError(fmt::format("there is no chip {}; 0 to {} are there", chip, programs_.size() - 1));
}

// ---- stop conditions ----

void Debugger::check(const Trigger& trigger) {
  if (trigger.chip) require_chip(*trigger.chip);
  const std::size_t chip = trigger.chip.value_or(0);
  using enum Trigger::Kind;
  if (trigger.kind == code && !debuggee_.peek(chip, trigger.address))
    throw DebugError(fmt::format("{:08X}h: {} has no memory there", trigger.address, debuggee_.chip_name(chip)));
  if (trigger.kind == word && (trigger.words == 0 || trigger.address + (trigger.words - 1) < trigger.address))
    throw DebugError(fmt::format("{:08X}h: 1 word or more, up to the end of memory, can be watched", trigger.address));
  if (trigger.kind == processor_register && !isa::register_named(trigger.name))
    throw DebugError(fmt::format(
        "{} is not a register that can be watched; R0 to R11, AR0 to AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, "
        "IIF, RS, RE, RC are",
        trigger.name));
  if (trigger.kind == value) (void)Expression(trigger.name, debuggee_, programs_, chip).value();
  if (trigger.kind == happening) {
    const auto kinds = happenings();
    if (trigger.name != "any" &&
        std::ranges::none_of(kinds, [&](const auto& row) { return row.first == trigger.name; }))
      throw DebugError(fmt::format("{} is not an event; any, {} are possible", trigger.name,
                                   fmt::join(std::views::keys(kinds), ", ")));
    const std::vector<std::string_view> rules = c40::rule_names();
    if (const auto rule = trigger.fields.find("rule");
        trigger.of_rules() && rule != trigger.fields.end() && std::ranges::find(rules, rule->second) == rules.end())
      throw DebugError(fmt::format("{} is not a rule; {} are possible", rule->second, fmt::join(rules, ", ")));
  }
  if (!trigger.condition.empty()) (void)Expression(trigger.condition, debuggee_, programs_, chip);
}

std::vector<std::pair<std::string, std::string>> Debugger::happenings() const {
  auto all = debuggee_.happenings();
  all.emplace_back(
      std::string(Trigger::rules),
      "an instruction breaks a rule of the manual (rule=NAME: one of them); checked instruction by instruction");
  return all;
}

unsigned Debugger::add(Trigger trigger) {
  check(trigger);
  const unsigned number = next_number_++;
  triggers_.emplace(number, std::move(trigger));
  return number;
}

void Debugger::remove(unsigned number) {
  if (triggers_.erase(number) == 0) throw DebugError(fmt::format("there is no stop condition {}", number));
}

void Debugger::enable(unsigned number, bool on) {
  const auto found = triggers_.find(number);
  if (found == triggers_.end()) throw DebugError(fmt::format("there is no stop condition {}", number));
  found->second.enabled = on;
}

std::vector<std::size_t> Debugger::stepped_chips() const {
  std::vector<std::size_t> chips;
  for (std::size_t n = 0; n < programs_.size(); ++n)
    if (std::ranges::any_of(triggers_, [&](const auto& entry) {
          const Trigger& t = entry.second;
          return t.enabled && t.by_instructions() && t.chip.value_or(n) == n;
        }))
      chips.push_back(n);
  return chips;
}

// ---- to an instant ----

/// Runs there, repeats the changes by hand that lie on the way, and keeps snapshots.
void Debugger::run_to(Time time) {
  const Time from = now();
  const auto make_changes = [&] {
    while (changed_ < changes_.size() && changes_[changed_].time <= now()) changes_[changed_++].make();
  };
  make_changes();
  while (now() < time && !asked_to_stop() && !debuggee_.over()) {
    Time next = std::min(time, now() + replay_slice);
    if (changed_ < changes_.size()) next = std::min(next, changes_[changed_].time);
    debuggee_.run_until(next);
    make_changes();
    if (history_->due(now())) {
      const auto begin = Clock::now();
      const std::string state = debuggee_.save();
      history_->add({now(), changed_}, state, Clock::now() - begin);
    }
    if (progress) progress(now(), from, time);
  }
}

void Debugger::load_before(Time time) {
  const auto place = history_->before(time);
  if (!place) throw std::logic_error("no snapshot lies before an instant of the run");
  debuggee_.load(history_->state_before(time));
  changed_ = place->changes;
}

void Debugger::move_to(Time time) {
  recorder_->close();
  heard_at_.reset();
  if (time < now()) load_before(time);
  run_to(time);
}

/// The same; later hits that have already happened are kept for the next search.
void Debugger::move_and_listen(Time time, const Manner& manner) {
  recorder_->close();
  if (time < now()) {
    load_before(time);
    recorder_->arm(triggers_, manner.steps);
    recorder_->listen(time);
    run_to(time);
  }
  heard_at_ = now();
  heard_for_ = lasting(triggers_);
}

/// To be called before a search: hits after now that have already happened.
void Debugger::hear_what_is_under_way(const Manner& manner) {
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first && a.second.same_as(b.second); };
  if (heard_at_ == now() && std::ranges::equal(heard_for_, lasting(triggers_), same)) {
    recorder_->rearm(triggers_, manner.steps);
    return;
  }
  const bool needed = std::ranges::any_of(
      triggers_, [](const auto& entry) { return entry.second.enabled && entry.second.kind != Trigger::Kind::code; });
  const Time here = now();
  if (needed && here > beginning()) load_before(here - Time{1});
  recorder_->arm(triggers_, manner.steps);
  recorder_->listen(here);
  run_to(here);
  recorder_->stepped.reset();
}

const Stop& Debugger::go_to(Time time) {
  interrupted_ = false;
  time = std::max(time, beginning());
  if (debuggee_.over() && time >= now()) return stopped(Stop::Reason::over, {}, *debuggee_.over());
  // A later instant; but perhaps a snapshot lies between.
  if (const auto place = history_->before(time); place && place->time > now()) recorder_->close(), load_before(time);
  move_to(time);
  if (now() < time) {
    if (const auto why = debuggee_.over()) return stopped(Stop::Reason::over, {}, *why);
    return stopped(Stop::Reason::paused, {}, fmt::format("paused at {}", seconds(now())));
  }
  return stopped(Stop::Reason::moved, {}, fmt::format("at {}", seconds(now())));
}

Time Debugger::beginning() const { return history_->info().first; }
HistoryInfo Debugger::history() const { return history_->info(); }

// ---- forward ----

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

/// All hits at the earliest instant after now with a hit that counts; none if there is none before `until`, nothing
/// more happens, or a stop was requested. The machine is then at that instant or later.
std::vector<Hit> Debugger::search(Time until, const Manner& manner) {
  hear_what_is_under_way(manner);
  constexpr int small_steps = 256;
  Time slice = manner.steps ? microseconds{10} : debuggee_.slice();
  for (int turn = 0;; ++turn) {
    if (asked_to_stop() || debuggee_.over() || now() >= until) {
      recorder_->close();
      return {};
    }
    Time target = now() + slice;
    if (manner.steps && turn < small_steps) {
      target = debuggee_.time_of(*manner.steps, debuggee_.chip(*manner.steps).cycle() + 1);
      if (target <= now()) target = now() + microseconds{1};
    } else if (manner.steps) {
      slice = std::min(slice * 2, debuggee_.slice());
    }
    const bool values = recorder_->looks_at_values();
    if (values) target = std::min(target, (now() / debuggee_.value_period() + 1) * debuggee_.value_period());
    run_to(std::min(target, until));
    if (values) recorder_->look_at_values(now());
    while (!recorder_->hits.empty() || recorder_->stepped) {  // none of them is later than `until`
      const auto first = [this] {
        Time earliest = recorder_->stepped.value_or(never);
        for (const Hit& hit : recorder_->hits) earliest = std::min(earliest, hit.time);
        return earliest;
      };
      Time at = first();
      if (at > until) break;
      // Hits of other chips may still come before; and some events are reported late.
      const Time known = at + (recorder_->hears_late() ? debuggee_.delay() : Time{0});
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
      if (hit.trigger != temporary && trigger != triggers_.end()) {
        const Trigger::Kind kind = trigger->second.kind;
        reason = kind == Trigger::Kind::code        ? Stop::Reason::breakpoint
                 : kind == Trigger::Kind::happening ? Stop::Reason::happening
                                                    : Stop::Reason::watchpoint;
        if (kind == Trigger::Kind::happening && trigger->second.name == "fault") reason = Stop::Reason::fault;
      }
    }
    if (hit.text.empty()) continue;
    if (hit.trigger == temporary) {
      if (trigger != triggers_.end() && trigger->second.kind == Trigger::Kind::happening) text += hit.text;
      continue;
    }
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", hit.trigger, hit.text);
  }
  for (const Hit& hit : hits)
    if (const auto trigger = triggers_.find(hit.trigger); trigger != triggers_.end() && trigger->second.once)
      triggers_.erase(trigger);
  std::erase_if(hits, [](const Hit& hit) { return hit.trigger == temporary; });
  return stopped(reason, chip, std::move(text), std::move(hits));
}

const Stop& Debugger::go_on(Time until, const Manner& manner) {
  interrupted_ = false;
  debuggee_.look_again();
  if (const auto why = debuggee_.over()) return stopped(Stop::Reason::over, {}, *why);
  std::vector<Hit> hits;
  try {
    hits = search(until, manner);
  } catch (const DebugError&) {
    recorder_->close();
    triggers_.erase(temporary);
    stopped(Stop::Reason::paused, {}, fmt::format("paused at {}", seconds(now())));
    throw;
  }
  if (!hits.empty()) {
    const Time at = hits.front().time;
    move_and_listen(at, manner);
    if (now() == at) return report(std::move(hits));
  }
  triggers_.erase(temporary);
  if (asked_to_stop()) return stopped(Stop::Reason::paused, {}, fmt::format("paused at {}", seconds(now())));
  if (const auto why = debuggee_.over()) return stopped(Stop::Reason::over, {}, *why);
  return stopped(Stop::Reason::moved, {}, fmt::format("at {}", seconds(now())));
}

const Stop& Debugger::go(Time until) { return go_on(until, {}); }

const Stop& Debugger::step(std::size_t chip, Step step) {
  require_chip(chip);
  switch (step) {
    case Step::instruction: return go_on(never, {.steps = chip});
    case Step::over: return step_over(chip);
    case Step::line: return step_lines(chip, false);
    case Step::next_line: return step_lines(chip, true);
    case Step::out: {
      const std::vector<Frame> frames = call_stack(debuggee_, chip, programs_[chip]);
      if (frames.size() < 2)
        throw DebugError(fmt::format("{}: no caller of {} is found on its stack", debuggee_.chip_name(chip),
                                     programs_[chip].name(frames[0].pc)));
      const Frame& caller = frames[1];
      return run_to_code(chip, caller.returns_to, caller.at ? fmt::format("u(sp) == {}", *caller.at - 1) : "");
    }
    case Step::claim:
    case Step::refresh:
    case Step::happening: break;
  }
  triggers_.insert_or_assign(temporary, happening_of(chip, step));
  return go_on(never, {});
}

/// The event that ends a step other than an instruction's.
Trigger Debugger::happening_of(std::size_t chip, Step step) {
  Trigger trigger{.kind = Trigger::Kind::happening,
                  .name = step == Step::claim     ? "claim"
                          : step == Step::refresh ? "refresh"
                                                  : "any",
                  .once = true};
  if (step == Step::claim) trigger.chip = chip;
  check(trigger);
  return trigger;
}

const Stop& Debugger::run_to_code(std::size_t chip, Address address, std::string condition) {
  triggers_.insert_or_assign(temporary, Trigger{.kind = Trigger::Kind::code,
                                                .chip = chip,
                                                .address = address,
                                                .condition = std::move(condition),
                                                .once = true});
  return go_on(never, {});
}

const Stop& Debugger::step_over(std::size_t chip) {
  const Address pc = debuggee_.chip(chip).pc();
  const auto word = debuggee_.peek(chip, pc);
  const auto back = word ? returns_from_call(pc, *word) : std::nullopt;
  if (!back) return go_on(never, {.steps = chip});
  return run_to_code(chip, *back, fmt::format("sp == {}", debuggee_.chip(chip).register_value(isa::Register::SP)));
}

/// Steps to an instruction of another source line. Code without lines is stepped by instructions.
const Stop& Debugger::step_lines(std::size_t chip, bool over_calls) {
  const auto line_at = [&] {
    const auto place = programs_[chip].source(debuggee_.chip(chip).pc());
    return place ? std::pair(place->file, place->line) : std::pair(std::string(), 0);
  };
  const auto first = line_at();
  for (;;) {
    const Stop& stop = over_calls ? step_over(chip) : go_on(never, {.steps = chip});
    if (stop.reason != Stop::Reason::step || stop.chip != chip) return stop;
    const auto line = line_at();
    if (first.second == 0 || (line != first && line.second != 0)) return stop;
  }
}

// ---- backward ----

/// The last hits after `after` and before `before`, all at one instant.
std::vector<Hit> Debugger::last_hits(Time after, Time before) {
  for (Time end = before; end > after;) {
    if (asked_to_stop()) return {};
    recorder_->close();
    load_before(end - Time{1});
    if (now() < after) run_to(after);
    const Time begin = now();
    recorder_->arm(triggers_, std::nullopt);
    recorder_->listen(begin - Time{1});
    const Time until = end + (recorder_->hears_late() ? debuggee_.delay() : Time{0});
    while (now() < until && !asked_to_stop() && !debuggee_.over()) {
      Time target = std::min(until, now() + debuggee_.slice());
      if (recorder_->looks_at_values())
        target = std::min(target, (now() / debuggee_.value_period() + 1) * debuggee_.value_period());
      run_to(target);
      recorder_->look_at_values(now());
      std::erase_if(recorder_->hits, [&](const Hit& hit) { return hit.time >= before; });
      if (recorder_->hits.size() > most_hits_kept)
        recorder_->hits.erase(recorder_->hits.begin(), recorder_->hits.end() - most_hits_kept / 2);
      if (progress) progress(begin, before, after);
    }
    std::vector<Hit> all = std::move(recorder_->hits);
    std::ranges::stable_sort(all, {}, &Hit::time);
    recorder_->close();
    while (!all.empty() && !asked_to_stop()) {
      const Time at = all.back().time;
      std::vector<Hit> here;
      while (!all.empty() && all.back().time == at) here.push_back(all.back()), all.pop_back();
      if (std::ranges::any_of(here, &Hit::open)) move_to(at);
      std::erase_if(here, [&](const Hit& hit) {
        const auto found = triggers_.find(hit.trigger);
        return !holds(hit) || (found != triggers_.end() && !found->second.log.empty());
      });
      if (!here.empty()) return here;
    }
    end = begin;
  }
  return {};
}

const Stop& Debugger::go_back(Time until) {
  interrupted_ = false;
  const Time from = now(), after = std::max(until, beginning());
  if (from <= after) return stopped(Stop::Reason::start, {}, "the beginning");
  std::vector<Hit> hits = last_hits(after, from);
  if (asked_to_stop()) {
    interrupted_ = false;
    move_to(from);
    return stopped(Stop::Reason::paused, {}, fmt::format("paused; still at {}", seconds(now())));
  }
  if (hits.empty()) {
    move_to(after);
    return stopped(Stop::Reason::start, {}, "the beginning: no stop condition was met before");
  }
  move_to(hits.front().time);
  return report(std::move(hits));
}

/// Records the instructions that a chip begins from about `from` to `to`.
void Debugger::look_at_past(std::size_t chip, Time from, Time to) {
  recorder_->close();
  load_before(from);
  run_to(from);
  if (const auto place = history_->before(from); place && place->time < from)
    history_->add_near({now(), changed_}, debuggee_.save());
  recorder_->arm({}, chip);
  recorder_->keeps_instructions = true;
  recorder_->listen(now());
  Past past{.chip = chip, .from = now(), .to = to, .instructions = {}};
  auto sp = static_cast<Address>(debuggee_.chip(chip).register_value(isa::Register::SP));
  while (now() < to && !asked_to_stop() && !debuggee_.over()) run_to(std::min(to, now() + debuggee_.slice()));
  for (const HitRecorder::Instruction& instruction : recorder_->instructions) {
    if (instruction.begins >= past.from && instruction.begins < to)
      past.instructions.push_back({instruction.begins, instruction.pc, sp, instruction.causes});
    sp = instruction.sp;
  }
  recorder_->keeps_instructions = false;
  recorder_->close();
  recorder_->arm({}, std::nullopt);
  past_ = std::move(past);
}

/// The beginning of the last instruction before an instant for which `fits` is true.
template <class Fits>
std::optional<Time> Debugger::instruction_before(std::size_t chip, Time time, Fits fits) {
  for (Time window = recent;; window *= 20) {
    const Time from = std::max(beginning(), time - window);
    if (!past_ || past_->chip != chip || past_->from > from || past_->to < time) {
      const bool known = past_ && past_->chip == chip && past_->from < time && past_->to >= time;
      if (!known || window > recent) look_at_past(chip, from, time);
    }
    for (auto at = past_->instructions.rbegin(); at != past_->instructions.rend(); ++at)
      if (at->begins < time && fits(*at)) return at->begins;
    if (from == beginning() || asked_to_stop()) return std::nullopt;
  }
}

const Stop& Debugger::step_back(std::size_t chip, Step step) {
  require_chip(chip);
  interrupted_ = false;
  const Time from = now();
  const auto sp = static_cast<Address>(debuggee_.chip(chip).register_value(isa::Register::SP));
  const ProgramView& program = programs_[chip];
  const auto line_of = [&](Address pc) {
    const auto place = program.source(pc);
    return place ? std::pair(place->file, place->line) : std::pair(std::string(), 0);
  };
  const auto above = [&](Address word) { return static_cast<std::int32_t>(word - sp) <= 0; };
  std::optional<Time> to;
  switch (step) {
    case Step::instruction: to = instruction_before(chip, from, [](const auto&) { return true; }); break;
    case Step::over: to = instruction_before(chip, from, [&](const auto& i) { return above(i.sp); }); break;
    case Step::line:
    case Step::next_line: {
      // To the first instruction of the line before; the line's instructions were executed without another line in
      // between.
      const bool over_calls = step == Step::next_line;
      const auto now_line = line_of(debuggee_.chip(chip).pc());
      std::optional<std::pair<std::string, int>> other;
      (void)instruction_before(chip, from, [&](const auto& i) {
        if (over_calls && !above(i.sp)) return false;
        const auto line = line_of(i.pc);
        if (!other && line != now_line) other = line;
        if (other && line != *other) return true;
        if (other) to = i.begins;
        return false;
      });
      break;
    }
    case Step::out: {
      const std::vector<Frame> frames = call_stack(debuggee_, chip, program);
      if (frames.size() < 2)
        throw DebugError(fmt::format("{}: no caller of {} is found on its stack", debuggee_.chip_name(chip),
                                     program.name(frames[0].pc)));
      to = instruction_before(chip, from, [&](const auto& i) {
        return i.pc == frames[1].pc && (!frames[1].at || i.sp == *frames[1].at - 1);
      });
      break;
    }
    case Step::claim:
    case Step::refresh:
    case Step::happening: {
      const auto kept = std::exchange(triggers_, {{temporary, happening_of(chip, step)}});
      std::vector<Hit> hits = last_hits(beginning(), from);
      const std::string text = hits.empty() ? "" : hits.front().text;
      const auto who = hits.empty() ? std::nullopt : hits.front().chip;
      triggers_ = kept;
      move_to(hits.empty() ? beginning() : hits.front().time);
      return hits.empty() ? stopped(Stop::Reason::start, {}, "the beginning") : stopped(Stop::Reason::step, who, text);
    }
  }
  if (asked_to_stop()) {
    interrupted_ = false;
    move_to(from);
    return stopped(Stop::Reason::paused, chip, fmt::format("paused; still at {}", seconds(now())));
  }
  move_to(to.value_or(beginning()));
  if (!to) return stopped(Stop::Reason::start, chip, "the beginning");
  return stopped(Stop::Reason::step, chip, "");
}

std::map<Address, c40::Causes> Debugger::recent_costs(std::size_t chip) {
  require_chip(chip);
  interrupted_ = false;
  const Time from = now(), begin = std::max(beginning(), from - recent);
  if (from > begin && (!past_ || past_->chip != chip || past_->from > begin || past_->to < from)) {
    look_at_past(chip, begin, from);
    move_to(from);
  }
  std::map<Address, c40::Causes> costs;
  if (past_ && past_->chip == chip)
    for (const Past::Instruction& instruction : past_->instructions)
      if (instruction.begins < from) costs[instruction.pc] = instruction.causes;
  return costs;
}

std::optional<Writer> Debugger::last_write(std::size_t chip, Address address) {
  require_chip(chip);
  interrupted_ = false;
  const Time from = now();
  Trigger written{.kind = Trigger::Kind::word, .chip = chip, .address = address, .on = Trigger::On::write};
  check(written);
  // A write at this very instant counts: it has happened.
  const auto kept = std::exchange(triggers_, {{temporary, written}});
  std::vector<Hit> hits;
  try {
    hits = last_hits(beginning(), from + Time{1});
  } catch (...) {
    triggers_ = kept;
    throw;
  }
  triggers_ = kept;
  const bool gave_up = asked_to_stop();
  interrupted_ = false;
  move_to(from);
  if (gave_up) throw DebugError("interrupted: the last write was not found yet");
  if (hits.empty()) return std::nullopt;
  const Hit& hit = hits.front();
  return Writer{hit.time, hit.chip, hit.pc, hit.before, hit.value, hit.text};
}

// ---- changes by hand ----

void Debugger::change(std::function<void()> make, std::string text) {
  make();
  const bool future = history_->info().last > now() || changed_ < changes_.size();
  changes_.resize(changed_);
  changes_.push_back({now(), std::move(make)});
  changed_ = changes_.size();
  history_->forget_after(now());
  past_.reset();
  if (output)
    output(fmt::format(
        "changed by hand at {}: {}{}", seconds(now()), text,
        future ? "; everything later is discarded: a new branch begins here" : "; a new branch begins here"));
}

void Debugger::set_word(std::size_t chip, Address address, Word value) {
  require_chip(chip);
  const auto make = [this, chip, address, value] { debuggee_.poke(chip, address, value); };
  try {
    change(make, fmt::format("{:08X}h of {} = {:08X}h", address, debuggee_.chip_name(chip), value));
  } catch (const std::out_of_range& error) {
    throw DebugError(error.what());
  }
}

void Debugger::set_register(std::size_t chip, std::string_view name, std::string_view expression) {
  require_chip(chip);
  const auto expansion = isa::expansion_named(name);
  const auto reg = isa::register_named(name);
  std::string lower(name);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (!expansion && !reg && lower != "pc")
    throw DebugError(
        fmt::format("{} is not a register; PC, R0 to R11, AR0 to AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS, RE, "
                    "RC, IVTP, TVTP are",
                    name));
  const Value value = Expression(expression, debuggee_, programs_, chip).value();
  if (value.is_float && !(reg && isa::is_extended(*reg)))
    throw DebugError(fmt::format("{} holds integers, and {} is a float", name, expression));
  if (!value.is_float && (value.integer < -0x80000000LL ||
                          value.integer > (reg && isa::is_extended(*reg) ? 0xFFFFFFFFFFLL : 0xFFFFFFFFLL)))
    throw DebugError(fmt::format("{} does not fit into {}", expression, name));
  const auto make = [this, chip, reg, expansion, value] {
    c40::Chip& changed = debuggee_.chip(chip);
    const auto word = static_cast<Word>(value.integer);
    if (expansion) return changed.set_expansion(*expansion, word);
    if (!reg) return changed.set_pc(word);
    if (!isa::is_extended(*reg)) return changed.set_register(*reg, word);
    if (value.is_float) return changed.set_register(*reg, float_bits(value.real));
    // An integer of up to 32 bits keeps the exponent, as an integer load does.
    const bool wide = value.integer > 0xFFFFFFFFLL;
    changed.set_register(
        *reg, wide ? static_cast<std::uint64_t>(value.integer) : (changed.register_value(*reg) & 0xFF00000000u) | word);
  };
  change(make, fmt::format("{} of {} = {}", name, debuggee_.chip_name(chip), value.text()));
}

std::size_t Debugger::changes() const { return changed_; }

}  // namespace machine::debug
