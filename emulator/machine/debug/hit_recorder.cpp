#include "machine/debug/hit_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isa/types.hpp"
#include "machine/debug/debugger_shared.hpp"

namespace machine::debug {
namespace {

bool is_meant(Trigger::On on, bool write, bool changed) {
  switch (on) {
    case Trigger::On::write: return write;
    case Trigger::On::read: return !write;
    case Trigger::On::access: return true;
    case Trigger::On::change: return write && changed;
  }
  return false;
}

}  // namespace

/// The part for one chip.
class Debugger::HitRecorder::ChipEar final : public c40::Probe, public c40::TraceSink {
 public:
  ChipEar(HitRecorder& ear, std::size_t chip) : recorder_(ear), chip_(chip) {
    recorder_.debuggee_.chip(chip_).set_probe(this, {});
  }
  ~ChipEar() override {
    plan({}, false, false);
    recorder_.debuggee_.chip(chip_).set_probe(nullptr, {});
  }
  ChipEar(const ChipEar&) = delete;
  ChipEar& operator=(const ChipEar&) = delete;

  void plan(c40::ProbePlan plan, bool each_instruction, bool rules) {
    c40::Chip& chip = recorder_.debuggee_.chip(chip_);
    if (plan.code != plan_.code || plan.data != plan_.data) {
      chip.set_probe(this, plan);
      plan_ = std::move(plan);
    }
    if (each_instruction != traces_) recorder_.debuggee_.set_trace(chip_, each_instruction ? this : nullptr);
    traces_ = each_instruction;
    if (!rules)
      rules_.reset();
    else if (!rules_)
      look_for_breaches();
  }
  /// The chip is at another place than before.
  void moved() {
    if (rules_) look_for_breaches();
  }
  /// The chip's registers may have been changed.
  void look_again() {
    if (rules_) rules_->look();
  }

  void reaches(Address pc, c40::Cycles cycle) override { recorder_.reached(chip_, pc, time(cycle)); }
  void accessed(const c40::ProbedAccess& access) override { recorder_.accessed(chip_, access, time(access.cycle)); }
  void called(Address pc, c40::Cycles cycle) override { recorder_.came_to_swi(chip_, pc, time(cycle)); }
  void instruction(const c40::TraceRecord& record) override {
    ends_ = record.cycle + record.cycles;
    if (rules_) rules_->instruction(record);
    recorder_.executed(chip_, record);
  }
  void interrupt(const c40::InterruptRecord& record) override {
    if (rules_) rules_->interrupt(record);
    recorder_.interrupted(chip_, time(record.cycle), time(recorder_.debuggee_.chip(chip_).cycle()));
  }

 private:
  Time time(c40::Cycles cycle) const { return recorder_.debuggee_.time_of(chip_, cycle); }
  void look_for_breaches() {
    rules_.emplace(recorder_.debuggee_.chip(chip_));
    rules_->on_breach = [this](const c40::Diagnostic& breach) { recorder_.broke_rule(chip_, breach, ends_); };
  }
  HitRecorder& recorder_;
  std::size_t chip_;
  c40::ProbePlan plan_;
  bool traces_ = false;
  std::optional<c40::SelfCheck> rules_;
  c40::Cycles ends_ = 0;  ///< end of the present instruction
};

Debugger::HitRecorder::HitRecorder(Debuggee& debuggee, const std::vector<ProgramView>& programs)
    : debuggee_(debuggee), programs_(programs) {
  for (std::size_t n = 0; n < debuggee.chips(); ++n) chips_.push_back(std::make_unique<ChipEar>(*this, n));
}

Debugger::HitRecorder::~HitRecorder() {
  debuggee_.listen(nullptr, {});
  debuggee_.watch_shared(nullptr, {});
}

bool Debugger::HitRecorder::shared(const Trigger& trigger) const {
  return debuggee_.shared_word(trigger.chip.value_or(0), trigger.address).has_value();
}

void Debugger::HitRecorder::arm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each) {
  armed_.clear(), conditions_.clear(), values_.clear(), were_.clear();
  for (const auto& [number, trigger] : triggers)
    if (trigger.enabled) armed_.emplace(number, trigger);
  each_ = each;
  std::vector<c40::AddressRange> shared_words;
  std::set<std::string> kinds;
  for (const auto& [number, trigger] : armed_) {
    if (trigger.kind == Trigger::Kind::event && !trigger.of_rules()) kinds.insert(trigger.name);
    if (trigger.kind == Trigger::Kind::word && shared(trigger))
      shared_words.push_back({*debuggee_.shared_word(trigger.chip.value_or(0), trigger.address), trigger.words});
    if (trigger.kind == Trigger::Kind::value)
      values_.emplace(number, Expression(trigger.name, debuggee_, programs_, trigger.chip.value_or(0)));
  }
  for (std::size_t n = 0; n < chips_.size(); ++n) {
    c40::ProbePlan plan;
    bool steps = each_ == n, rules = false;
    for (const auto& [number, trigger] : armed_) {
      if (trigger.chip && *trigger.chip != n) continue;
      for (const CodePlace& place : trigger.places)
        if (place.chip.value_or(n) == n) plan.code.insert(place.address);
      if (trigger.kind == Trigger::Kind::word && !shared(trigger))
        plan.data.push_back({trigger.address, trigger.words});
      steps = steps || trigger.by_instructions();
      rules = rules || trigger.of_rules();
    }
    chips_[n]->plan(std::move(plan), steps, rules);
  }
  debuggee_.watch_shared(shared_words.empty() ? nullptr : this, shared_words);
  debuggee_.listen(kinds.empty() ? nullptr : this, kinds);
  learns_late_ = !kinds.empty() || !shared_words.empty();
}

