#include "c40/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/addressing.hpp"
#include "c40/handler_tables.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {
namespace {

constexpr std::size_t bound_cache_size = 4096;

std::size_t cache_index(Word word) { return (word * 0x9E3779B1u) >> 20; }

void add(Causes& causes, Cause cause, Cycles cycles) { causes[static_cast<std::size_t>(cause)] += cycles; }

}  // namespace

Engine::Engine(Board board) : board_(std::move(board)), memory_(board_), bounds_(bound_cache_size), transitions_(4096) { reset(); }

void Engine::reset() {
  flush_blocks();
  for (PortListener* link : listeners_)
    if (link != nullptr) link->about_to_reset(state_.cycle);
  const State old = state_;
  state_ = State{};
  state_.cycle = old.cycle;
  state_.instructions = old.instructions;
  state_.causes = old.causes;
  state_.held = old.held;
  state_.iiof_levels = old.iiof_levels;
  state_.ports = old.ports;
  reset_ports();
  expect_peripherals();
  state_.core.e.fill(float40::zero_exponent);
  state_.global_interface_control = board_.global_interface_control;
  state_.local_interface_control = board_.local_interface_control;
  fault_.reset();
  forget_access();
  reported_breakpoint_.reset();
  touch();
}

State& Engine::touch() {
  resume_ = nullptr;
  missed_ = nullptr;
  last_exit_ = nullptr;
  known_pipeline_.reset();
  return state_;
}

Word Engine::peek(Address address) const {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr && board_.is_flat) return 0;
  if (area == nullptr) throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data != nullptr) return area->data[address - area->base];
  Word value = 0;
  if (area->kind == Region::Kind::registers && read_register(address, state_.cycle, value)) return value;
  throw std::out_of_range(fmt::format("address {:08X}h ({}) cannot be read without a bus access", address, area->name));
}

void Engine::poke(Address address, Word value) {
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr) throw std::out_of_range(fmt::format("address {:08X}h is reserved on board {}", address, board_.name));
  if (area->data == nullptr) {
    if (area->kind == Region::Kind::registers && write_register(address, value, state_.cycle)) return;
    throw std::out_of_range(fmt::format("address {:08X}h ({}) cannot be written without a bus access", address, area->name));
  }
  const Word offset = address - area->base;
  if ((area->code_map()[offset >> 5] >> (offset & 31) & 1u) != 0) flush_blocks();
  area->data[offset] = value;
}

// ---- one instruction ----

Engine::Stepped Engine::fail(Fault::Kind kind, std::string message, Address address) {
  Fault fault;
  fault.kind = kind;
  fault.message = std::move(message);
  fault.pc = state_.core.pc;
  fault.cycle = state_.cycle;
  fault.address = address;
  if (const Memory::Area* area = memory_.find(fault.pc); area != nullptr && area->data != nullptr)
    fault.word = area->data[fault.pc - area->base];
  fault_ = std::move(fault);
  return Stepped::fault;
}

const Bound* Engine::fetch(StepRecord& record) {
  const Address pc = state_.core.pc;
  if (code_area_ == nullptr || !code_area_->contains(pc)) {
    const Memory::Area* area = memory_.find(pc);
    if (area == nullptr) {
      fail(Fault::Kind::reserved_address, fmt::format("instruction fetch from the reserved address {:08X}h", pc), pc);
      return nullptr;
    }
    if (area->data == nullptr) {
      fail(Fault::Kind::not_modelled, fmt::format("instruction fetch from {:08X}h ({}) is not modelled", pc, area->name), pc);
      return nullptr;
    }
    code_area_ = area;
  }
  record.demand.fetch = code_area_->read;
  record.demand.fetched = state_.core.repeat_single != 2;
  const Word word = code_area_->data[pc - code_area_->base];
  const bool set_condition = (state_.core.modes & st::SETCOND) != 0;
  CachedBound& cached = bounds_[cache_index(word)];
  if (cached.valid && cached.word == word && cached.set_condition == set_condition) return &cached.bound;
  auto bound = bind(word, set_condition);
  if (const auto* no = std::get_if<Unexecutable>(&bound)) {
    if (no->reserved)
      fail(Fault::Kind::reserved_instruction, fmt::format("{:08X}h is no instruction: {}", word, no->reason));
    else
      fail(Fault::Kind::not_modelled, fmt::format("the instruction {} ({:08X}h) is not modelled", no->reason, word));
    return nullptr;
  }
  cached = {word, true, set_condition, std::get<Bound>(bound)};
  return &cached.bound;
}

