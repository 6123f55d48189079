#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <tuple>

#include "io/stop.hpp"
#include "isa/decode.hpp"
#include "machine/asleep.hpp"
#include "machine/chip_stop.hpp"
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

/// A timer of its own could interrupt it.
bool awaits_timer(const Chip& chip) { return next_timer_interrupt(chip) != no_cycle; }

/// IDLE sets GIE.
bool can_interrupt(const Chip& chip) { return chip.idle() || (chip.register_value(isa::Register::ST) & c40::st::GIE) != 0; }

bool is_sigi(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  return instruction != nullptr && instruction->row->mnemonic == "sigi";
}
}  // namespace

// ---- building ----

Network::Network(NetworkDescription description, std::uint64_t turn_order) : description_(std::move(description)) {
  NetworkDescription& d = description_;
  if (d.chips.empty() || d.chips.size() > most_chips)
    throw NetworkError(fmt::format("a network of {} chips; 1 to {} are possible", d.chips.size(), most_chips));
  for (NetworkChip& chip : d.chips) {
    const std::size_t n = nodes_.size();
    if (chip.name.empty()) chip.name = fmt::format("{}", n);
    const double mhz = chip.clock_mhz ? *chip.clock_mhz : chip.board.clock_mhz.value_or(default_clock_mhz);
    if (!(mhz >= 0.001 && mhz <= 1000)) throw NetworkError(fmt::format("chip {}: a clock of {} MHz; 0.001 to 1000 are possible", n, mhz));
    nodes_.push_back(std::make_unique<Node>(n, chip, Clock{instruction_cycles_per_second(mhz)}));
  }
  join_links();
  add_memories();
  for (auto& node : nodes_) {
    load(*node);
    turns_.push_back(node.get());
  }
  if (turn_order != 0) {
    std::mt19937_64 random{turn_order};
    for (std::size_t i = turns_.size(); i > 1; --i) std::swap(turns_[i - 1], turns_[random() % i]);
  }
  const auto given = std::move(d.actions);
  for (const NetworkAction& action : given) schedule(action);
}

Network::~Network() = default;

void Network::join_links() {
  std::map<PortName, std::string> taken;
  for (const NetworkLink& given : description_.links) {
    const std::string name = machine::to_text(given);
    std::array<c40::Link::Side, 2> sides;
    for (std::size_t i = 0; i < 2; ++i) {
      const PortName& end = i == 0 ? given.a : given.b;
      if (end.chip >= nodes_.size()) throw NetworkError(fmt::format("link {}: there is no chip {}; the network has {}", name, end.chip, nodes_.size()));
      if (end.port < 0 || end.port >= c40::port_count)
        throw NetworkError(fmt::format("link {}: chip {} has no port {}; 0 to {} are possible", name, end.chip, end.port, c40::port_count - 1));
      Node& node = *nodes_[end.chip];
      sides[i] = {fmt::format("chip {} port {}", end.chip, end.port), end.port, &node.chip.port(end.port), PacedClock{node.clock}};
    }
    for (const PortName& end : {given.a, given.b})
      if (const auto other = taken.find(end); other != taken.end() && given.a != given.b)
        throw NetworkError(fmt::format("link {}: port {} of chip {} is taken by link {}; a port has one link", name, end.port, end.chip, other->second));
    taken.emplace(given.a, name), taken.emplace(given.b, name);
    const std::size_t number = links_.size();
    try {
      links_.push_back(std::make_unique<c40::Link>(std::move(sides[0]), std::move(sides[1]), given.parameters));
    } catch (const std::invalid_argument& error) {
      throw NetworkError(fmt::format("link {}: {}", name, error.what()));
    }
    taps_.push_back(std::make_unique<LinkTap>(*this, number));
    links_.back()->listener_of_events = taps_.back().get();
    for (int side = 0; side < 2; ++side) {
      const PortName& end = side == 0 ? given.a : given.b;
      nodes_[end.chip]->chip.attach(end.port, &links_.back()->listener(side));
      std::vector<std::size_t>& links = nodes_[end.chip]->links;
      if (links.empty() || links.back() != number) links.push_back(number);
    }
  }
}

