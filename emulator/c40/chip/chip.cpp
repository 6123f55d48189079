#include "c40/chip/chip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "c40/chip/interrupts.hpp"
#include "c40/engine/engine.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {

std::string_view name(StopInfo::Reason reason) {
  switch (reason) {
    case StopInfo::Reason::limit: return "limit";
    case StopInfo::Reason::external_access: return "external_access";
    case StopInfo::Reason::breakpoint: return "breakpoint";
    case StopInfo::Reason::fault: return "fault";
    case StopInfo::Reason::port_access: return "port_access";
    case StopInfo::Reason::port_wait: return "port_wait";
    case StopInfo::Reason::horizon: return "horizon";
    case StopInfo::Reason::software_interrupt: return "software_interrupt";
  }
  return {};
}

std::string_view name(Fault::Kind kind) {
  switch (kind) {
    case Fault::Kind::reserved_instruction: return "reserved_instruction";
    case Fault::Kind::reserved_address: return "reserved_address";
    case Fault::Kind::not_modelled: return "not_modelled";
    case Fault::Kind::illegal_sequence: return "illegal_sequence";
    case Fault::Kind::software_interrupt: return "software_interrupt";
  }
  return {};
}

Chip::Chip(Board board) : engine_(std::make_unique<Engine>(std::move(board))) {}
Chip::~Chip() = default;
Chip::Chip(Chip&&) noexcept = default;
Chip& Chip::operator=(Chip&&) noexcept = default;

void Chip::write_block(Address address, std::span<const Word> words) {
  if (address + std::uint64_t{words.size()} > std::uint64_t{1} << 32)
    throw std::out_of_range("the words pass the end of the address space");
  for (Word word : words) engine_->poke(address++, word);
}
Word Chip::peek(Address address) const { return engine_->peek(address); }
void Chip::poke(Address address, Word value) { engine_->poke(address, value); }

void Chip::reset() { engine_->reset(); }
void Chip::boot() { engine_->boot(); }
Address Chip::pc() const { return engine_->state().core.pc; }

// set_pc cancels pending delayed branches, annulled slots and accesses.
void Chip::set_pc(Address pc) {
  State& state = engine_->touch();
  state.core.pc = pc;
  state.core.delay_slots = 0;
  state.core.annul = state.core.delay_repeat = state.core.idle = false;
  state.answers = {};
  engine_->access().forget();
  state.pipeline.flush(0);
}

std::uint64_t Chip::register_value(isa::Register r) const {
  const Core& core = engine_->state().core;
  const std::uint8_t code = isa::code(r);
  if (code == reg::ST) return core.status();
  return isa::is_extended(r) ? float40::bits({core.e[code], core.r[code]}) : core.r[code];
}

void Chip::set_register(isa::Register r, std::uint64_t value) {
  const std::uint64_t limit = isa::is_extended(r) ? std::uint64_t{1} << 40 : std::uint64_t{1} << 32;
  if (value >= limit) throw std::out_of_range(fmt::format("{:X}h does not fit into {}", value, isa::name(r)));
  Core& core = engine_->touch().core;
  const std::uint8_t code = isa::code(r);
  const auto word = static_cast<Word>(value);
  if (code == reg::ST) return engine_->set_status(word);
  core.r[code] = word;
  if (isa::is_extended(r)) core.e[code] = float40::from_bits(value).e;
  if (code == reg::IIF) engine_->pins().show_inputs(), engine_->peripherals().pins_changed();
}

Float40 Chip::float_register(isa::Register r) const {
  if (!isa::is_extended(r)) throw std::out_of_range(fmt::format("{} cannot hold a float", isa::name(r)));
  const Core& core = engine_->state().core;
  return {core.e[isa::code(r)], core.r[isa::code(r)]};
}

Word Chip::expansion(isa::Expansion r) const {
  return r == isa::Expansion::IVTP ? engine_->state().core.ivtp : engine_->state().core.tvtp;
}
void Chip::set_expansion(isa::Expansion r, Word value) {
  Core& core = engine_->touch().core;
  (r == isa::Expansion::IVTP ? core.ivtp : core.tvtp) = value & choices::vector_table_mask;
}

const StopInfo& Chip::run_until(Cycles limit, Cycles known) { return engine_->run_until(limit, known); }
const StopInfo& Chip::step() { return engine_->step(); }
void Chip::complete_read(Word value, Cycles arbitration, Cycles transfer) {
  engine_->complete(false, value, arbitration, transfer);
}
void Chip::complete_write(Cycles arbitration, Cycles transfer) { engine_->complete(true, 0, arbitration, transfer); }

namespace {
void check_port(int port) {
  if (port < 0 || port >= port_count)
    throw std::invalid_argument(
        fmt::format("there is no communication port {}; 0 to {} are possible", port, port_count - 1));
}
void check_timer(int timer) {
  if (timer < 0 || timer >= timer_count)
    throw std::out_of_range(fmt::format("there is no timer {}; 0 and 1 are possible", timer));
}
void check_pin(int pin) {
  if (pin < 0 || pin > 3) throw std::out_of_range(fmt::format("there is no pin IIOF{}; 0 to 3 are possible", pin));
}
}  // namespace

