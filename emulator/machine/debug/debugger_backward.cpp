// Backward: to the last hit, steps back, and who wrote a word.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "isa/types.hpp"
#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/hit_recorder.hpp"

namespace machine::debug {
namespace {

constexpr Time recent = std::chrono::microseconds{200};
constexpr int window_growth = 20;
constexpr std::size_t most_hits_kept = 100'000;
constexpr Address delayed_slots = 3;  // behind a delayed branch

/// Behind the last one that has begun before an instant.
template <class Instructions>
auto begun_before(const Instructions& past, Time time) {
  return std::ranges::lower_bound(past, time, {}, [](const auto& i) { return i.begins; });
}

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
  std::vector<Hit> hits;
  try {
    hits = last_hits(after, from);
  } catch (const DebugError&) {
    recorder_->close();
    paused();
    throw;
  }
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

/// Other stop conditions for a while, and no stop at SWI.
class Debugger::Only {
 public:
  Only(Debugger& debugger, Trigger trigger)
      : debugger_(debugger), kept_(std::exchange(debugger.triggers_, {{temporary, std::move(trigger)}})) {
    debugger_.recorder_->hears_calls = false;
  }
  Only(const Only&) = delete;
  Only& operator=(const Only&) = delete;
  ~Only() {
    debugger_.triggers_ = std::move(kept_);
    debugger_.recorder_->hears_calls = true;
  }