void Network::add_memories() {
  for (const SharedMemory& given : description_.memories) {
    if (given.words == 0 || given.words > 1u << 24) throw NetworkError(fmt::format("memory {}: {} words; 1 to {} are possible", given.name, given.words, 1u << 24));
    if (given.waits < 0 || given.waits > 1000) throw NetworkError(fmt::format("memory {}: {} wait states; 0 to 1000 are possible", given.name, given.waits));
    for (const auto& [chip, base] : given.places) {
      if (chip >= nodes_.size()) throw NetworkError(fmt::format("memory {}: there is no chip {}; the network has {}", given.name, chip, nodes_.size()));
      const auto& regions = nodes_[chip]->description.board.board.regions;
      const bool inside = std::any_of(regions.begin(), regions.end(), [&, at = base](const c40::Region& r) {
        return r.kind == c40::Region::Kind::external_window && at >= r.base && std::uint64_t{at} + given.words <= r.base + r.words;
      });
      if (!inside)
        throw NetworkError(fmt::format("memory {}: the board of chip {} has no window that holds {} words from {:08X}h; a region with kind = \"window\" is expected there",
                                       given.name, chip, given.words, base));
      if (memory_of(*nodes_[chip], base) != nullptr || memory_of(*nodes_[chip], base + given.words - 1) != nullptr)
        throw NetworkError(fmt::format("memory {}: chip {} has another memory at {:08X}h", given.name, chip, base));
    }
    memories_.push_back(std::make_unique<Memory>(Memory{given, std::vector<Word>(given.words), Time{0}, {}}));
  }
}

void Network::load(Node& node) {
  if (node.description.program == nullptr) {
    if (!node.description.boot) throw NetworkError(fmt::format("chip {} has no program, and does not boot", node.number));
    node.description.program = std::make_shared<toolchain::Image>();
  }
  const toolchain::Image& image = *node.description.program;
  node.chip.reset();
  const c40::Board& board = node.description.board.board;
  const bool from_ports = node.description.boot && reset_source(board) == ResetSource::ports;
  if (node.description.boot && !from_ports && reset_source(board) == ResetSource::memory) return load_stream(node, image, board);
  for (const toolchain::Image::Section& section : image.sections) {
    if (!section.loaded || from_ports) continue;
    try {
      node.chip.write_block(section.address, section.words);
    } catch (const std::out_of_range&) {
      throw NetworkError(fmt::format("chip {}: section {} ({} words at {:08X}h) does not lie in RAM of board {}; board flat has RAM everywhere", node.number,
                                     section.name, section.size, section.address, node.description.board.board.name));
    }
  }
  ready_to_start(node);
}

/// The pins choose a memory, and the program stands there as a boot stream.
void Network::load_stream(Node& node, const toolchain::Image& image, const c40::Board& board) {
  BootHeader header;
  header.global_interface_control = board.global_interface_control;
  header.local_interface_control = board.local_interface_control;
  try {
    node.chip.write_block(boot_address(board), boot_memory(image, header));
  } catch (const std::exception& error) {
    throw NetworkError(fmt::format("chip {}: board {}: the boot stream at {:08X}h, which the pins choose: {}", node.number, board.name, boot_address(board), error.what()));
  }
  ready_to_start(node);
}

void Network::ready_to_start(Node& node) {
  for (const Address end : program_ends(*node.description.program)) node.chip.add_breakpoint(end);
  if (node.description.until) node.chip.add_breakpoint(*node.description.until);
  start(node);
}

void Network::start(Node& node) {
  node.status = ChipStatus::running;
  if (node.description.boot) {
    try {
      return node.chip.boot();
    } catch (const std::out_of_range& error) {
      throw NetworkError(fmt::format("chip {}: {}", node.number, error.what()));
    }
  }
  node.chip.set_pc(node.description.entry.value_or(node.description.program->entry));
  const auto chips = static_cast<Word>(nodes_.size());
  const std::array<Word, 4> values{static_cast<Word>(node.number), chips, description_.shape[0] == 0 ? chips : description_.shape[0],
                                   description_.shape[0] == 0 ? 1 : description_.shape[1]};
  constexpr std::array registers{isa::Register::R0, isa::Register::R1, isa::Register::R2, isa::Register::R3};
  for (std::size_t i = 0; i < registers.size(); ++i)
    node.chip.set_register(registers[i], (node.chip.register_value(registers[i]) & ~std::uint64_t{0xFFFFFFFF}) | values[i]);
}