// The model costs some hundred instructions, and the same few transitions come again and again.
const Engine::Transition& Engine::transition(const Demand& demand, isa::Word word) {
  const auto packed = [](const Access& access) {
    return static_cast<std::uint64_t>(access.resource) | std::uint64_t{access.write} << 3 | std::uint64_t{access.waits} << 4;
  };
  std::uint64_t bits = packed(demand.fetch) | std::uint64_t{demand.fetched} << 12 | std::uint64_t{demand.count} << 13 |
                       static_cast<std::uint64_t>(demand.flush_cost) << 15;
  for (std::size_t i = 0; i < demand.count; ++i) bits |= packed(demand.data[i]) << (20 + 12 * i);
  const PipelineId before = current_pipeline();
  const std::uint64_t hash = (bits ^ std::uint64_t{before} << 44 ^ std::uint64_t{word} << 17) * 0x9E3779B97F4A7C15u;
  Transition& entry = transitions_[hash >> 52];
  if (entry.demand != bits || entry.before != before || entry.word != word) {
    entry = {bits, before, word, {}, 0};
    Pipeline pipeline = state_.pipeline;
    entry.timing = pipeline.advance(demand);
    entry.after = intern(pipeline);
  }
  return entry;
}

Cycles Engine::access_cycle(const StepRecord& record, int access) {
  Demand demand = record.demand;
  demand.count = static_cast<std::uint8_t>(access + 1);
  const int start = transition(demand, record.bound.word).timing.start[static_cast<std::size_t>(access)];
  Cycles cycle = state_.cycle + std::max(start, 0);
  for (const Answer& answer : state_.answers)
    if (answer.given) cycle += answer.waited();
  return cycle;
}

// An access did not meet a known region: find it, or stop.
Engine::Stepped Engine::resolve(StepRecord& record, Op& op) {
  const Core& core = state_.core;
  const std::size_t k = core.miss_access;
  const Address address = core.miss_address;
  const bool write = core.miss_write;
  const Memory::Area* area = memory_.find(address);
  if (area == nullptr)
    return fail(Fault::Kind::reserved_address,
                fmt::format("{} {:08X}h, which is reserved on board {}", write ? "write to" : "read of", address, board_.name),
                address);
  record.demand.data[k] = write ? area->write : area->read;
  record.demand.count = std::max(record.demand.count, static_cast<std::uint8_t>(k + 1));
  record.address[k] = address;
  if (area->data != nullptr) {
    record.windows[k] = op.access[k] = {area->data, area->base, area->words};
    if (trace != nullptr) events_.push_back({address, write ? core.miss_value : area->data[address - area->base], write});
    return Stepped::done;
  }
  record.only_ram = false;
  auto& cell = scratch_[k].cell;
  cell = {};
  if (area->kind == Region::Kind::registers && is_port_register(address)) {
    if (const Stepped why = access_port(record, k, cell[0]); why != Stepped::done) return why;
  } else if (area->kind == Region::Kind::registers) {
    record.register_cycle[k] = access_cycle(record, core.miss_access);
    if (!read_register(address, record.register_cycle[k], cell[0]))
      return fail(Fault::Kind::not_modelled,
                  fmt::format("{} {:08X}h: {} is not modelled", write ? "write to" : "read of", address, describe_register(address)),
                  address);
    record.register_write[k] = write;
  } else {
    const Answer& answer = state_.answers[k];
    if (!answer.given || answer.address != address || answer.write != write) {
      waiting_ = {address, write, record.bound.row->interlocked, write ? core.miss_value : 0, access_cycle(record, core.miss_access)};
      waiting_access_ = k;
      port_slot_ = 2;
      return Stepped::external;
    }
    cell[0] = answer.value;
  }
  op.access[k] = {cell.data(), address, 1};
  if (trace != nullptr) events_.push_back({address, write ? core.miss_value : cell[0], write});
  return Stepped::done;
}

