#include "machine/dsps/dsp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "isa/types.hpp"
#include "machine/bus_agents/guard.hpp"

namespace machine {

namespace {

pci::MasterConfig master_of(const Config& config, unsigned slot) {
  pci::MasterConfig master = config.dsp_master;
  master.name = fmt::format("DSP {}", slot);
  master.agent = slot + 1;
  master.first_level = slot < config.first_level_dsps;
  return master;
}

}  // namespace

Dsp::Dsp(unsigned slot, bool plugged, DspContext& context)
    : slot_{slot}, context_{context}, clock_{context_.chip_clocks[slot]}, chip_{context_.config.board}, sides_{} {
  const Config& config = context_.config;
  for (unsigned port = 0; port < config.topology.dsps.size(); ++port)
    sides_.emplace_back(*this, config.topology.dsps[port], master_of(config, slot),
                        port == context_.window_a.front().port ? config.bridge_a : config.bridge_b);
  context_.adapter.join(chip_, clock_, plugged);
  if (config.instant_access)
    chip_.set_window_listener(&instant_answers_);
  else
    chip_.set_window_listener(this);
  attach(context_.adapter.dsp_port(), context_.adapter.link(slot_), 1, adapter_wire_);
  if (!plugged) {
    chip_.hold(true);
  } else if (config.boot == Boot::preloaded) {
    load();
  } else {
    hold_in_reset(Time{0});
  }
  set_next();
}

void Dsp::set_next() {
  plan();
  // The chip's accesses may have changed the next event of links.
  adapter_wire_.changed();
  for (std::size_t i = 1; i < wires_.size(); ++i) wires_[i].actor.changed();
}

void Dsp::plan() {
  next_ = std::min(own_next_, std::min(edge_, reset_));
  if (wires_.size() > 1 || !nets_out_.empty()) [[unlikely]]
    next_ = std::min(next_, next_of_links_and_pins());
  changed();
}

Time Dsp::next_of_links_and_pins() const {
  return std::min(dma_continues() ? clock_.at(chip_.settled()) : never, next_pin_event());
}

void Dsp::attach(int port, c40::Link& link, int side, Scheduler::Actor& wire) {
  wires_.push_back({port, link, side, wire});
  chip_.attach(port, &link.listener(side));
}

void Dsp::act(Time now) {
  if (reset_ <= now) {
    reset_ = never;
    reset(now);
  }
  if (edge_ <= now) deliver_edge(now);
  if (own_next_ <= now) {
    switch (state_) {
      case State::running: run(horizon()); break;
      case State::access: begin_access(horizon()); break;
      case State::port: begin_port_access(now, horizon()); break;
      case State::resuming: complete(horizon()); break;
      case State::faulting: report_fault(now); break;
      case State::booting: leave_reset(now); break;
      case State::out:
      case State::blocked:
      case State::idle:
      case State::dead: own_next_ = never; break;
    }
  } else if (dma_continues()) {
    run_dma(horizon());
  }
  if (next_pin_event() <= now) chip_.let_peripherals_reach(clock_.tick_at_or_after(now));
  set_next();
}

void Dsp::run_ahead(Time until) {
  run(until);
  set_next();
}

// A chip whose ports can interrupt it, or move its DMA, follows its link step by step; so does a chip with a net at its
// pins.
c40::Cycles Dsp::limit_by_links(c40::Cycles far) const {
  Time reach = nets_reach();
  if (!chip_.watches_ports()) return std::min(far, reach == never ? far : clock_.tick_at_or_after(reach));
  const Time own = clock_.at(chip_.settled());  // effects of its own DMA come back over the link, too
  for (const Wire& wire : wires_) {
    // The adapter's end acts together with the host, which the horizon includes; another DSP's end may act at any time
    // from now on.
    const Time from = &wire == &wires_.front() ? own : std::min(own, context_.scheduler.earliest());
    reach = std::min({reach, wire.actor.next(), from + wire.link.lookahead()});
  }
  return std::min(far, clock_.tick_at_or_after(reach));
}

// Leaves the chip at `until`, idle, before an access that has to wait for its turn, or in a fault.
void Dsp::run(Time until) {
  state_ = State::running;
  dma_waits_ = false;
  run_end_ = std::min({until, edge_, reset_});
  if (!nets_in_.empty()) [[unlikely]]
    run_end_ = std::min(run_end_, nets_reach());
  run_chip(chip_);
}

std::optional<ChipRunner::Span> Dsp::span() {
  if (edge_waiting_ || hang_waiting_ || !pins_waiting_.empty()) return Span{.one_instruction = true};
  if (chip_.dormant()) {
    state_ = State::idle;
    own_next_ = never;
    return {};
  }
  const c40::Cycles limit = this->limit(run_end_);
  if (chip_.cycle() < limit) return Span{.limit = limit, .known = limit};
  if (chip_.settled() < limit && chip_.watches_ports()) return Span{.limit = 0, .known = limit};  // its DMA is behind
  own_next_ = clock_.at(chip_.cycle());
  return {};
}

// Between two instructions: handles edges that came in the middle of an instruction.
bool Dsp::at_limit() {
  if (std::exchange(edge_waiting_, false)) chip_.raise_iiof(0);
  for (const PinChange& change : pins_waiting_) chip_.set_pin(change.pin, change.level, chip_.cycle());
  pins_waiting_.clear();
  if (std::exchange(hang_waiting_, false)) go_astray();
  return true;
}

bool Dsp::port_access(const c40::PortAccess& access) {
  port_access_ = access;
  state_ = State::port;
  own_next_ = clock_.at(access.cycle);
  return false;
}

bool Dsp::port_wait(const c40::PortAccess& access) {
  fault(access.cycle, chip_.pc(), access.address,
        fmt::format("{} waits forever: nothing is attached to the port", describe(access)));
  return false;
}

bool Dsp::faulted(const c40::Fault& why) {
  fault(why.cycle, why.pc, why.address, why.message);
  return false;
}

// Nothing outside may act on the chip before the horizon up to which it has run.
void Dsp::require_not_run_past([[maybe_unused]] Time now) const {
  assert(run_end_ <= now && "a chip was run past what acts on it");
}

void Dsp::schedule_edge(Time time) {
  require_not_run_past(time);
  edge_ = time;
  set_next();
}

void Dsp::schedule_reset(Time time) {
  require_not_run_past(time);
  reset_ = time;
  set_next();
}

// An edge during an access is seen when the instruction has ended.
void Dsp::deliver_edge(Time now) {
  edge_ = never;
  if (caught_up(now)) {
    chip_.raise_iiof(0);
    state_ = State::running;
    own_next_ = clock_.at(chip_.cycle());
  }
  switch (state_) {
    case State::running:
    case State::idle: break;
    case State::access:
    case State::port:
    case State::blocked:
    case State::resuming: edge_waiting_ = true; break;
    case State::out:
    case State::booting:
    case State::faulting:
    case State::dead: return;
  }
  if (context_.observer != nullptr) context_.observer->interrupt(slot_, 0, now);
}

// Runs to between two instructions at `now`; false if an access is under way, or no program runs.
bool Dsp::caught_up(Time now) {
  if (state_ == State::running || state_ == State::idle) {
    settle(now);
    if (state_ == State::running) run(now);
  }
  if (state_ != State::running && state_ != State::idle) return false;
  settle(now);
  return true;
}

// Real code: BR to itself in the last word of the board's first RAM, GIE off, and RM off, because under RPTS no branch
// is allowed. The present instruction has ended.
void Dsp::go_astray() {
  const auto& ram = *std::ranges::find(context_.config.board.regions, c40::Region::Kind::ram, &c40::Region::kind);
  const auto trap = static_cast<c40::Address>(ram.base + ram.words - 1);
  constexpr Word branch_to_itself = 0x60FFFFFF;  // BR, displacement -1
  constexpr std::uint64_t gie = 0x2000, rm = 0x100;
  chip_.poke(trap, branch_to_itself);
  chip_.set_register(isa::Register::ST, chip_.register_value(isa::Register::ST) & ~(gie | rm));
  chip_.set_pc(trap);
}

void Dsp::hang(Time now) {
  require_not_run_past(now);
  if (caught_up(now)) {
    go_astray();
    state_ = State::running;
    own_next_ = clock_.at(chip_.cycle());
  } else if (in_access() || in_reset()) {
    hang_waiting_ = true;
  }
  set_next();
}

void Dsp::look_again(Time now) {
  if (state_ != State::idle) return;
  chip_.stand_until(clock_.tick_at_or_after(now), c40::Cause::idle);
  if (chip_.dormant()) return;
  state_ = State::running;
  own_next_ = clock_.at(chip_.cycle());
  set_next();
}

void Dsp::settle(Time now) {
  switch (state_) {
    case State::out:
    case State::booting:
    case State::idle:
    case State::dead: chip_.run_until(clock_.tick_at_or_after(now)); break;
    default: break;
  }
}

Spent Dsp::spent(Time now) const {
  Spent spent{chip_.cycle(), chip_.causes(), statistics_.window_b_arbitration, statistics_.window_b_transfer};
  const auto since = [&](c40::Cycles cycle) { return std::max<c40::Cycles>(0, clock_.tick_at_or_after(now) - cycle); };
  const auto add = [&spent](c40::Cause cause, c40::Cycles cycles) {
    spent.causes[static_cast<std::size_t>(cause)] += cycles;
    spent.cycles += cycles;
  };
  if (state_ == State::port) add(c40::Cause::comm_port, since(port_access_.cycle));
  if (state_ != State::blocked && state_ != State::resuming) return spent;
  const c40::Cycles waited = since(access_.cycle);
  // Until the bridge has its answer, the access waits for the bus.
  const c40::Cycles arbitration = state_ == State::blocked ? waited : std::min(waited, arbitration_);
  const c40::Cycles transfer = state_ == State::blocked ? 0 : std::min(waited - arbitration, transfer_);
  add(c40::Cause::bus_arbitration, arbitration);
  add(c40::Cause::bus_transfer, transfer);
  if (window_of(access_.address) == Window::b) {
    spent.window_b_arbitration += arbitration;
    spent.window_b_transfer += transfer;
  }
  return spent;
}

void Dsp::stand_still(Time now) {
  require_not_run_past(now);
  settle(now);
  chip_.hold(true);
  own_next_ = never;
  edge_waiting_ = hang_waiting_ = false;
  for (const PinChange& change : pins_waiting_) chip_.set_pin(change.pin, change.level, chip_.cycle());
  pins_waiting_.clear();
  context_.in_reset -= in_reset();
  state_ = State::dead;
}

void Dsp::fail(Time now) {
  freeze(now);
  broken_ = true;
}

void Dsp::freeze(Time now) {
  if (state_ == State::out) return;
  stand_still(now);
  set_next();
}

// The present cycle, or the access before which the chip stopped, is the last one of the old clock.
void Dsp::pace(Time now, std::int64_t parts_per_million) {
  if (state_ == State::out) return;
  require_not_run_past(now);
  settle(now);
  Ticks reached = std::max(clock_.tick_at_or_after(now), chip_.cycle());
  if (state_ == State::access) reached = std::max(reached, access_.cycle);
  if (state_ == State::port) reached = std::max(reached, port_access_.cycle);
  const std::int64_t ppm = slot_ < context_.config.chip_skews.size() ? context_.config.chip_skews[slot_].ppm : 0;
  constexpr std::int64_t million = 1'000'000;
  std::int64_t above = context_.config.chip_hz, below = context_.config.chip_hz_denominator;
  if (parts_per_million != million) {
    // In whole hertz: a finer fraction, with a deviation in ppm on top, would be no clock.
    above = std::max<std::int64_t>(1, (above * parts_per_million + million * below / 2) / (million * below));
    below = 1;
  }
  clock_.change(reached, Skew{ppm, Time{0}}, above, below);
  for (const Wire& wire : wires_) wire.link.set_clock(wire.side, clock_);
  if (state_ == State::resuming) own_next_ = clock_.at(access_.cycle + arbitration_ + transfer_);
  set_next();
}

void Dsp::list_state(state::Visitor& list) {
  list("clock", clock_);
  list("chip", chip_);
  list("sides", sides_);
  list("underway", underway_);
  list("state", state_);
  list("broken", broken_);
  list("answered", answered_);
  list("edge waiting", edge_waiting_);
  list("hang waiting", hang_waiting_);
  list("pins waiting", pins_waiting_);
  list("next", next_);
  list("own next", own_next_);
  list("edge", edge_);
  list("reset", reset_);
  list("access", access_);
  list("port access", port_access_);
  list("answer", answer_);
  list("arbitration", arbitration_);
  list("transfer", transfer_);
  list("dma waits", dma_waits_);
  list("fault", fault_);
  list("statistics", statistics_);
  if (list.loads()) run_end_ = Time{0}, refused_ = -1;  // still from the run before
}

void Dsp::append_state(std::vector<std::uint64_t>& words) const {
  for (unsigned code = 0; code < 32; ++code) words.push_back(chip_.register_value(static_cast<isa::Register>(code)));
  words.push_back(chip_.pc());
  words.push_back(static_cast<std::uint64_t>(chip_.cycle()));
  words.push_back(chip_.instructions());
  for (const c40::Cycles cycles : chip_.causes()) words.push_back(static_cast<std::uint64_t>(cycles));
  for (c40::Address address = c40::on_chip_ram; address < c40::on_chip_ram + 2 * c40::on_chip_block_words; ++address)
    words.push_back(chip_.peek(address));
  words.push_back(static_cast<std::uint64_t>(state_));
  words.push_back(statistics_.posted_writes);
  words.push_back(statistics_.bus_reads);
  words.push_back(statistics_.prefetch_hits);
  words.push_back(statistics_.dropped_writes);
}

void Dsp::fault(c40::Cycles cycle, std::uint32_t pc, std::uint32_t address, std::string what) {
  fault_ =
      ChipFault{.slot = slot_, .time = clock_.at(cycle), .cycle = cycle, .pc = pc, .address = address, .message = {}};
  fault_.message = fmt::format("DSP {} at PC {:08X}h, cycle {}, address {:08X}h: {}", slot_, pc, cycle, address, what);
  state_ = State::faulting;
  own_next_ = fault_.time;
  set_next();
}

void Dsp::report_fault(Time now) {
  chip_.hold(true);
  state_ = State::dead;
  own_next_ = never;
  settle(now);
  context_.faults.push_back(fault_);
  if (context_.observer != nullptr) context_.observer->fault(context_.faults.back());
}

}  // namespace machine