void Network::schedule(const NetworkAction& action) {
  const bool link = action.kind == NetworkAction::Kind::cut || action.kind == NetworkAction::Kind::restore;
  const std::size_t count = link ? links_.size() : nodes_.size();
  if (action.target >= count)
    throw NetworkError(fmt::format("{}: there is no {} {}; the network has {}", name(action.kind), link ? "link" : "chip", action.target, count));
  if (action.time < now_) throw NetworkError(fmt::format("{} at {} ps: the network has been run to {} ps already", name(action.kind), action.time.count(), now_.count()));
  actions_.insert(std::upper_bound(actions_.begin(), actions_.end(), action, [](const auto& a, const auto& b) { return a.time < b.time; }), action);
}

// ---- one chip ----

/// A chip that waits goes on with its DMA. What links do is known up to `until`. A processor that follows its ports has begun its
/// last instruction by then: what a link does at that instant is an interrupt for the next one. So the order of events is the
/// same wherever a run is cut, and the DMA, which follows the processor's read stage, has done all that lies before.
void Network::run_chip(Node& node, Time until) {
  const Chip& chip = node.chip;
  const Cycles ends = node.first_cycle(until), action = next_action_on(node);
  for (;;) {
    const bool waits = node.status == ChipStatus::waiting, idles = chip.idle();
    const Cycles known = std::min(ends, std::max(chip.cycle(), action));
    const bool over = !waits && chip.cycle() >= action;  // the processor does no more before the action
    const Cycles limit = std::min(ends + (!waits && !idles && chip.watches_ports() ? 1 : 0), action);
    if (chip.settled() >= known && (waits || chip.cycle() >= limit)) return note_idle(node);
    const Cycles before = chip.cycle(), settled = chip.settled();
    const StopInfo stop = over ? node.chip.run_until(0, known) : run_on(node, limit, known);
    if (over) stopped(node, stop);
    if (node.status != ChipStatus::running || meaning(stop.reason) == StopMeaning::asks_anew) return;
    if (chip.cycle() == before && chip.settled() == settled && meaning(stop.reason) == StopMeaning::limit) return;
  }
}

/// One call of the chip, and what comes of it.
StopInfo Network::run_on(Node& node, Cycles limit, Cycles known) {
  Chip& chip = node.chip;
  // A processor that idles may have ended when its DMA is done, or a timer's event was not for it: in that cycle.
  const bool looks = node.status == ChipStatus::running && chip.idle();
  if (looks && chip.dma_busy()) limit = std::min(limit, chip.cycle() + 1);
  else if (looks && awaits_timer(chip)) limit = std::min(limit, std::max(chip.cycle() + 1, next_timer_interrupt(chip)));
  const StopInfo stop = chip.run_until(limit, std::min(known, limit));
  if (meaning(stop.reason) != StopMeaning::breakpoint || at_breakpoint(node)) {
    stopped(node, stop);
    return stop;
  }
  const StopInfo after = chip.run_until(chip.cycle() + 1, std::min(known, chip.cycle() + 1));  // the instruction that it stopped at
  stopped(node, after);
  return after;
}

void Network::stopped(Node& node, const StopInfo& stop) {
  switch (meaning(stop.reason)) {
    case StopMeaning::breakpoint: return;
    case StopMeaning::fault:
      node.status = ChipStatus::fault;
      node.stop = stop;
      node.stop.fault = fault_of(node.chip, stop);
      return;
    case StopMeaning::window_access:
      node.status = memory_of(node, stop.access.address) != nullptr ? ChipStatus::waiting : ChipStatus::external_access;
      node.stop = stop;
      return;
    case StopMeaning::port_access:
    case StopMeaning::port_wait:
      if (node.waits_for_port()) return;  // still the same
      node.status = ChipStatus::waiting;
      node.stop = stop;
      node.was_ready = false;
      note_ready(node, Time{0});
      return;
    case StopMeaning::limit:
    case StopMeaning::asks_anew: break;
  }
  note_idle(node);
}

void Network::note_idle(Node& node) {
  if (!node.chip.idle() || node.chip.dma_busy() || node.status != ChipStatus::running) return;
  if (node.chip.watches_ports() || node.chip.dma_active()) node.status = ChipStatus::sleeping;
  else if (!awaits_timer(node.chip)) node.status = ChipStatus::idle;
}