Engine::Stepped Engine::execute(StepRecord& record) {
  Core& core = state_.core;
  const Address pc = core.pc;
  std::array<Op, 2> ops{record.bound.op, Op{}};
  ops[0].pc = pc;
  ops[1].handler = &execute::end_of_step;
  if (record.bound.reads_status) core.r[reg::ST] = core.status();
  core.pc = pc + 1;
  for (;;) {
    const Outcome outcome = ops[0].handler(core, ops.data());
    if (outcome.exit == Exit::miss) {
      core.pc = pc;  // faults and stops name this instruction
      if (const Stepped why = resolve(record, ops[0]); why != Stepped::done) return why;
      core.pc = pc + 1;
      continue;
    }
    if (outcome.exit == Exit::trap_out) {
      core.pc = pc;
      return Stepped::breakpoint;
    }
    record.taken = outcome.exit == Exit::taken;
    return Stepped::done;
  }
}

// The execute stage of an annulled slot does not happen; the earlier stages of the first two slots did (8.2). LDA in the first
// slot, which is over with its read stage, does not come here.
void Engine::annulled(const StepRecord& record) {
  Core& core = state_.core;
  const std::uint32_t slot = 4 - core.delay_slots;  // 1 to 3
  core.pc += 1;
  if (slot == 3) return;
  const Op& op = record.bound.op;
  std::array<Word, 2> updated{};
  const auto slots = static_cast<std::size_t>(record.bound.address_updates);
  for (std::size_t i = 0; i < slots; ++i)
    updated[i] = execute::form_indirect(core, op.ar[i], op.modn[i], op.displacement[i]).updated;
  for (std::size_t i = 0; i < slots; ++i)
    if (isa::modn::modifies(op.modn[i])) core.r[op.ar[i]] = updated[i];
  if (record.bound.row->write_stage == isa::WriteStage::decode) core.r[op.dst] = op.immediate;
}

void Engine::account(const StepRecord& record) {
  const StepTiming& t = record.timing;
  state_.cycle += t.total;
  ++state_.instructions;
  Causes& causes = state_.causes;
  add(causes, Cause::execute, t.total - t.branch - t.register_conflict - t.memory_conflict - t.wait_state);
  add(causes, Cause::branch, t.branch);
  add(causes, Cause::register_conflict, t.register_conflict);
  add(causes, Cause::memory_conflict, t.memory_conflict);
  add(causes, Cause::wait_state, t.wait_state);
  for (Answer& answer : state_.answers) {
    if (!answer.given) continue;
    add(causes, Cause::bus_arbitration, answer.arbitration);
    add(causes, Cause::bus_transfer, answer.transfer);
    add(causes, Cause::comm_port, answer.comm_port);
    state_.cycle += answer.waited();
    answer = {};
  }
}

void Engine::write_status(Word value) {
  Core& core = state_.core;
  const Word count = core.r[reg::RC];
  if (count == 0 || count == 0xFFFFFFFFu) value &= ~st::RM;
  if ((value & st::RM) == 0) core.repeat_single = 0;
  core.set_status(value);
}

void Engine::finish_step(const StepRecord& record) {
  Core& core = state_.core;
  for (std::size_t k = 0; k < 2; ++k)
    if (record.register_write[k]) write_register(record.address[k], scratch_[k].cell[0], record.register_cycle[k]);
  // LDIcond may leave ST as it is.
  const bool written = !record.bound.row->conditional() || execute::holds(core, static_cast<isa::Condition>(record.bound.op.selector));
  if (record.bound.writes_status && written) write_status(core.r[reg::ST]);
  if (record.bound.writes_interrupts) after_interrupt_register_write();
}