bool Chip::iiof_pin(int pin) const {
  check_pin(pin);
  return engine_->pins().level(static_cast<unsigned>(pin));
}
void Chip::raise_iiof(int pin) {
  check_pin(pin);
  engine_->peripherals().raise(interrupts::iiof_flag(static_cast<unsigned>(pin)), cycle());
}
void Chip::raise_nmi() { engine_->peripherals().raise(interrupts::nmi_flag, cycle()); }
void Chip::raise_timer(int timer) {
  check_timer(timer);
  engine_->peripherals().raise(interrupts::timer_flags[static_cast<std::size_t>(timer)], cycle());
}
void Chip::set_window_listener(WindowListener* listener) { engine_->window_listener = listener; }
void Chip::catch_up() { engine_->catch_up(); }
void Chip::attach(int port, PortListener* link) {
  check_port(port);
  if (link != nullptr && engine_->ports().listener(port) != nullptr)
    throw std::invalid_argument(fmt::format("communication port {} is already attached", port));
  engine_->ports().attach(port, link);
}
CommPort& Chip::port(int port) {
  check_port(port);
  return engine_->ports()[port];
}
const CommPort& Chip::port(int port) const {
  check_port(port);
  return engine_->state().ports[static_cast<std::size_t>(port)];
}
void Chip::complete_port(Cycles at) { engine_->complete_port(at); }
bool Chip::dma_active() const { return engine_->peripherals().dma_active(); }
bool Chip::dma_busy() const {
  return engine_->peripherals().dma_busy() || (engine_->peripherals().dma_active() && engine_->dma().ends());
}
bool Chip::dma_ends_by(Cycles cycle) const {
  return engine_->peripherals().dma_active() && engine_->dma().ends_at(cycle);
}
std::vector<DmaWait> Chip::dma_waits() const { return engine_->dma().waits(); }
Cycles Chip::settled() const {
  const State& state = engine_->state();
  if (!engine_->peripherals().dma_active()) return state.cycle;
  return engine_->access().any() ? state.dma.now : std::min(state.cycle, state.dma.now);
}
bool Chip::watches_ports() const { return engine_->watched_ports() != 0; }

void Chip::set_pin(Pin pin, bool level, Cycles at) {
  if (pin == Pin::reset) throw std::invalid_argument("RESET: its driver calls reset() or boot()");
  engine_->peripherals().set_pin(pin, level, at);
}
void Chip::watch_pins(PinListener* listener, unsigned outputs, unsigned inputs) {
  engine_->watch_pins(listener, outputs, inputs);
}
bool Chip::reacts_to(Pin pin) const { return engine_->peripherals().reacts_to(pin); }
bool Chip::timer_pin(int timer) const {
  check_timer(timer);
  const State& state = engine_->state();
  Timer now = state.timers[static_cast<std::size_t>(timer)];
  now.advance_to(state.cycle);
  return now.pin(state.cycle);
}
Word Chip::peripheral(std::string_view name) const { return engine_->peek(register_named(name).address); }

Cycles Chip::next_timer_event(int timer) const {
  check_timer(timer);
  return engine_->state().timers[static_cast<std::size_t>(timer)].next_event();
}
Cycles Chip::next_event() const { return engine_->peripherals().next_event(); }
bool Chip::locked(bool global_bus) const { return engine_->state().locked[global_bus]; }
bool Chip::dormant() const { return idle() && !dma_active() && next_event() == std::numeric_limits<Cycles>::max(); }
bool Chip::idle() const { return engine_->waits_in_idle(); }
bool Chip::interrupt_pending() const { return interrupts::pending(engine_->state()) != 0; }
Cycles Chip::idle_since() const { return engine_->idle_since(); }
Cycles Chip::dma_done() const { return engine_->dma().last_done(); }
bool Chip::timer_drives_dma(int timer) const {
  check_timer(timer);
  return engine_->peripherals().timer_drives_dma(static_cast<std::size_t>(timer));
}
void Chip::hold(bool held) { engine_->hold(held); }
void Chip::stand_until(Cycles cycle, Cause cause) { engine_->stand_until(cycle, cause); }
void Chip::let_peripherals_reach(Cycles cycle) { engine_->peripherals().advance_to(cycle); }
bool Chip::halted() const { return engine_->state().held || engine_->state().faulted; }

Cycles Chip::cycle() const { return engine_->state().cycle; }
std::uint64_t Chip::instructions() const {
  engine_->settle_counts();
  return engine_->state().instructions;
}
const Causes& Chip::causes() const {
  engine_->settle_counts();
  return engine_->state().causes;
}

void Chip::add_breakpoint(Address address) {
  if (engine_->breakpoints.contains(address)) return;
  engine_->flush_blocks();
  engine_->breakpoints.insert(address);
}
void Chip::remove_breakpoint(Address address) {
  engine_->flush_blocks();
  engine_->breakpoints.erase(address);
}
void Chip::stop_at_ends(bool stops) {
  if (engine_->stops_at_ends == stops) return;
  engine_->flush_blocks();
  engine_->stops_at_ends = stops;
}
isa::ProgramEnd Chip::program_end() const { return engine_->program_end(); }
void Chip::set_peripheral_sink(PeripheralSink* sink) { engine_->tell.sink = sink; }
void Chip::set_trace(TraceSink* sink) { engine_->trace = sink; }
TraceSink* Chip::trace() const { return engine_->trace; }
void Chip::set_probe(Probe* probe, ProbePlan plan) { engine_->set_probe(probe, std::move(plan)); }
void Chip::set_exact(bool exact) { engine_->exact_only = exact; }

const State& Chip::state() const {
  engine_->settle_counts();
  return engine_->state();
}
const Memory& Chip::memory() const { return engine_->memory(); }

}  // namespace c40