/// Whether it stays there.
bool Network::at_breakpoint(Node& node) {
  const Chip& chip = node.chip;
  if (node.description.until == chip.pc()) {
    node.status = ChipStatus::until;
    return true;
  }
  if (program_end(chip.peek(chip.pc()), chip.pc()) != ProgramEnd::halt || chip.dma_busy()) return false;
  if (chip.dma_active() || (chip.watches_ports() && can_interrupt(chip))) node.status = ChipStatus::sleeping;
  else if (!can_interrupt(chip) || !awaits_timer(chip)) node.status = ChipStatus::halt;
  node.asleep_since = chip.cycle();
  return node.status != ChipStatus::running;
}

/// Lets a chip that does not run reach an instant; `fully`: a processor that branches to itself has begun its last branch by then, as
/// one that runs has begun its last instruction (run_chip).
void Network::bring_to(Node& node, Time time, bool fully) {
  const Cycles cycle = node.first_cycle(time);
  if (node.status != ChipStatus::sleeping && !fully && node.chip.cycle() >= cycle) return;
  if (node.status == ChipStatus::running) run_chip(node, time);
  else if (node.status != ChipStatus::sleeping) {
    const bool held = node.held();
    node.chip.hold(true);
    node.chip.run_until(cycle);
    node.chip.hold(held);
  }
  while (node.status == ChipStatus::sleeping) {
    const Cycles limit = cycle + (fully && !node.chip.idle() ? 1 : 0), event = own_event_cycle(node);
    pass_to(node, std::min(limit, event), std::min(cycle, event));
    if (node.status != ChipStatus::sleeping) return;
    if (wakes(node)) node.status = ChipStatus::running;  // perhaps by what happened in the loop's last round
    if (event >= limit) return;
    if (node.status == ChipStatus::running) run_chip(node, time);  // perhaps to sleep again
    else if (own_event_cycle(node) == event) return pass_to(node, limit, cycle);
  }
}

/// Lets a chip that sleeps go on sleeping.
void Network::pass_to(Node& node, Cycles limit, Cycles known) {
  do {
    const Cycles before = node.chip.cycle(), settled = node.chip.settled();
    StopInfo stop = node.chip.run_until(limit, known);
    if (meaning(stop.reason) == StopMeaning::breakpoint) stop = node.chip.run_until(node.chip.cycle() + 1, std::min(known, node.chip.cycle() + 1));
    const StopMeaning why = meaning(stop.reason);
    if (why == StopMeaning::fault || why == StopMeaning::window_access) stopped(node, stop);
    else if (why == StopMeaning::limit && node.chip.cycle() == before && node.chip.settled() == settled) return;
  } while (node.status == ChipStatus::sleeping && (node.chip.cycle() < limit || node.chip.settled() < known));
}

/// Of a chip that sleeps: it has something to do.
bool Network::wakes(const Node& node) const { return node.chip.dma_busy() || node.chip.interrupt_pending(); }

bool Network::ready(const Node& node) const {
  if (node.waits_for_port())
    return node.stop.reason == StopInfo::Reason::port_access && node.stop.port.ready(node.chip.port(node.stop.port.port));
  const Memory& memory = *memory_of(node, node.stop.access.address);
  return !memory.owner || *memory.owner == node.number;
}

void Network::note_ready(Node& node, Time time) {
  if (!node.waits_for_port()) return;
  const bool now = ready(node);
  if (now && !node.was_ready) node.ready_since = time;
  node.was_ready = now;
}

/// When the access that it waits for takes place, as far as can be said.
Time Network::access_time(const Node& node) const {
  if (node.status != ChipStatus::waiting || !ready(node)) return never;
  if (node.waits_for_port()) return node.clock.at(std::max({node.stop.port.cycle, node.first_cycle(node.ready_since), node.first_cycle(now_)}));
  return node.clock.at(std::max({node.stop.access.cycle, node.first_cycle(memory_of(node, node.stop.access.address)->free), node.first_cycle(now_)}));
}

// ---- what happens next ----

Time Network::effective(const NetworkAction& action) const {
  if (action.kind == NetworkAction::Kind::cut || action.kind == NetworkAction::Kind::restore) return action.time;
  const Node& node = *nodes_[action.target];
  return node.clock.at(std::max(node.chip.cycle(), node.first_cycle(action.time)));
}