// Delayed branches take effect after their third slot; the loop hardware compares with RE.
void Engine::advance_pc(Address pc) {
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
  if ((core.modes & st::RM) == 0 || pc != core.r[reg::RE]) return;
  if (static_cast<std::int32_t>(--core.r[reg::RC]) >= 0) {
    core.pc = core.r[reg::RS];
    if (core.repeat_single == 1) core.repeat_single = 2;
  } else {
    core.modes &= ~st::RM;
    core.repeat_single = 0;
  }
}

Engine::Stepped Engine::exact_step(StepRecord& record) {
  Core& core = state_.core;
  record = StepRecord{};
  last_exit_ = nullptr;
  const Bound* bound = fetch(record);
  if (bound == nullptr) return Stepped::fault;
  record.bound = *bound;
  const Address pc = core.pc;
  const bool held_together = core.delay_slots != 0 || core.repeat_single != 0;
  if (held_together && bound->flow != Flow::straight)
    return fail(Fault::Kind::illegal_sequence,
                fmt::format("{} may not stand {}", bound->row->mnemonic,
                            core.delay_slots != 0 ? "in the three slots of a delayed branch" : "under RPTS"));
  const Cycles before_cycle = state_.cycle;
  std::optional<Core> before;
  Causes before_causes{};
  if (trace != nullptr) {
    before = core;
    before_causes = state_.causes;
    events_.clear();
  }
  const bool over_with_read = core.delay_slots == 3 && bound->row->write_stage == isa::WriteStage::read;
  const bool annul = core.annul && core.delay_slots != 0 && core.delay_slots < 4 && !over_with_read;
  if (annul) {
    annulled(record);
  } else {
    record.demand.footprint = bound->footprint;
    if (const Stepped why = execute(record); why != Stepped::done) return why;
    finish_step(record);
    record.demand.flush_cost = record.taken ? bound->taken_cost : bound->not_taken_cost;
  }
  const Transition& step = transition(record.demand, annul ? 0 : record.bound.word);  // annulled: no footprint
  record.timing = step.timing;
  known_pipeline_ = step.after;
  state_.pipeline = pipelines_[step.after];
  account(record);
  advance_pc(pc);
  if (before) emit_trace(record, *before, before_cycle, before_causes);
  return Stepped::done;
}

void Engine::emit_trace(const StepRecord& record, const Core& before, Cycles cycle, const Causes& causes) {
  TraceRecord out;
  out.cycle = cycle;
  out.pc = before.pc;
  out.word = record.bound.word;
  out.cycles = state_.cycle - cycle;
  for (std::size_t i = 0; i < cause_count; ++i) out.causes[i] = state_.causes[i] - causes[i];
  out.stages = record.timing.stages;
  std::vector<RegisterChange> changes;
  const Core& now = state_.core;
  for (std::uint8_t code = 0; code < 32; ++code) {
    const auto r = static_cast<isa::Register>(code);
    const auto value = [&](const Core& core) -> std::uint64_t {
      if (code == reg::ST) return core.status();
      return isa::is_extended(r) ? float40::bits({core.e[code], core.r[code]}) : core.r[code];
    };
    if (value(before) != value(now)) changes.push_back({r, value(now)});
  }
  out.registers = changes;
  out.memory = events_;
  trace->instruction(out);
}

// ---- running ----

void Engine::pass(Cause cause, Cycles until) {
  if (until <= state_.cycle) return;
  add(state_.causes, cause, until - state_.cycle);
  state_.cycle = until;
  state_.pipeline.drain();
  known_pipeline_.reset();
}

