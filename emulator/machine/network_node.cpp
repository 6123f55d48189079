// One chip of a network: how it advances in time, and its status.
#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "c40/float40.hpp"
#include "machine/asleep.hpp"
#include "machine/network_parts.hpp"
#include "machine/program_end.hpp"

namespace machine {

using c40::Address;
using c40::Chip;
using c40::Cycles;
using c40::StopInfo;
using c40::Word;

namespace {
constexpr Cycles no_cycle = std::numeric_limits<Cycles>::max();

/// One of its timers could interrupt the chip.
bool awaits_timer(const Chip& chip) { return next_timer_interrupt(chip) != no_cycle; }

/// IDLE sets GIE.
bool can_interrupt(const Chip& chip) {
  return chip.idle() || (chip.register_value(isa::Register::ST) & c40::st::GIE) != 0;
}
}  // namespace

// ---- its turns ----

Time Network::Node::next() const {
  switch (status) {
    case ChipStatus::running:
      if (patience.is_private) return never;
      return follows() || (chip.dma_active() && !nets_out.empty()) ? now() : clock.at(chip.cycle());
    case ChipStatus::waiting: {
      if (!chip.dma_active()) return std::min(access_time(), next_pin_event());
      const Time next = std::min({access_time(), own_event(), next_pin_event()});
      return follows() ? std::min(next, now()) : next;
    }
    case ChipStatus::sleeping: return std::min(own_event(), next_pin_event());
    default: return next_pin_event();
  }
}

/// Changes by its timers of pins that drive nets, while no instruction executes.
Time Network::Node::next_pin_event() const {
  if (nets_out.empty() || chip.halted()) return never;
  const Cycles event = chip.next_event();
  return event == no_cycle ? never : clock.at(event);
}

bool Network::Node::only_drives_unheard() const {
  if (std::ranges::any_of(nets_out, &Net::is_heard)) return false;
  return own_event() == never && access_time() == never && !follows();
}

/// A chip that follows its ports runs no further than the earliest effect on it. The check for a loop takes place in a
/// certain cycle, wherever the chip has stopped before.
Time Network::Node::horizon() const { return follows() ? horizon_of_follower() : horizon_on_its_own(); }

Time Network::Node::horizon_on_its_own() const {
  // A polling chip runs on to where others could see it, wherever it has stopped before.
  const Time limit =
      patience.loop ? network.scheduler_.limit() : std::min(network.scheduler_.limit(), network.ends_at_);
  const Cycles action = network.next_action_on(*this);
  return action == no_cycle ? limit : std::min(limit, clock.at(action));
}

Time Network::Node::horizon_of_follower() const {
  const Time outside = std::min(
      {network.scheduler_.limit(), network.ends_at_, network.next_action(), next_device_event(), others_reach_it()});
  if (status != ChipStatus::running) return std::min(outside, access_time());
  // run_to lets it begin an instruction in the last cycle: so in the one before the check
  const Cycles look = std::max(patience.next_look(), chip.cycle() + 1);
  return std::min(outside, clock.at(chip.idle() ? look : look - 1));
}

/// Limited by what is on its links and nets, or by what any chip may do from now on. If all others wait, they only
/// react to what it does itself; an access to a link stops it, and its pins' next event is known. In a loop it stays
/// near the others: the network's end may be near (Network::at_rest_since).
Time Network::Node::others_reach_it() const {
  const bool others_wait = !patience.loop && network.scheduler_.earliest_of_others(*this) == never;
  const Time first = others_wait ? next_pin_event() : network.scheduler_.earliest(), ahead = lookahead();
  Time reach = first < never - ahead ? first + ahead : never;
  for (const std::size_t link : links) reach = std::min(reach, network.links_[link]->next_event());
  for (const Net* net : nets_in) reach = std::min(reach, net->reaches(number));
  const Cycles last = last_before_devices();
  return last == no_cycle ? reach : std::min(reach, clock.at(last + 1));
}

/// The least time after which an action of another chip reaches this one.
Time Network::Node::lookahead() const {
  Time ahead = never;
  for (const std::size_t link : links) ahead = std::min(ahead, network.links_[link]->lookahead());
  return ahead;
}

void Network::Node::act(Time now) {
  network.now_ = now;
  const bool on_its_own = status == ChipStatus::running && !follows();
  if (status == ChipStatus::sleeping)
    bring_to(now, false);
  else if (!on_its_own)
    go_on_with_others(now);
  if (next_pin_event() <= now) drive_on(now);
  look_for_loop();
  if (on_its_own || (status == ChipStatus::running && !follows())) run_freely(horizon_on_its_own());
  if (!on_its_own || !network.actions_.empty()) tell_changes();
}

/// It waits, or follows its ports: continues as far as they are known, or does its access.
void Network::Node::go_on_with_others(Time now) {
  if (status != ChipStatus::waiting || chip.dma_active()) {
    const auto stands = std::tuple{chip.settled(), chip.cycle(), status};
    if (own_event() == now || (chip.dma_active() && next_pin_event() == now))
      run_to(std::min(horizon_of_follower(), clock.at(first_cycle(now) + 1)), last_before_devices());
    else if (follows())
      run_to(horizon_of_follower(), last_before_devices());
    if (stands != std::tuple{chip.settled(), chip.cycle(), status}) return;
  }
  if (next_pin_event() <= now) return;
  if (access_time() == now)
    waits_for_port()     ? network.perform_port(*this)
    : waits_for_device() ? network.perform_device(*this)
                         : network.perform_memory(*this);
  else
    assert(next() > now && "a turn that changes nothing");
}

void Network::Node::run_ahead(Time until) {
  if (follows()) {
    run_to(until, last_before_devices());
    look_for_loop();
  } else {
    run_freely(until);
  }
  tell_changes();
}

void Network::Node::tell_changes() {
  for (const std::size_t link : links) network.link_turns_[link]->changed();
  if (!network.actions_.empty()) network.action_turn_->changed();
}

// Nothing outside can act on the chip before it stops by itself, so a loop in which it is found needs no check.
void Network::Node::run_freely(Time until) {
  const auto may_go_on = [&] { return status == ChipStatus::running && !follows() && !patience.is_private; };
  while (may_go_on()) {
    run_to(std::min(until, next_look()));
    look_for_loop();
    if (clock.at(chip.cycle()) >= until) return;  // its DMA may still be behind
  }
}

// ---- how it continues ----

/// A waiting chip continues with its DMA. Links are known up to `until`. A processor that follows its ports has begun
/// its last instruction by then: what a link does at that instant is an interrupt for the next instruction. So the
/// order of events does not depend on how a run is divided, and the DMA, which follows the processor's read stage, has
/// done everything before.
/// \param last the last cycle in which it may begin an instruction, whatever `until` is
void Network::Node::run_to(Time until, Cycles last) {
  passing_ = false;
  last_ = last;
  ends_ = first_cycle(until);
  action_ = network.next_action_on(*this);
  run_chip(chip);
}

/// To be called before something outside changes, at `time`, what the chip follows. Returns whether the chip has to
/// follow.
bool Network::Node::come_to(Time time) {
  if (status == ChipStatus::waiting && !chip.dma_active()) return false;
  const bool goes_on = follows() || (status == ChipStatus::waiting && dma_waits());
  if (status != ChipStatus::sleeping && !goes_on) return false;
  if (goes_on)
    run_to(time);
  else
    bring_to(time, true);
  return true;
}

std::optional<ChipRunner::Span> Network::Node::span() {
  if (std::exchange(over_breakpoint_, false))
    return Span{.limit = chip.cycle() + 1, .known = std::min(span_.known, chip.cycle() + 1)};
  cycle_before_ = chip.cycle(), settled_before_ = chip.settled();
  return passing_ ? span_ : span_of_runner();
}

std::optional<ChipRunner::Span> Network::Node::span_of_runner() {
  const bool waits = status == ChipStatus::waiting, idles = chip.idle();
  const Cycles known = std::min(ends_, std::max(chip.cycle(), action_));
  // Only here it is known whether the chip still follows its ports.
  const bool begins_last = chip.cycle() >= ends_ && ends_ <= last_ && !waits && !idles && watches();
  Cycles limit = std::min(ends_ + (begins_last ? 1 : 0), action_);
  const bool timers_behind = chip.dma_active() && chip.next_event() <= std::min(known, chip.settled());
  if (chip.settled() >= known && !timers_behind && (waits || chip.cycle() >= limit)) {
    note_idle();
    return {};
  }
  if (!waits && chip.cycle() >= action_)
    return span_ = Span{.limit = 0, .known = known};  // the processor waits for the action
  // An idle processor may have ended when its DMA is done, or when a timer's event was not for it: in that cycle.
  const bool looks = status == ChipStatus::running && idles;
  if (looks && chip.dma_busy())
    limit = std::min(limit, chip.cycle() + 1);
  else if (looks && awaits_timer(chip))
    limit = std::min(limit, std::max(chip.cycle() + 1, next_timer_interrupt(chip)));
  return span_ = Span{.limit = limit, .known = std::min(known, limit)};
}

bool Network::Node::at_limit() {
  if (passing_) return has_moved() && passes_on();
  note_idle();
  return status == ChipStatus::running && has_moved();
}

bool Network::Node::asks_anew() {
  if (passing_) return passes_on();
  note_idle();
  return false;
}

/// Returns whether the chip continues.
bool Network::Node::at_breakpoint() {
  over_breakpoint_ = true;
  if (passing_) return true;
  if (description.until == chip.pc()) {
    status = ChipStatus::until;
  } else if (program_end(chip.peek(chip.pc()), chip.pc()) == ProgramEnd::halt && !chip.dma_busy()) {
    if (chip.dma_active() || (chip.watches_ports() && can_interrupt(chip)) || heeds_pins())
      status = ChipStatus::sleeping;
    else if (!can_interrupt(chip) || !awaits_timer(chip))
      status = ChipStatus::halt;
    asleep_since = chip.cycle();
  }
  return over_breakpoint_ = status == ChipStatus::running;
}

bool Network::Node::window_access(const c40::ExternalAccess& access) {
  const bool in_order = devices != nullptr && devices->acts_on_others(access.address);
  if (!in_order && devices != nullptr && devices->has(access.address)) return serve_device(access);
  if (!in_order && ignored.serve(chip, access)) return true;
  const bool waits = in_order || network.memory_of(*this, access.address) != nullptr;
  status = waits ? ChipStatus::waiting : ChipStatus::external_access;
  stop = {};
  stop.reason = StopInfo::Reason::external_access;
  stop.access = access;
  return false;
}

bool Network::Node::waits(StopInfo::Reason why, const c40::PortAccess& access) {
  if (passing_) return passes_on();
  if (waits_for_port()) return false;  // no change
  status = ChipStatus::waiting;
  stop = {};
  stop.reason = why;
  stop.port = access;
  was_ready = false;
  note_ready(Time{0});
  return false;
}

bool Network::Node::faulted(const c40::Fault& why) {
  status = ChipStatus::fault;
  forget_port();
  stop = {};
  stop.reason = StopInfo::Reason::fault;
  stop.fault = why;
  return false;
}

/// The chip waits for no port any more.
void Network::Node::forget_port() { was_ready = false, ready_since = Time{0}; }

void Network::Node::note_idle() {
  if (!chip.idle() || chip.dma_busy() || status != ChipStatus::running) return;
  if (chip.watches_ports() || chip.dma_active() || heeds_pins())
    status = ChipStatus::sleeping;
  else if (!awaits_timer(chip))
    status = ChipStatus::idle;
}

/// Advances a chip that does not run to an instant. `fully`: a processor that branches to itself has begun its last
/// branch by then, as a running one has begun its last instruction (run_to).
void Network::Node::bring_to(Time time, bool fully) {
  const Cycles cycle = first_cycle(time);
  if (status != ChipStatus::sleeping && !fully && chip.cycle() >= cycle) return;
  if (status == ChipStatus::running)
    run_to(time);
  else if (status != ChipStatus::sleeping) {
    chip.stand_until(cycle);
  }
  while (status == ChipStatus::sleeping) {
    const Cycles limit = cycle + (fully && !chip.idle() ? 1 : 0), event = own_event_cycle();
    pass_to(std::min(limit, event), std::min(cycle, event));
    if (status != ChipStatus::sleeping) return;
    wake_up();  // an event during the last pass of the loop may wake it
    if (event >= limit) return;
    if (status == ChipStatus::running)
      run_to(time);  // it may sleep again
    else if (own_event_cycle() == event)
      return pass_to(limit, cycle);
  }
}

/// Advances a sleeping chip that stays asleep.
void Network::Node::pass_to(Cycles limit, Cycles known) {
  passing_ = true;
  span_ = {.limit = limit, .known = known};
  run_chip(chip);
}

void Network::Node::wake_up() {
  if (status == ChipStatus::sleeping && wakes()) status = ChipStatus::running;
}

// ---- its status ----

/// For a sleeping chip: it has something to do.
bool Network::Node::wakes() const { return chip.dma_busy() || chip.interrupt_pending(); }

bool Network::Node::ready() const {
  if (waits_for_port())
    return stop.reason == StopInfo::Reason::port_access && stop.port.ready(chip.port(stop.port.port));
  if (waits_for_device()) return true;
  const Memory& memory = *network.memory_of(*this, stop.access.address);
  return !memory.owner || *memory.owner == number;
}

bool Network::Node::note_ready(Time time) {
  if (!waits_for_port()) return false;
  const bool now = ready(), changes = now != was_ready;
  if (now && changes) ready_since = time;
  was_ready = now;
  return changes;
}

/// When the access for which it waits takes place, as far as known.
Time Network::Node::access_time() const {
  if (status != ChipStatus::waiting) return never;
  // Only a link, or the chip's own DMA, makes a port ready.
  if (waits_for_port() && !chip.dma_active() ? !was_ready : !ready()) return never;
  const Time free = waits_for_port() ? ready_since
                    : waits_for_device()
                        ? Time{0}
                        : network.memory_of(*this, stop.access.address)->free_for(number, stop.access.address);
  return clock.at(
      std::max(waits_for_port() ? stop.port.cycle : stop.access.cycle, first_cycle(std::max(free, network.now_))));
}

/// The cycle of a timer's effect on a sleeping or waiting chip; events without a listener do not count.
Cycles Network::Node::own_event_cycle() const {
  const bool sleeps = status == ChipStatus::sleeping;
  if (!sleeps && status != ChipStatus::waiting) return no_cycle;
  const Cycles event = chip.dma_active() ? next_dma_tick(chip) : no_cycle;
  return sleeps && can_interrupt(chip) ? std::min(event, next_timer_interrupt(chip)) : event;
}

Time Network::Node::own_event() const {
  if (status != ChipStatus::sleeping && !chip.dma_active()) return never;
  const Cycles event = own_event_cycle();
  return event == no_cycle ? never : clock.at(event);
}

/// When the chip came to rest by its own actions, not how far it has been advanced since.
Time Network::Node::at_rest_since() const {
  if (patience.loop) return patience.found;
  switch (status) {
    case ChipStatus::held:
    case ChipStatus::pulled_out: return Time{0};
    case ChipStatus::waiting:
      return clock.at(std::max(waits_for_port() ? stop.port.cycle : stop.access.cycle, chip.dma_done()));
    case ChipStatus::sleeping:
      return clock.at(std::max(chip.idle() ? chip.idle_since() : asleep_since, chip.dma_done()));
    case ChipStatus::fault:
      return clock.at(
          std::max(chip.cycle(), stop.fault->cycle));  // perhaps a fault of its DMA, while the processor waited
    case ChipStatus::external_access: return clock.at(std::max(chip.cycle(), stop.access.cycle));
    default: return clock.at(chip.cycle());
  }
}

/// The processor has ended; a DMA without effect on it may still be armed.
bool Network::Node::has_ended() const {
  switch (status) {
    case ChipStatus::halt:
    case ChipStatus::idle:
    case ChipStatus::until:
    case ChipStatus::fault:
    case ChipStatus::external_access:
    case ChipStatus::pulled_out: return true;
    case ChipStatus::sleeping: return dma_waits() && !sleeps_for_interrupt();
    default: return false;
  }
}

/// The interrupt of a port, a timer or the DMA.
bool Network::Node::sleeps_for_interrupt() const {
  constexpr Word ports = 0x01FFFFFEu;  // in IIE
  return heeds_pins() || (can_interrupt(chip) && (awaits_dma(chip) || awaits_timer(chip) ||
                                                  (chip.register_value(isa::Register::IIE) & ports) != 0));
}

bool Network::Node::awaits_dma_for_ever() const {
  return status == ChipStatus::sleeping && dma_waits() && sleeps_for_interrupt() && awaits_dma(chip);
}

// ---- its pins ----

/// A change of the pin could interrupt the processor, or move its DMA or a timer that does.
bool Network::Node::heeds(c40::Pin pin) const {
  return pin != c40::Pin::reset && chip.heeds(pin) &&
         (pin == c40::Pin::nmi || chip.dma_active() || can_interrupt(chip));
}

bool Network::Node::heeds_pins() const {
  return std::ranges::any_of(pins_in, [&](c40::Pin pin) { return heeds(pin); });
}

Time Network::Node::drives_from() const {
  if (status == ChipStatus::running && !patience.is_private) return now();
  const bool over = has_ended() && nets_in.empty();
  return over ? next_pin_event() : std::min(next_pin_event(), network.scheduler_.earliest());
}

void Network::Node::driven(c40::Pin pin, c40::Drive drive, Cycles at) {
  const auto driven_by_it = [&](const Net* net) {
    return std::ranges::find(net->description().drivers, ChipPin{number, pin}) != net->description().drivers.end();
  };
  (*std::ranges::find_if(nets_out, driven_by_it))->driven({number, pin}, drive, std::max(network.now_, clock.at(at)));
}

bool Network::Node::hears(c40::Pin pin) const {
  if (pin == c40::Pin::reset) return status != ChipStatus::pulled_out;
  switch (status) {
    case ChipStatus::running: return true;
    case ChipStatus::waiting: return chip.dma_active() && chip.heeds(pin);
    case ChipStatus::sleeping: return heeds(pin);
    default: return false;
  }
}

/// Advances the chip while its timers change pins and no instruction executes.
void Network::Node::drive_on(Time now) {
  if (status == ChipStatus::waiting && !chip.dma_active())
    chip.let_peripherals_reach(first_cycle(now));
  else if (status != ChipStatus::running && status != ChipStatus::sleeping)
    chip.stand_until(first_cycle(now));
}

void Network::Node::pin_changes(c40::Pin pin, bool level, Time now) {
  if (network.now_ < now) network.now_ = now;
  if (status == ChipStatus::pulled_out) return;
  if (hears(pin)) network.something_happened(), network.changed_ = now;
  if (pin == c40::Pin::reset) {
    const auto kind = level ? NetworkAction::Kind::reset : NetworkAction::Kind::hold;
    if (!level || status == ChipStatus::held) network.schedule({.kind = kind, .time = now, .target = number});
    return;
  }
  come_to(now);
  chip.set_pin(pin, level, first_cycle(now));
  wake_up();
  changed();
  tell_changes();
}

// ---- loops that poll ----

/// Other chips can change the value at this address.
bool Network::Node::is_shared(Address address) const {
  if (network.memory_of(*this, address) != nullptr) return true;
  return c40::is_port_register(address) &&
         network.neighbour(*this, c40::port_access(address, false, 0, 0).port).has_value();
}

void Network::Node::begin_patience() {
  Patience& p = patience;
  p.looking.reset();
  p.loop.reset();
  p.since = first_cycle(network.happened_), p.length = Patience::first, p.happenings = network.happenings_;
  chip.set_trace(trace);
}

/// Checks from time to time whether the chip repeats a loop.
void Network::Node::look_for_loop() {
  Patience& p = patience;
  if (p.is_private) return;
  const bool alone = status == ChipStatus::running || (status == ChipStatus::waiting && ready());
  if (p.happenings != network.happenings_ || !alone) {
    begin_patience();
  } else if (!p.loop && chip.cycle() >= p.next_look()) {
    if (!p.looking) {
      p.looking.emplace(chip, trace);
    } else {
      if (!chip.dma_busy() && chip.next_event() == no_cycle) p.loop = p.looking->loop();
      const auto at_device = [&](Address a) { return devices != nullptr && devices->has(a); };
      if (p.loop && devices != nullptr && devices->goes_on() && std::ranges::any_of(p.loop->reads, at_device))
        p.loop.reset();
      p.found = clock.at(chip.cycle());
      p.is_private = p.loop && !follows() &&
                     std::none_of(p.loop->reads.begin(), p.loop->reads.end(), [&](Address a) { return is_shared(a); });
      p.looking.reset();
      p.length *= Patience::growth;
    }
  }
  chip.set_trace(p.looking ? &*p.looking : trace);
}

}  // namespace machine