/// To the chip itself: the cycle from which on it does nothing before it.
Cycles Network::next_action_on(const Node& node) const {
  Cycles next = no_cycle;
  for (const NetworkAction& a : actions_)
    if (a.target == node.number && a.kind >= NetworkAction::Kind::reset) next = std::min(next, node.first_cycle(a.time));
  return next;
}

Time Network::next_action() const {
  Time next = never;
  for (const NetworkAction& action : actions_) next = std::min(next, effective(action));
  return next;
}

Time Network::next_on_links(const Node& node) const {
  Time next = never;
  for (const std::size_t link : node.links) next = std::min(next, links_[link]->next_event());
  return next;
}

/// What a timer does to a chip that sleeps or waits; an event that nobody listens to is none.
Cycles Network::own_event_cycle(const Node& node) const {
  const bool sleeps = node.status == ChipStatus::sleeping;
  if (!sleeps && node.status != ChipStatus::waiting) return no_cycle;
  const Cycles event = node.chip.dma_active() ? next_dma_tick(node.chip) : no_cycle;
  return sleeps && can_interrupt(node.chip) ? std::min(event, next_timer_interrupt(node.chip)) : event;
}

Time Network::own_event(const Node& node) const {
  const Cycles event = own_event_cycle(node);
  return event == no_cycle ? never : node.clock.at(event);
}

/// When it came to rest, by what it did itself: not how far it has been brought since.
Time Network::at_rest_since(const Node& node) const {
  switch (node.status) {
    case ChipStatus::held:
    case ChipStatus::pulled_out: return Time{0};
    case ChipStatus::waiting:
      return node.clock.at(std::max(node.waits_for_port() ? node.stop.port.cycle : node.stop.access.cycle, node.chip.dma_done()));
    case ChipStatus::sleeping:
      return node.clock.at(std::max(node.chip.idle() ? node.chip.idle_since() : node.asleep_since, node.chip.dma_done()));
    case ChipStatus::running: return node.now();  // a loop that polls
    case ChipStatus::fault: return node.clock.at(std::max(node.chip.cycle(), node.stop.fault->cycle));  // perhaps of its DMA, while it waited
    case ChipStatus::external_access: return node.clock.at(std::max(node.chip.cycle(), node.stop.access.cycle));
    default: return node.clock.at(node.chip.cycle());
  }
}

Time Network::next_of(const Node& node) const {
  Time next = never;
  if (node.status == ChipStatus::waiting) next = std::min(access_time(node), own_event(node));
  else if (node.status == ChipStatus::sleeping) next = own_event(node);
  return node.follows_ports() ? std::min(next, node.now()) : next;
}

Time Network::next_of_all() const {
  Time next = next_action();
  for (const auto& link : links_) next = std::min(next, link->next_event());
  for (const auto& node : nodes_) next = std::min(next, next_of(*node));
  return next;
}

/// Nothing can happen any more, but for loops that go on as they do, tokens that go to and fro, and timers that nobody listens to. Or every
/// processor has ended, and only a DMA is armed.
bool Network::quiet() const {
  if (!actions_.empty()) return false;
  if (std::any_of(links_.begin(), links_.end(), [](const auto& link) { return link->next_event() != never && !link->only_exchanges_token(); })) return false;
  const auto still = [&](const auto& node) { return node->patience.loop || (node->status != ChipStatus::running && next_of(*node) == never); };
  return std::all_of(nodes_.begin(), nodes_.end(), still) || std::all_of(nodes_.begin(), nodes_.end(), [&](const auto& node) { return has_ended(*node); });
}

/// Its processor; a DMA that could do nothing for it may still be armed.
bool Network::has_ended(const Node& node) const {
  switch (node.status) {
    case ChipStatus::halt:
    case ChipStatus::idle:
    case ChipStatus::until:
    case ChipStatus::fault:
    case ChipStatus::external_access:
    case ChipStatus::pulled_out: return true;
    case ChipStatus::sleeping: return node.dma_waits() && !sleeps_for_interrupt(node);
    default: return false;
  }
}

/// By a port, a timer or the DMA.
bool Network::sleeps_for_interrupt(const Node& node) const {
  constexpr Word ports = 0x01FFFFFEu;  // of IIE
  return can_interrupt(node.chip) && (awaits_dma(node.chip) || awaits_timer(node.chip) || (node.chip.register_value(isa::Register::IIE) & ports) != 0);
}