StopInfo Engine::stop(Stepped why) {
  StopInfo info;
  switch (why) {
    case Stepped::done: break;
    case Stepped::external:
      info.reason = StopInfo::Reason::external_access;
      info.access = waiting_;
      break;
    case Stepped::breakpoint: info.reason = StopInfo::Reason::breakpoint; break;
    case Stepped::port:
      info.reason = listener(port_access_.port) != nullptr ? StopInfo::Reason::port_access : StopInfo::Reason::port_wait;
      info.port = port_access_;
      break;
    case Stepped::horizon: info.reason = StopInfo::Reason::horizon; break;
    case Stepped::fault:
      info.reason = StopInfo::Reason::fault;
      info.fault = fault_;
      state_.faulted = true;
      break;
  }
  return info;
}

bool Engine::may_interrupt() const {
  return state_.core.delay_slots == 0 && state_.core.repeat_single == 0 && !state_.answers[0].given && !state_.answers[1].given &&
         !state_.stalled_on_port;
}

// One thing: a stop, an interrupt entry, idling, a run of blocks, or one exact instruction.
std::optional<StopInfo> Engine::advance(Cycles limit, bool single) {
  Core& core = state_.core;
  core.attention = false;
  if (state_.cycle >= next_peripheral_event_) advance_peripherals(state_.cycle);
  limit = std::min(limit, next_peripheral_event_);
  if (core.code_writes != 0) process_code_writes();
  if (may_interrupt()) {
    if (const Word vector = pending_vector(); vector != 0) {
      if (!take_interrupt(vector)) return stop(Stepped::fault);
      return std::nullopt;
    }
    if (core.idle) {
      pass(Cause::idle, limit);
      return std::nullopt;
    }
  }
  if (!single && !breakpoints.empty() && breakpoints.contains(core.pc) && reported_breakpoint_ != state_.cycle) {
    reported_breakpoint_ = state_.cycle;
    return stop(Stepped::breakpoint);
  }
  const bool answered = state_.answers[0].given || state_.answers[1].given;
  const bool exact = single || exact_only || trace != nullptr || answered;
  if (!exact && missed_ == nullptr) {
    if (Block* block = std::exchange(resume_, nullptr); block != nullptr) {
      run_blocks(block, resume_at_, limit);
      return std::nullopt;
    }
    if (core.delay_slots == 0 && !exact_site(core.pc)) {
      Stepped why = Stepped::done;
      if (Block* block = find_or_record(limit, why); block != nullptr) run_blocks(block, 0, limit);
      if (why != Stepped::done) return stop(why);
      return std::nullopt;
    }
  }
  resume_ = nullptr;
  Block* missed = std::exchange(missed_, nullptr);
  StepRecord record;
  const Address pc = core.pc;
  if (const Stepped why = exact_step(record); why != Stepped::done) return stop(why);
  if (record.only_ram && exact_site(pc) && site(pc).external) site(pc).known = false;
  if (missed != nullptr && core.code_writes == 0) rejoin(*missed);
  return std::nullopt;
}

StopInfo Engine::run_until(Cycles limit) {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, limit);
    return {};
  }
  const Word watched = watched_ports();
  while (state_.cycle < limit) {
    if (auto info = advance(limit, false)) return *info;
    if (attached_ != 0 && (watched_ports() & ~watched) != 0) return stop(Stepped::horizon);
  }
  if (state_.cycle >= next_peripheral_event_) advance_peripherals(state_.cycle);
  return {};
}

StopInfo Engine::step() {
  if (state_.held || state_.faulted) {
    pass(Cause::halted, state_.cycle + 1);
    return {};
  }
  if (auto info = advance(state_.cycle + 1, true)) return *info;
  return {};
}

void Engine::complete(bool write, Word value, Cycles arbitration, Cycles transfer) {
  if (waiting_access_ >= 2 || waiting_.write != write)
    throw std::logic_error(fmt::format("the chip does not wait for a {}", write ? "write" : "read"));
  if (arbitration < 0 || transfer < 0) throw std::invalid_argument("a chip cannot wait a negative number of cycles");
  state_.answers[waiting_access_] = {true, write, waiting_.address, value, arbitration, transfer, 0};
  waiting_access_ = 2;
}

}  // namespace c40