void Debugger::HitRecorder::rearm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each) {
  const std::map<unsigned, bool> were = were_;
  arm(triggers, each);
  were_ = were;
  for (auto& chip : chips_) chip->look_again();
  open_ = true;
  stepped.reset();
}

void Debugger::HitRecorder::listen(Time after) {
  after_ = after;
  open_ = true;
  hits.clear(), instructions.clear(), stepped.reset();
  for (auto& chip : chips_) chip->moved();
  for (auto& [number, expression] : values_) were_[number] = is_true(expression, number, "when");
}

bool Debugger::HitRecorder::looks_at_values() const { return !values_.empty(); }

void Debugger::HitRecorder::look_at_values(Time now) {
  for (auto& [number, expression] : values_) {
    const bool is = is_true(expression, number, "when");
    if (is && !were_[number])
      add(number, armed_.at(number), {.time = now, .text = fmt::format("{} is true", armed_.at(number).name)});
    were_[number] = is;
  }
}

std::string Debugger::HitRecorder::place(std::size_t chip, Address pc) const {
  return fmt::format("{} ({:08X}h)", programs_[chip].name(pc), pc);
}

Expression& Debugger::HitRecorder::condition_of(unsigned number, const Trigger& trigger, std::size_t chip) {
  const std::pair key{number, chip};
  const auto found = conditions_.find(key);
  if (found != conditions_.end()) return found->second;
  return conditions_.emplace(key, Expression(trigger.condition, debuggee_, programs_, chip)).first->second;
}

bool Debugger::HitRecorder::holds(const Hit& hit) {
  const auto found = armed_.find(hit.trigger);
  if (found == armed_.end() || found->second.condition.empty()) return true;
  return is_true(condition_of(hit.trigger, found->second, hit.chip.value_or(0)), hit.trigger, "if");
}

/// \throws DebugError with the words of the condition, if it has no value
bool Debugger::HitRecorder::is_true(const Expression& expression, unsigned number, std::string_view word) const {
  try {
    return expression.value().truth();
  } catch (const DebugError& error) {
    const Trigger& trigger = armed_.at(number);
    throw DebugError(fmt::format("stop condition {}, \"{} {}\": {}", number, word,
                                 word == "if" ? trigger.condition : trigger.name, error.what()));
  }
}

void Debugger::HitRecorder::add(unsigned number, const Trigger& trigger, Hit hit) {
  if (!open_ || hit.time <= after_) return;
  hit.trigger = number;
  hit.open = trigger.log.find('{') != std::string::npos;
  if (!trigger.condition.empty()) {
    // A condition on this chip alone can be checked at once; for others all chips have to be at this instant.
    std::optional<Value> met;
    try {
      if (hit.chip) met = condition_of(number, trigger, *hit.chip).own_value();
    } catch (const DebugError&) {
      // Checked when the machine is at this instant.
    }
    if (met && !met->truth()) return;
    hit.open = hit.open || !met;
  }
  hits.push_back(std::move(hit));
}

void Debugger::HitRecorder::reached(std::size_t chip, Address pc, Time time) {
  if (!open_) return;
  for (const auto& [number, trigger] : armed_)
    if (trigger.stops(chip, pc))
      add(number, trigger,
          {.time = time,
           .chip = chip,
           .text = fmt::format("{} before {}", debuggee_.chip_name(chip), place(chip, pc)),
           .pc = pc});
}

void Debugger::HitRecorder::accessed(std::size_t chip, const c40::ProbedAccess& access, Time time) {
  if (!open_) return;
  for (const auto& [number, trigger] : armed_) {
    if (trigger.kind != Trigger::Kind::word || trigger.chip.value_or(chip) != chip ||
        access.address - trigger.address >= trigger.words || shared(trigger))
      continue;
    if (!is_meant(trigger.on, access.write, access.before != access.value)) continue;
    const std::string who = access.channel >= 0
                                ? fmt::format("DMA channel {} of {}", access.channel, debuggee_.chip_name(chip))
                            : access.interrupt ? fmt::format("{}, taking an interrupt,", debuggee_.chip_name(chip))
                                               : debuggee_.chip_name(chip);
    const std::string what = access.write
                                 ? fmt::format("wrote {:08X}h (before: {:08X}h) to", access.value, access.before)
                                 : fmt::format("read {:08X}h from", access.value);
    add(number, trigger,
        {.time = time,
         .chip = chip,
         .text = fmt::format("{} {} {} at {}", who, what, place(chip, access.address), place(chip, access.pc)),
         .pc = access.pc,
         .before = access.before,
         .value = access.value});
  }
}