bool Network::awaits_dma_for_ever(const Node& node) const {
  return node.status == ChipStatus::sleeping && node.dma_waits() && sleeps_for_interrupt(node) && awaits_dma(node.chip);
}

bool Network::waits_for_ever() const {
  return std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& node) {
    return (node->patience.loop ? polls(*node) : node->status == ChipStatus::waiting) || awaits_dma_for_ever(*node);
  });
}

NetworkStop Network::run_until(Time limit) {
  // After so long is asked whether to stop: a moment also for 64 chips of which each instruction is written.
  constexpr Time slice = std::chrono::microseconds{200};
  for (;;) {
    const NetworkStop stop = run_slice(std::min(limit, now_ + slice));
    if (stop.reason != NetworkStop::Reason::limit || now_ >= limit) return stop;
    if (io::stop_asked()) return {NetworkStop::Reason::interrupted, now_};
  }
}

NetworkStop Network::run_slice(Time limit) {
  while (true) {
    for (Node* node : turns_) {
      if (node->status != ChipStatus::running || node->follows_ports()) continue;
      const Cycles action = next_action_on(*node);
      run_freely(*node, action == no_cycle ? limit : std::min(limit, node->clock.at(action)));
    }
    for (auto& node : nodes_) watch(*node);
    const Time next = next_of_all();
    if (quiet()) return finish(waits_for_ever() ? NetworkStop::Reason::deadlock : NetworkStop::Reason::ended, limit);
    if (next >= limit) return finish(NetworkStop::Reason::limit, limit);
    if (advance_watchers(next, limit)) continue;
    now_ = next;
    links_happen(next);
    actions_happen(next);
    accesses_happen(next);
  }
}

// Nothing outside can do anything to it before it stops by itself, so a loop that it is found in can be left alone.
void Network::run_freely(Node& node, Time until) {
  const auto may_go_on = [&] { return node.status == ChipStatus::running && !node.follows_ports() && !node.patience.is_private; };
  while (may_go_on()) {
    run_chip(node, std::min(until, node.clock.at(std::max(node.patience.next_look(), node.chip.cycle() + 1))));
    watch(node);
    if (node.clock.at(node.chip.cycle()) >= until) return;  // its DMA may still be behind
  }
}

/// Others can change what is read there.
bool Network::is_shared(const Node& node, Address address) const {
  return memory_of(node, address) != nullptr || (c40::is_port_register(address) && neighbour(node, c40::port_access(address, false, 0, 0).port).has_value());
}

/// Looks from time to time whether the chip goes round a loop.
void Network::watch(Node& node) {
  Node::Patience& p = node.patience;
  if (p.is_private) return;
  const bool alone = node.status == ChipStatus::running || (node.status == ChipStatus::waiting && ready(node));
  if (p.happenings != happenings_ || !alone) {
    p.looking.reset();
    p.loop.reset();
    p.since = node.first_cycle(happened_), p.length = Node::Patience::first, p.happenings = happenings_;
  } else if (!p.loop && node.chip.cycle() >= p.next_look()) {
    if (!p.looking) {
      p.looking.emplace(node.chip, node.trace);
    } else {
      if (!node.chip.dma_busy() && node.chip.next_event() == no_cycle) p.loop = p.looking->loop();
      p.is_private = p.loop && !node.follows_ports() && std::none_of(p.loop->reads.begin(), p.loop->reads.end(), [&](Address a) { return is_shared(node, a); });
      p.looking.reset();
      p.length *= Node::Patience::growth;
    }
  }
  node.chip.set_trace(p.looking ? &*p.looking : node.trace);
}

