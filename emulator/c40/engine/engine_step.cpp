// The exact engine: executes one instruction at a time, with fetch, accesses and the pipeline model.
#include <fmt/format.h>

#include "c40/engine/engine.hpp"
#include "c40/instructions/addressing.hpp"
#include "c40/instructions/handler_tables.hpp"

namespace c40 {
namespace {

// Packed fetches of a hit in the instruction cache, and of a repetition under RPTS.
constexpr std::uint64_t cached_bits = packed_fetch({}, true, false), unfetched_bits = packed_fetch({}, false, false);

}  // namespace

bool Engine::find_code(Address pc) {
  const Memory::Area* area = memory_.find(pc);
  code_ = {};
  if (area == nullptr) {
    nothing_at("instruction fetch from", pc);
    return false;
  }
  if (area->data == nullptr) {
    fail(Fault::Kind::not_modelled, fmt::format("instruction fetch from {:08X}h ({}) is not modelled", pc, area->name),
         pc);
    return false;
  }
  code_ = CodeArea(memory_, *area, pc);
  return true;
}

isa::ProgramEnd Engine::program_end() const {
  const Core& core = state_.core;
  const Address pc = core.pc;
  if (core.delay_slots != 0 || core.repeat_single != 0) return isa::ProgramEnd::none;
  const Memory::Area* const area = code_.contains(pc) ? code_.area : memory_.find(pc);
  if (area == nullptr || area->data == nullptr) return isa::ProgramEnd::none;
  const Word* const cached = cache_.on() && external(area->resource) ? cache_.find(pc) : nullptr;
  return isa::program_end(cached != nullptr ? *cached : area->data[pc - area->base]);
}

// For the code that code_ describes.
bool Engine::caching() const { return code_.cacheable && cache_.on() && state_.core.repeat_single != 2; }

// Whether a block may contain the instruction at PC. Its word and the cost of its fetch must be known before.
bool Engine::by_blocks() {
  const Address pc = state_.core.pc;
  if (!code_.contains(pc) && !find_code(pc)) {
    fault_.reset();
    return true;  // recording a block fails and finds this again
  }
  if (!caching()) return !code_.met.paged;
  return !cache_.stale() && (!code_.met.paged || cache_.find(pc) != nullptr);
}

bool Engine::bind_slot(DecodedSlot& decoded, Word word, bool set_condition) {
  decoded.forget();
  auto bound = bind(word, set_condition);
  if (const auto* no = std::get_if<Unexecutable>(&bound)) {
    if (no->reserved)
      fail(Fault::Kind::reserved_instruction, fmt::format("{:08X}h is no instruction: {}", word, no->reason));
    else
      fail(Fault::Kind::not_modelled, fmt::format("the instruction {} ({:08X}h) is not modelled", no->reason, word));
    return false;
  }
  decoded.bind_to(std::get<BoundInstruction>(bound), set_condition);
  return true;
}

// Looks up the instruction at PC; does not change the state.
bool Engine::fetch(Step& step) {
  const Core& core = state_.core;
  const Address pc = core.pc;
  if (!code_.contains(pc) && !find_code(pc)) return false;
  step.fetched = core.repeat_single != 2;
  step.word = code_.word(pc);
  step.fetch = code_.met.access;
  if (code_.cacheable && cache_.on()) {
    const Word* const cached = cache_.find(pc);
    if (cached != nullptr) step.word = *cached, step.fetch = {};
    step.from_cache = cached != nullptr && step.fetched;
    step.missed = cached == nullptr && step.fetched;
    step.frozen = cache_.frozen();
    // Before it executes: the instruction may write to its own word.
    if (step.missed && !step.frozen) code_.area->mark_code(pc);
  }
  if (!step.fetched) step.fetch = {};
  if (code_.met.paged && step.fetched && !step.from_cache) {
    pages_ = state_.open_pages;
    step.fetch = memory_.meet(*code_.area, pc, false, pages_).access;
    step.paged = true;
  }
  step.decoded = &decoded_slots_[pc];
  const bool set_condition = (core.modes & st::SETCOND) != 0;
  if (step.decoded->is(step.word, set_condition)) return true;
  step.decoded = &decoded_slots_.slot_for_new(pc);
  return bind_slot(*step.decoded, step.word, set_condition);
}

const Transition& Engine::transition(const Demand& demand, Word word) {
  return pipelines_.transition(pipeline_.id(), demand, packed(demand), word);
}

Engine::Stepped Engine::execute(Step& step) {
  Core& core = state_.core;
  DecodedSlot& decoded = *step.decoded;
  const Address pc = core.pc;
  decoded.ops[0].pc = pc;
  if (decoded.bound.reads_status) core.r[reg::ST] = core.status();
  core.pc = pc + 1;
  for (;;) {
    const Outcome outcome = decoded.ops[0].handler(core, decoded.ops.data());
    if (outcome.exit == Exit::miss) {
      core.pc = pc;  // faults and stops name this instruction
      const Stepped why = resolve(step);
      if (!step.plain) decoded.make_stale();
      if (why != Stepped::done) return why;
      core.pc = pc + 1;
      continue;
    }
    if (outcome.exit == Exit::trap_out) {
      core.pc = pc;
      return Stepped::software_interrupt;
    }
    step.taken = outcome.exit == Exit::taken;
    return Stepped::done;
  }
}

// An annulled slot has no execute stage; the earlier stages of the first two slots do happen (c40-isa.md 8.2). An LDA
// in the first slot is complete after its read stage and is not handled here.
void Engine::annulled(const Step& step) {
  Core& core = state_.core;
  const BoundInstruction& bound = step.decoded->bound;
  const std::uint32_t slot = 4 - core.delay_slots;  // 1 to 3
  core.pc += 1;
  if (slot == 3) return;
  const Op& op = bound.op;
  std::array<Word, 2> updated{};
  const auto slots = static_cast<std::size_t>(bound.address_updates);
  for (std::size_t i = 0; i < slots; ++i) updated[i] = execute::form_indirect(core, op, i).updated;
  for (std::size_t n = 0; n < slots; ++n) {
    const std::size_t i = bound.last_update == 0 ? slots - 1 - n : n;
    if (isa::modn::modifies(op.modn[i])) core.r[op.ar[i]] = updated[i];
  }
  if (bound.row->write_stage == isa::WriteStage::decode) core.r[op.dst] = op.immediate;
}

void Engine::account(const StepTiming& t) {
  state_.cycle += t.total;
  ++state_.instructions;
  for (std::size_t i = 0; i < pipeline_cause_count; ++i) state_.causes[i] += t.causes[i];
}

// Each instruction has one cycle of execution. Nearly all others have one cause.
[[gnu::always_inline]] inline void Engine::account(const Transition& t) {
  const int total = t.timing.total;
  if (total != 1 && !t.delayed_by) [[unlikely]]
    return account(t.timing);
  state_.cycle += total;
  ++state_.instructions;
  add(state_.causes, Cause::execute, 1);
  if (total != 1) add(state_.causes, *t.delayed_by, total - 1);
}

// The DMA's cost for an instruction is the cycles beyond those without the DMA. If an instruction took fewer cycles
// because of an earlier delay, they are deducted from the next cost. In total the DMA is charged with exactly what it
// caused.
void Engine::account(const Transition& t, const std::optional<StepTiming>& without_dma) {
  if (!without_dma) return account(t);
  const int held = t.timing.total - without_dma->total;
  if (held <= 0) {
    dma_side_.gain(-held);
    return account(t);
  }
  account(*without_dma);
  dma_side_.charge(held);
}

// The effects of an instruction's accesses on the cache, the pages and LOCK.
void Engine::settle_accesses(const Step& step, Address pc) {
  if (step.from_cache && !step.frozen) cache_.hit(pc);
  if (step.missed && !step.frozen) cache_.load(pc, step.word);
  if (step.paged) state_.open_pages = pages_;
  if (step.locks)
    if (const auto lock = lock_after(step.decoded->bound.row->operation))
      state_.locked[step.decoded->demand.data[0].resource == Resource::global] = *lock;
}

void Engine::finish_step(const Step& step) {
  Core& core = state_.core;
  const BoundInstruction& bound = step.decoded->bound;
  for (std::size_t k = 0; step.register_writes != 0 && k < 2; ++k)
    if ((step.register_writes >> k & 1u) != 0)
      peripherals_.write_by_processor(step.address[k], scratch_[k].cell[0], step.register_cycle[k]);
  if (bound.writes_status) {
    // LDIcond may leave ST unchanged.
    const bool written =
        !bound.row->conditional() || execute::holds(core, static_cast<isa::Condition>(bound.op.selector));
    if (written) write_status(core.r[reg::ST]);
  }
  if (bound.writes_interrupts) pins_.show_inputs();
  core.attention |= bound.writes_status || bound.writes_interrupts || !step.repeatable;
}

// Delayed branches take effect after their third slot; the loop hardware compares PC with RE. No program control may
// stand at RE: an RPTB there has set RE itself, after it was fetched.
void Engine::advance_pc(Address pc, Flow flow) {
  Core& core = state_.core;
  if (core.delay_slots != 0 && --core.delay_slots == 0) {
    core.pc = core.delay_target;
    core.annul = false;
    if (core.delay_repeat) {
      core.delay_repeat = false;
      core.modes |= st::RM;
      core.repeat_single = 0;
    }
    return;
  }
  if ((core.modes & st::RM) == 0 || pc != core.r[reg::RE] || flow != Flow::straight) return;
  if (static_cast<std::int32_t>(--core.r[reg::RC]) >= 0) {
    core.pc = core.r[reg::RS];
    if (core.repeat_single == 1) core.repeat_single = 2;
  } else {
    core.modes &= ~st::RM;
    core.repeat_single = 0;
  }
}

// `fresh`: each access is resolved again, so that it is seen.
Engine::Stepped Engine::exact_step(Step& step, bool fresh) {
  if (trace != nullptr) return traced_step(step);
  return probe_.on_data() ? probed_step(step, fresh) : untraced_step(step, fresh);
}

// The probe gets accesses with the cycle in which the next instruction begins: the DMA's delay is known before.
Engine::Stepped Engine::probed_step(Step& step, bool fresh) {
  const Address pc = state_.core.pc;
  const Stepped why = untraced_step(step, fresh);
  if (why != Stepped::done || !probe_.has_noted()) return why;
  if (dma_effect_ == DmaEffect::under_way) dma_side_.stop = run_dma(run_limit_, false);
  probe_.tell_noted(pc, state_.cycle);
  return why;
}

Engine::Stepped Engine::traced_step(Step& step) {
  const Core before = state_.core;
  const Causes causes = state_.causes;
  const Cycles cycle = state_.cycle;
  events_.clear();
  const Stepped why = untraced_step(step, true);
  if (why != Stepped::done) return why;
  const StepTiming timing = *step.timing;
  step.timing = &timing;
  if (dma_effect_ == DmaEffect::under_way)
    dma_side_.stop = run_dma(run_limit_, false);  // so that the record includes the delay by the DMA
  probe_.tell_noted(before.pc, state_.cycle);
  emit_trace(step, before, cycle, causes);
  return why;
}

Engine::Stepped Engine::untraced_step(Step& step, bool fresh) {
  Core& core = state_.core;
  step = Step{};
  if (!fetch(step)) return Stepped::fault;
  DecodedSlot& decoded = *step.decoded;
  const BoundInstruction& bound = decoded.bound;
  const Address pc = core.pc;
  if ((core.delay_slots != 0 || core.repeat_single != 0) && bound.flow != Flow::straight)
    return fail(Fault::Kind::illegal_sequence,
                fmt::format("{} may not stand {}", bound.row->mnemonic,
                            core.delay_slots != 0 ? "in the three slots of a delayed branch" : "under RPTS"));
  if ((core.modes & st::RM) != 0 && illegal_in_repeat(pc, bound))
    return fail(Fault::Kind::illegal_sequence,
                fmt::format("{} may not stand {} words before the end of a repeated block (RE = {:08X}h)",
                            bound.row->mnemonic, core.r[reg::RE] - pc, core.r[reg::RE]));
  if (fresh || decoded.stale || !decoded.keeps_windows) decoded.forget_windows();
  const Word enabled_dma = core.r[reg::DIE];
  const bool over_with_read = core.delay_slots == 3 && bound.row->write_stage == isa::WriteStage::read;
  // Whether a block repeats is decided when its last instruction is fetched, before that can write ST.
  const bool decided = bound.writes_status && core.delay_slots == 0;
  const bool annul = core.annul && core.delay_slots != 0 && core.delay_slots < 4 && !over_with_read;
  if (annul) [[unlikely]] {
    annulled(step);
    settle_accesses(step, pc);
  } else {
    if (const Stepped why = execute(step); why != Stepped::done) {
      probe_.forget();
      return why;
    }
    settle_accesses(step, pc);
    if (decided) advance_pc(pc, bound.flow);
    finish_step(step);
    if (pins_.driven() && (bound.writes_interrupts || step.register_writes != 0)) [[unlikely]]
      if (const auto pin = pins_.contended())
        return fail(Fault::Kind::not_modelled,
                    fmt::format("pin {} becomes an output, and a net or device drives it", name(*pin)));
  }
  std::optional<StepTiming> without;
  if (dma_effect_ != DmaEffect::none) [[unlikely]]
    without = dma_side_.without_dma(demand_through(step, annul));
  const Transition& next = annul ? annulled_transition(step) : executed_transition(step);
  step.timing = &next.timing;
  pipeline_.set(next.after);
  const Cycles before = state_.cycle;
  account(next, without);
  if (access_.is_answered()) [[unlikely]] {
    settle_answers();
    if (peripherals_.dma_active()) dma_side_.mark_under_way();
  }
  if (bound.writes_interrupts) {
    peripherals_.pins_changed();
    if (core.r[reg::DIE] != enabled_dma && peripherals_.dma_active())
      peripherals_.interrupt_enable_written(enabled_dma, state_.cycle - 1);
  }
  if (dma_effect_ == DmaEffect::under_way) [[unlikely]]
    dma_side_.note_accesses(annul ? Demand{} : decoded.demand, *step.timing, before);
  if (bound.flow != Flow::straight || bound.writes_status)
    cache_.note_control(state_.cycle - 1 - step.timing->of(Cause::branch));
  if (!decided) advance_pc(pc, bound.flow);
  return Stepped::done;
}

// The last instruction of a repeated block must not be program control. A delayed branch must not be one of the three
// before it (c40-isa.md 8.3).
bool Engine::illegal_in_repeat(Address pc, const BoundInstruction& bound) const {
  const Address left = state_.core.r[reg::RE] - pc;
  return bound.flow != Flow::straight && (left == 0 || (left <= 3 && bound.row->delay != isa::Delay::none));
}

// An annulled slot is fetched but has no footprint.
Demand Engine::demand_through(const Step& step, bool annulled) const {
  const BoundInstruction& bound = step.decoded->bound;
  if (!annulled) {
    Demand demand = step.demand();
    demand.flush_cost = step.taken ? bound.taken_cost : bound.not_taken_cost;
    return demand;
  }
  Demand demand;
  demand.fetch = step.fetch;
  demand.fetch_missed = step.missed;
  return demand;
}

const Transition& Engine::annulled_transition(const Step& step) { return transition(demand_through(step, true), 0); }

const Transition& Engine::executed_transition(const Step& step) {
  DecodedSlot& decoded = *step.decoded;
  decoded.fetch_bits = packed_fetch(step.fetch, step.fetched, step.missed);
  decoded.exit = step.taken ? Exit::taken : Exit::not_taken;
  return decoded.transition = transition(demand_through(step, false), step.word);
}

// Finds the transition for a quick step that is not the same as the last one of its slot. False: the instruction was
// not executed.
[[gnu::noinline]] bool Engine::meet_transition(DecodedSlot& decoded, Exit exit) {
  if (exit == Exit::miss || exit == Exit::trap_out) return false;
  Demand demand = decoded.demand;
  if (decoded.fetch_bits == code_.fetch_bits) demand.fetch = code_.met.access;
  demand.fetched = decoded.fetch_bits != unfetched_bits;
  demand.flush_cost = exit == Exit::taken ? decoded.bound.taken_cost : decoded.bound.not_taken_cost;
  decoded.exit = exit;
  decoded.transition = transition(demand, decoded.bound.word);
  return true;
}

// The common case of untraced_step, much cheaper: a known instruction whose accesses meet the same windows as before
// and that does not affect interrupts; with its repetitions under RPTS. True: the next one can be tried. False: it is
// no such instruction, and nothing of it has happened, or continues() is false.
template <class Continues>
[[gnu::always_inline]] inline bool Engine::quick_step(const Continues& continues) {
  Core& core = state_.core;
  const Address pc = core.pc;
  if (!code_.contains_unpaged(pc)) return false;
  Word word = code_.word(pc);
  std::uint64_t fetch_bits = code_.fetch_bits;
  if (code_.cacheable && cache_.on()) [[unlikely]] {
    const Word* const cached = cache_.find(pc);
    if (cached == nullptr) return false;
    word = *cached;
    fetch_bits = cached_bits;
  }
  if (core.repeat_single == 2) {
    fetch_bits = unfetched_bits;
    code_.area->mark_code(pc);  // it may overwrite its own word: then it is looked at again
  }
  DecodedSlot& decoded = decoded_slots_[pc];
  if (decoded.quick_key != DecodedSlot::key(word, core.modes)) return false;
  if ((core.delay_slots != 0 || (core.modes & st::RM) != 0) && (decoded.bound.flow != Flow::straight || core.annul))
    return false;  // perhaps the instruction is not allowed here, or annulled
  if (decoded.fetch_bits != fetch_bits) {
    decoded.fetch_bits = fetch_bits;
    decoded.forget_transition();
  }
  decoded.ops[0].pc = pc;
  do {
    core.pc = pc + 1;
    const Exit exit = decoded.ops[0].handler(core, decoded.ops.data()).exit;
    if ((exit != decoded.exit || !pipeline_.is(decoded.transition.before)) && !meet_transition(decoded, exit)) {
      core.pc = pc;
      return false;
    }
    pipeline_.set(decoded.transition.after);
    account(decoded.transition);
    if (code_.cacheable && cache_.on() && core.repeat_single != 2 && !cache_.frozen()) [[unlikely]]
      cache_.hit(pc);
    if (core.delay_slots != 0 || (core.modes & st::RM) != 0) advance_pc(pc, decoded.bound.flow);
    if (!continues()) return false;
  } while (core.pc == pc && decoded.fetch_bits == unfetched_bits);
  return true;
}

// Executes instruction after instruction, as long as the conditions that advance() checked cannot have changed and no
// block can be used. A quick step changes none of the conditions that `attention` does not report.
Engine::Stepped Engine::run_exactly(Cycles limit) {
  const Core& core = state_.core;
  const auto continues = [&] { return !core.attention && state_.cycle < limit && (exact_only || !by_blocks()); };
  Step step;
  while (core.code_writes == 0 && !peripherals_.interface_changed() && !core.idle && continues()) {
    while (quick_step(continues)) continue;
    if (!continues()) return Stepped::done;
    if (const Stepped why = exact_step(step, false); why != Stepped::done) return why;
  }
  return Stepped::done;
}

void Engine::emit_trace(const Step& step, const Core& before, Cycles cycle, const Causes& causes) {
  TraceRecord out;
  out.cycle = cycle;
  out.pc = before.pc;
  out.word = step.word;
  out.cycles = state_.cycle - cycle;
  for (std::size_t i = 0; i < cause_count; ++i) out.causes[i] = state_.causes[i] - causes[i];
  out.stages = step.timing->stages;
  std::vector<RegisterChange> changes;
  const Core& now = state_.core;
  for (std::uint8_t code = 0; code < 32; ++code) {
    const auto r = static_cast<isa::Register>(code);
    const auto value = [&](const Core& core) -> std::uint64_t {
      if (code == reg::ST) return core.status();
      return isa::is_extended(r) ? float40::bits({core.e[code], core.r[code]}) : core.r[code];
    };
    const bool stored_alike = before.r[code] == now.r[code] && before.e[code] == now.e[code] && code != reg::ST;
    if (!stored_alike && value(before) != value(now)) changes.push_back({r, value(now)});
  }
  out.registers = changes;
  out.memory = events_;
  trace->instruction(out);
}

}  // namespace c40
