// Backward: to the last hit, steps back, and who wrote a word.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "isa/types.hpp"
#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {
namespace {

constexpr Time recent = std::chrono::microseconds{200};
constexpr std::size_t most_hits_kept = 100'000;

}  // namespace

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
    const Time until = end + (recorder_->learns_late() ? debuggee_.delay() : Time{0});
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
    case Step::event: {
      const auto kept = std::exchange(triggers_, {{temporary, event_of(chip, step)}});
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

}  // namespace machine::debug