// Those that ports can interrupt, up to the first instant at which something could. Whether one moved.
bool Network::advance_watchers(Time first, Time limit) {
  const Time action = next_action();
  bool moved = false;
  for (Node* node : turns_) {
    Time until = std::min(limit, action);
    if (own_event(*node) == first) {
      if (node->status == ChipStatus::sleeping) {
        bring_to(*node, first, false);
        moved = true;
        continue;
      }
      until = std::min(until, node->clock.at(node->first_cycle(first) + 1));
    } else if (!node->follows_ports()) {
      continue;
    }
    until = std::min(until, next_on_links(*node));
    Time lookahead = never;
    for (const std::size_t link : node->links) lookahead = std::min(lookahead, links_[link]->lookahead());
    if (first < never - lookahead) until = std::min(until, first + lookahead);
    until = std::min(until, access_time(*node));
    const auto stands = [&] { return std::tuple{node->chip.settled(), node->chip.cycle(), node->status}; };
    const auto before = stands();
    run_chip(*node, until);
    moved |= stands() != before;
  }
  return moved;
}

void Network::links_happen(Time time) {
  for (auto& link : links_) {
    if (link->next_event() > time) continue;
    const NetworkLink& ends = description_.links[static_cast<std::size_t>(&link - links_.data())];
    Node &a = *nodes_[ends.a.chip], &b = *nodes_[ends.b.chip];
    for (Node* node : {&a, &b}) {
      if (node->status == ChipStatus::sleeping) bring_to(*node, time, true);
      else if (node->status == ChipStatus::waiting && node->dma_waits()) run_chip(*node, time);
    }
    const bool passes_token = link->only_exchanges_token();
    link->advance_to(time);
    something_happened();
    if (!passes_token) changed_ = time;
    for (Node* node : {&a, &b}) {
      note_ready(*node, time);
      if (node->status == ChipStatus::sleeping && wakes(*node)) node->status = ChipStatus::running;
    }
  }
}

void Network::accesses_happen(Time time) {
  for (auto& node : nodes_) {
    if (access_time(*node) != time) continue;
    if (node->waits_for_port()) perform_port(*node);
    else perform_memory(*node);
  }
}

void Network::perform_port(Node& node) {
  for (const std::size_t link : node.links) links_[link]->advance_to(now_);
  node.chip.complete_port(node.first_cycle(now_));
  node.status = ChipStatus::running;
}

void Network::perform_memory(Node& node) {
  Memory& memory = *memory_of(node, node.stop.access.address);
  const c40::ExternalAccess& access = node.stop.access;
  const auto place = std::find_if(memory.description.places.begin(), memory.description.places.end(), [&](const auto& p) {
    return p.first == node.number && access.address - p.second < memory.description.words;
  });
  Word& word = memory.words[access.address - place->second];
  const Cycles cycle = node.first_cycle(now_);
  memory.free = node.clock.at(cycle + 1 + memory.description.waits);
  const auto owner = memory.owner;
  if (access.write && word != access.value) something_happened();
  if (access.interlocked && access.write) memory.owner.reset();
  else if (access.interlocked && !is_sigi(node.chip.peek(node.chip.pc()))) memory.owner = node.number;
  if (memory.owner != owner) something_happened();
  if (access.write) {
    word = access.value;
    node.chip.complete_write(cycle - access.cycle, memory.description.waits);
  } else {
    node.chip.complete_read(word, cycle - access.cycle, memory.description.waits);
  }
  node.status = ChipStatus::running;
}

Network::Memory* Network::memory_of(const Node& node, Address address) const {
  for (const auto& memory : memories_)
    for (const auto& [chip, base] : memory->description.places)
      if (chip == node.number && address - base < memory->description.words) return memory.get();
  return nullptr;
}

// ---- actions ----

void Network::actions_happen(Time time) {
  for (std::size_t i = 0; i < actions_.size();) {
    if (effective(actions_[i]) > time) {
      ++i;
      continue;
    }
    const NetworkAction action = actions_[i];
    actions_.erase(actions_.begin() + static_cast<std::ptrdiff_t>(i));
    for (auto& node : nodes_)
      if (node->status == ChipStatus::sleeping) bring_to(*node, time, true);
    something_happened();
    changed_ = time;
    perform(action);
    for (auto& node : nodes_) {
      note_ready(*node, time);
      if (node->status == ChipStatus::sleeping && wakes(*node)) node->status = ChipStatus::running;
    }
  }
}