 private:
  Debugger& debugger_;
  std::map<unsigned, Trigger> kept_;
};

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
  for (Instruction& instruction : recorder_->instructions) {
    std::swap(instruction.sp, sp);  // the recorder has SP after each
    if (instruction.begins >= past.from && instruction.begins < to) past.instructions.push_back(instruction);
  }
  recorder_->keeps_instructions = false;
  recorder_->close();
  recorder_->arm({}, std::nullopt);
  past_ = std::move(past);
}

/// What the chip did before an instant, from about `window` before it on.
const std::vector<Debugger::Instruction>& Debugger::past_of(std::size_t chip, Time time, Time window) {
  const Time from = std::max(beginning(), time - window);
  if (!past_ || past_->chip != chip || past_->from > from || past_->to < time) {
    const bool known = past_ && past_->chip == chip && past_->from < time && past_->to >= time;
    if (!known || window > recent) look_at_past(chip, from, time);
  }
  return past_->instructions;
}

/// The beginning of the last instruction before an instant for which `fits` is true.
template <class Fits>
std::optional<Time> Debugger::instruction_before(std::size_t chip, Time time, Fits fits) {
  for (Time window = recent;; window *= window_growth) {
    const auto& past = past_of(chip, time, window);
    for (auto at = begun_before(past, time); at != past.begin();)
      if (--at; !at->interrupt && fits(*at)) return at->begins;
    if (time - window <= beginning() || asked_to_stop()) return std::nullopt;
  }
}

/// Where the step began that came here. The entry of an interrupt is a step, too: it begins where the chip's last
/// instruction has ended.
std::optional<Debugger::Place> Debugger::before(const Place& place) {
  for (Time window = recent;; window *= window_growth) {
    const auto& past = past_of(place.chip, place.time, window);
    if (auto at = begun_before(past, place.time); at != past.begin()) {
      const Instruction& last = *--at;
      if (!last.interrupt) return Place{place.chip, last.begins, last.pc, last.sp};
      if (at != past.begin()) return Place{place.chip, std::prev(at)->ends, last.pc, last.sp};
    }
    if (place.time - window <= beginning() || asked_to_stop()) return std::nullopt;
  }
}

/// The place from which a step over calls comes here: the call that returns here, if it does so for the first time;
/// else the instruction before. The routine of an interrupt that returns here is passed over, too.
std::optional<Debugger::Place> Debugger::before_over(const Place& place) {
  const std::optional<Place> last = before(place);
  if (!last) return std::nullopt;
  const auto operation_at = [&](Address pc, auto is) {
    const auto word = debuggee_.peek(place.chip, pc);
    return word && is(pc, *word);
  };
  const auto call = [&](Address pc, Word word) { return returns_from_call(pc, word) == place.pc; };
  const auto reti = [](Address, Word word) { return returns_from_interrupt(word); };
  std::vector<CodePlace> places{{place.chip, place.pc}};
  for (const Address pc : {place.pc - 1, place.pc - (delayed_slots + 1)})
    if (operation_at(pc, call)) places.push_back({place.chip, pc});
  const bool interrupted = operation_at(last->pc, reti) || operation_at(last->pc - delayed_slots, reti);
  if (places.size() == 1 && !interrupted) return last;
  const auto is_call = [&](Address pc) {
    return pc != place.pc && std::ranges::count(places, pc, &CodePlace::address);
  };
  for (Time window = recent;; window *= window_growth) {
    const auto& past = past_of(place.chip, place.time, window);
    for (auto at = begun_before(past, place.time); at != past.begin();) {
      if (--at; at->sp != place.sp) continue;
      const Place here{place.chip, at->begins, at->pc, at->sp};
      if (at->interrupt && at->pc == place.pc) return before_over(here);
      if (!at->interrupt && is_call(at->pc)) return here;
      if (!at->interrupt && at->pc == place.pc) return last;
    }
    if (place.time - window <= beginning() || asked_to_stop()) return last;
    if (interrupted || window == recent) continue;
    // Long ago: found by its address, which is quicker than to look at each instruction.
    const Only only(*this, {.kind = Trigger::Kind::code, .places = places, .condition = at_stack(place.sp)});
    const std::vector<Hit> hits = last_hits(beginning(), past_->from);
    if (hits.empty() || !is_call(hits.front().pc)) return last;
    return Place{place.chip, hits.front().time, hits.front().pc, place.sp};
  }
}

/// The first instruction of the source line before; its instructions were executed without another line in between.
/// Code without lines belongs to the line from which a step comes to it, and is stepped by instructions from inside.
std::optional<Time> Debugger::line_before(const Place& place, bool over_calls) {
  const auto line_of = [&](Address pc) {
    const auto source = programs_[place.chip].source(pc);
    return source ? std::pair(source->file, source->line) : std::pair(std::string(), 0);
  };
  const auto now_line = line_of(place.pc);
  std::optional<std::pair<std::string, int>> other;
  std::optional<Time> to;
  for (std::optional<Place> at = place; !asked_to_stop();) {
    at = over_calls ? before_over(*at) : before(*at);
    if (!at) break;
    const auto line = line_of(at->pc);
    if (now_line.second == 0) return at->time;
    if (line.second == 0 || (!other && line == now_line)) continue;
    if (other && line != *other) break;
    other = line;
    to = at->time;
  }
  return to;
}

const Stop& Debugger::step_back(std::size_t chip, Step step) {
  require_chip(chip);
  interrupted_ = false;
  const Time from = now();
  const c40::Chip& stepped = debuggee_.chip(chip);
  const Place here{chip, from, stepped.pc(), static_cast<Address>(stepped.register_value(isa::Register::SP))};
  const ProgramView& program = programs_[chip];
  const auto time_of = [](const std::optional<Place>& place) {
    return place ? std::optional(place->time) : std::nullopt;
  };
  std::optional<Time> to;
  switch (step) {
    case Step::instruction: to = time_of(before(here)); break;
    case Step::over: to = time_of(before_over(here)); break;
    case Step::line:
    case Step::next_line: to = line_before(here, step == Step::next_line); break;
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
      const Only only(*this, event_of(chip, step));
      const std::vector<Hit> hits = last_hits(beginning(), from);
      move_to(hits.empty() ? beginning() : hits.front().time);
      if (hits.empty()) return stopped(Stop::Reason::start, {}, "the beginning");
      return stopped(Stop::Reason::step, hits.front().chip, hits.front().text);
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
    for (const Instruction& instruction : past_->instructions)
      if (instruction.begins < from && !instruction.interrupt) costs[instruction.pc] = instruction.causes;
  return costs;
}

std::optional<Writer> Debugger::last_write(std::size_t chip, Address address) {
  require_chip(chip);
  interrupted_ = false;
  const Time from = now();
  Trigger written{.kind = Trigger::Kind::word, .chip = chip, .address = address, .on = Trigger::On::write};
  check(written);
  // A write at this very instant counts: it has happened.
  std::vector<Hit> hits;
  {
    const Only only(*this, written);
    hits = last_hits(beginning(), from + Time{1});
  }
  const bool gave_up = asked_to_stop();
  interrupted_ = false;
  move_to(from);
  if (gave_up) throw DebugError("interrupted: the last write was not found yet");
  if (hits.empty()) return std::nullopt;
  const Hit& hit = hits.front();
  return Writer{hit.time, hit.chip, hit.pc, hit.before, hit.value, hit.text};
}

}  // namespace machine::debug