void Debugger::HitRecorder::shared_access(const SharedAccess& access) {
  if (!open_) return;
  for (const auto& [number, trigger] : armed_) {
    if (trigger.kind != Trigger::Kind::word) continue;
    const auto word = debuggee_.shared_word(trigger.chip.value_or(0), trigger.address);
    if (!word || access.word - *word >= trigger.words ||
        !is_meant(trigger.on, access.write, access.before != access.value))
      continue;
    const std::string what = access.write
                                 ? fmt::format("wrote {:08X}h (before: {:08X}h) to", access.value, access.before)
                                 : fmt::format("read {:08X}h from", access.value);
    const Address address = trigger.address + (access.word - *word);
    add(number, trigger,
        {.time = access.time,
         .chip = access.chip,
         .text = fmt::format("{} {} {}", access.who, what, place(trigger.chip.value_or(0), address)),
         .pc = access.chip ? debuggee_.chip(*access.chip).pc() : 0,
         .before = access.before,
         .value = access.value});
  }
}

void Debugger::HitRecorder::executed(std::size_t chip, const c40::TraceRecord& record) {
  if (!open_) return;
  const Time ends = debuggee_.time_of(chip, record.cycle + record.cycles);
  if (step_may_end(chip, ends) && keeps_instructions)
    instructions.push_back({debuggee_.time_of(chip, record.cycle), ends, record.pc, stack_of(chip), record.causes});
  for (const auto& [number, trigger] : armed_) {
    if (trigger.kind != Trigger::Kind::processor_register || trigger.chip.value_or(chip) != chip) continue;
    const auto reg = isa::register_named(trigger.name);
    for (const c40::RegisterChange& change : record.registers)
      if (change.reg == reg)
        add(number, trigger,
            {.time = ends,
             .chip = chip,
             .text = fmt::format("{} set {} to {:X}h at {}", debuggee_.chip_name(chip), trigger.name, change.value,
                                 place(chip, record.pc)),
             .pc = record.pc,
             .value = static_cast<Word>(change.value)});
  }
}

/// Whether each step of the chip counts; one that ends after the beginning of the search ends it.
bool Debugger::HitRecorder::step_may_end(std::size_t chip, Time ends) {
  if (each_ != chip) return false;
  if (!stepped && ends > after_) stepped = ends;
  return true;
}

Address Debugger::HitRecorder::stack_of(std::size_t chip) const {
  return static_cast<Address>(debuggee_.chip(chip).register_value(isa::Register::SP));
}

void Debugger::HitRecorder::interrupted(std::size_t chip, Time begins, Time ends) {
  if (!open_ || !step_may_end(chip, ends) || !keeps_instructions) return;
  const Address sp = stack_of(chip), returns_to = debuggee_.chip(chip).peek(sp);
  instructions.push_back({.begins = begins, .ends = ends, .pc = returns_to, .sp = sp, .interrupt = true});
}

// SWI is not executed. So a step of its chip ends there, too, where the chip already was.
void Debugger::HitRecorder::came_to_swi(std::size_t chip, Address pc, Time time) {
  if (!open_ || !hears_calls || time < after_ || (time == after_ && each_ != chip)) return;
  hits.push_back({.trigger = swi_number,
                  .time = time,
                  .chip = chip,
                  .text = fmt::format("{} before SWI, which calls the debugger, at {}", debuggee_.chip_name(chip),
                                      place(chip, pc)),
                  .pc = pc});
}

void Debugger::HitRecorder::broke_rule(std::size_t chip, const c40::Diagnostic& breach, c40::Cycles cycle) {
  const std::string rule(c40::name(breach.rule));
  DebugEvent event{.time = debuggee_.time_of(chip, cycle),
                   .kind = std::string(Trigger::rules),
                   .chip = chip,
                   .fields = {{"rule", rule}},
                   .text = {}};
  event.text = fmt::format("{} broke the rule {} ({} {}) at {}: {}: {}", debuggee_.chip_name(chip), rule,
                           c40::document(breach.rule), breach.section, place(chip, breach.pc), breach.instruction,
                           breach.message);
  happened(event);
}

void Debugger::HitRecorder::happened(const DebugEvent& event) {
  if (!open_) return;
  for (const auto& [number, trigger] : armed_) {
    if (trigger.kind != Trigger::Kind::event ||
        (trigger.name != event.kind && (trigger.name != "any" || event.kind == Trigger::rules)))
      continue;
    if (trigger.chip && trigger.chip != event.chip) continue;
    const bool fits = std::ranges::all_of(trigger.fields, [&](const auto& field) {
      const auto found = event.fields.find(field.first);
      return found != event.fields.end() && found->second == field.second;
    });
    if (fits) add(number, trigger, {.time = event.time, .chip = event.chip, .text = event.text});
  }
}

}  // namespace machine::debug