void Network::perform(const NetworkAction& action) {
  using enum NetworkAction::Kind;
  if (action.kind == cut) return links_[action.target]->cut(now_);
  if (action.kind == restore) return links_[action.target]->restore(now_);
  Node& node = *nodes_[action.target];
  if (node.status == ChipStatus::pulled_out)
    throw NetworkError(fmt::format("{} at {} ps: chip {} has been pulled out", name(action.kind), action.time.count(), node.number));
  bring_to(node, now_, false);
  node.patience = {};
  node.chip.set_trace(node.trace);
  const auto kind = action.kind == reset ? NetworkEvent::Kind::reset : action.kind == hold ? NetworkEvent::Kind::hold
                    : action.kind == release ? NetworkEvent::Kind::release : NetworkEvent::Kind::pull_out;
  events_.push_back({kind, now_, node.number, 0, 0, 0});
  switch (action.kind) {
    case reset: return reset_chip(node);
    case release:
      if (node.status != ChipStatus::held) return;
      node.chip.hold(false);
      node.status = node.chip.halted() ? ChipStatus::fault : ChipStatus::running;
      return;
    case pull_out:
      for (const std::size_t link : node.links) links_[link]->cut(now_);
      node.chip.hold(true);
      node.status = ChipStatus::pulled_out;
      return;
    default:
      node.chip.hold(true);
      node.status = ChipStatus::held;
  }
}

void Network::reset_chip(Node& node) {
  for (int n = 0; n < c40::port_count; ++n)
    for (const c40::Fifo* fifo : {&node.chip.port(n).output, &node.chip.port(n).input})
      for (const Word word : fifo->words())
        events_.push_back({NetworkEvent::Kind::discarded, now_, node.number, n, word, fifo == &node.chip.port(n).input ? 1 : 0});
  for (auto& memory : memories_)
    if (memory->owner == node.number) memory->owner.reset();
  node.chip.hold(false);
  if (!node.description.boot) node.chip.reset();  // booting is one
  start(node);
}

// ---- the end, and what can be asked ----

NetworkStop Network::finish(NetworkStop::Reason reason, Time limit) {
  Time end = limit;
  if (reason != NetworkStop::Reason::limit) {
    end = changed_;
    for (const auto& node : nodes_) end = std::max(end, at_rest_since(*node));
    for (auto& link : links_)
      while (link->next_event() <= end) link->advance_to(link->next_event());  // tokens
  }
  now_ = reason == NetworkStop::Reason::limit ? std::max(now_, end) : end;
  for (auto& node : nodes_)
    if (reason == NetworkStop::Reason::limit && node->follows_ports() && !node->patience.loop)
      run_chip(*node, end);  // its last instruction, if it follows its ports only now
    else if (node->status == ChipStatus::waiting && node->chip.dma_active() && !node->chip.dma_busy()) run_chip(*node, end);  // its timers
    else if (node->status == ChipStatus::sleeping || node->held() || (node->patience.loop && node->status == ChipStatus::running)) bring_to(*node, end, false);
  check_words();
  return {reason, end};
}

void Network::check_words() const {
  for (std::size_t n = 0; n < links_.size(); ++n)
    if (const auto fault = links_[n]->unbalanced()) throw std::logic_error(fmt::format("link {}: {}", machine::to_text(description_.links[n]), *fault));
}

Chip& Network::chip(std::size_t n) { return nodes_.at(n)->chip; }
const Chip& Network::chip(std::size_t n) const { return nodes_.at(n)->chip; }
const std::string& Network::chip_name(std::size_t n) const { return nodes_.at(n)->description.name; }
const toolchain::Image& Network::program(std::size_t n) const { return *nodes_.at(n)->description.program; }
const Clock& Network::clock(std::size_t n) const { return nodes_.at(n)->clock; }
ChipStatus Network::status(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  if (node.patience.loop) return ChipStatus::looping;
  if (node.status != ChipStatus::sleeping || !node.dma_waits()) return node.status;
  if (awaits_dma_for_ever(node)) return ChipStatus::waiting;
  return has_ended(node) ? node.chip.idle() ? ChipStatus::idle : ChipStatus::halt : ChipStatus::sleeping;
}
void Network::record_peripherals(bool on) {
  for (auto& node : nodes_) node->chip.set_peripheral_sink(on ? node.get() : nullptr);
}
void Network::set_trace(std::size_t n, c40::TraceSink* sink) {
  Node& node = *nodes_.at(n);
  node.trace = sink;
  node.patience.looking.reset();
  node.chip.set_trace(sink);
}
std::span<Word> Network::memory(std::size_t n) { return memories_.at(n)->words; }

}  // namespace machine
