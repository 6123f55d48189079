#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "c40/peripherals/register_map.hpp"
#include "io/stop.hpp"
#include "isa/types.hpp"
#include "machine/chips/asleep.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Address;
using c40::Chip;
using c40::Cycles;
using c40::Word;

// ---- building ----

Network::Network(NetworkDescription description, std::uint64_t turn_order)
    : description_(std::move(description)), scheduler_(turn_order) {
  NetworkDescription& d = description_;
  if (d.chips.empty() || d.chips.size() > most_chips)
    throw NetworkError(fmt::format("a network of {} chips; 1 to {} are possible", d.chips.size(), most_chips));
  for (NetworkChip& chip : d.chips) {
    const std::size_t n = nodes_.size();
    if (chip.name.empty()) chip.name = fmt::format("{}", n);
    const double mhz = chip.clock_mhz ? *chip.clock_mhz : chip.board.clock_mhz.value_or(default_clock_mhz);
    if (!(mhz >= slowest_mhz && mhz <= fastest_mhz))
      throw NetworkError(
          fmt::format("chip {}: a clock of {} MHz; {} to {} are possible", n, mhz, slowest_mhz, fastest_mhz));
    nodes_.push_back(std::make_unique<Node>(*this, n, chip, Clock{instruction_cycles_per_second(mhz)}));
  }
  join_links();
  add_memories();
  add_devices();
  add_pin_nets();
  join_nets();
  join_pin_nets();
  for (auto& node : nodes_) load(*node);
  take_part();
  for (auto& net : nets_) net->start();
  made_ = true;
  const auto given = std::move(d.actions);
  for (const NetworkAction& action : given) schedule(action);
}

Network::~Network() = default;

/// In the order of ties: links, nets, actions, chips.
void Network::take_part() {
  for (std::size_t n = 0; n < links_.size(); ++n)
    scheduler_.add(*link_turns_.emplace_back(std::make_unique<LinkTurn>(*this, n)));
  for (auto& net : nets_) scheduler_.add(*net);
  scheduler_.add(*(action_turn_ = std::make_unique<ActionTurn>(*this)));
  for (auto& turn : device_turns_) scheduler_.add(*turn);
  for (auto& node : nodes_) scheduler_.add(*node);
}

void Network::join_links() {
  check(description_.links, nodes_.size());
  for (const NetworkLink& given : description_.links) {
    std::array<c40::Link::Side, 2> sides;
    for (std::size_t i = 0; i < 2; ++i) {
      const PortName& end = i == 0 ? given.a : given.b;
      Node& node = *nodes_[end.chip];
      sides[i] = {fmt::format("chip {} port {}", end.chip, end.port), end.port, &node.chip.port(end.port),
                  PacedClock{node.clock}};
    }
    const std::size_t number = links_.size();
    try {
      links_.push_back(std::make_unique<c40::Link>(std::move(sides[0]), std::move(sides[1]), given.parameters));
    } catch (const std::invalid_argument& error) {
      throw NetworkError(fmt::format("link {}: {}", machine::to_text(given), error.what()));
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

void Network::join_nets() {
  for (std::size_t n = 0; n < description_.nets.size(); ++n)
    if (description_.nets[n].name.empty()) description_.nets[n].name = fmt::format("{}", n);
  try {
    check(description_.nets, nodes_.size());
  } catch (const std::invalid_argument& error) {
    throw NetworkError(error.what());
  }
  if (description_.nets.empty()) return;
  std::vector<PinOwner*> owners;
  for (auto& node : nodes_) owners.push_back(node.get());
  net_tap_ = std::make_unique<NetTap>(*this);
  std::vector<unsigned> outputs(nodes_.size()), inputs(nodes_.size());
  const auto join = [&](const ChipPin& pin, std::vector<Net*>& nets, unsigned& mask) {
    if (nets.empty() || nets.back() != nets_.back().get()) nets.push_back(nets_.back().get());
    mask |= 1u << static_cast<unsigned>(pin.pin);
  };
  for (const NetDescription& net : description_.nets) {
    nets_.push_back(std::make_unique<Net>(net, owners));
    nets_.back()->listener = net_tap_.get();
    for (const ChipPin& pin : net.drivers) join(pin, nodes_[pin.chip]->nets_out, outputs[pin.chip]);
    for (const ChipPin& pin : net.receivers)
      join(pin, nodes_[pin.chip]->nets_in, inputs[pin.chip]), nodes_[pin.chip]->pins_in.push_back(pin.pin);
    for (const ChipPin& pin : net.receivers)
      if (pin.pin == c40::Pin::reset) nodes_[pin.chip]->reset_net = nets_.back().get();
  }
  for (auto& node : nodes_)
    if ((outputs[node->number] | inputs[node->number]) != 0)
      node->chip.watch_pins(node.get(), outputs[node->number], inputs[node->number]);
}

void Network::load(Node& node) {
  if (node.description.program == nullptr) {
    if (!node.description.boot)
      throw NetworkError(fmt::format("chip {} has no program, and does not boot", node.number));
    node.description.program = std::make_shared<toolchain::Image>();
  }
  const toolchain::Image& image = *node.description.program;
  toolchain::require_c40(image, fmt::format("chip {}", node.number));
  node.chip.reset();
  const c40::Board& board = node.description.board.board;
  for (const auto& [base, words] : node.description.board.contents) {
    try {
      node.chip.write_block(base, words);
    } catch (const std::out_of_range& error) {
      throw NetworkError(fmt::format("chip {}: {} words of a ROM at {:08X}h do not lie in memory: {}", node.number,
                                     words.size(), base, error.what()));
    }
  }
  const bool from_ports = node.description.boot && reset_source(board) == ResetSource::ports;
  const bool has_stream =
      node.description.is_in_rom || (image.sections.empty() && !node.description.board.contents.empty());
  if (node.description.boot && !from_ports && reset_source(board) == ResetSource::memory && !has_stream)
    return load_stream(node, image, board);
  for (const toolchain::Image::Section& section : image.sections) {
    if (!section.loaded || from_ports || node.description.is_in_rom) continue;
    try {
      node.chip.write_block(section.address, section.words);
    } catch (const std::out_of_range&) {
      throw NetworkError(
          fmt::format("chip {}: {}", node.number, no_ram_for(board, section.name, section.address, section.size)));
    }
  }
  ready_to_start(node);
}

/// The pins select a memory, and the program is there as a boot stream.
void Network::load_stream(Node& node, const toolchain::Image& image, const c40::Board& board) {
  BootHeader header;
  header.global_interface_control = board.global_interface_control;
  header.local_interface_control = board.local_interface_control;
  try {
    const std::vector<Word> stream = boot_memory(image, header);
    require_not_overwritten(stream, boot_address(board), image);
    node.chip.write_block(boot_address(board), stream);
  } catch (const std::exception& error) {
    throw NetworkError(fmt::format("chip {}: board {}: the boot stream at {:08X}h, which the pins choose: {}",
                                   node.number, board.name, boot_address(board), error.what()));
  }
  ready_to_start(node);
}

void Network::ready_to_start(Node& node) {
  if (node.description.add_words) node.description.add_words(node.chip);
  node.chip.stop_at_ends(true);
  if (node.description.until) node.chip.add_breakpoint(*node.description.until);
  for (const Address end : node.description.other_ends) node.chip.add_breakpoint(end);
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
  if (node.description.is_alone) return;
  const auto chips = static_cast<Word>(nodes_.size());
  const std::array<Word, 4> values{static_cast<Word>(node.number), chips,
                                   description_.shape[0] == 0 ? chips : description_.shape[0],
                                   description_.shape[0] == 0 ? 1 : description_.shape[1]};
  constexpr std::array registers{isa::Register::R0, isa::Register::R1, isa::Register::R2, isa::Register::R3};
  for (std::size_t i = 0; i < registers.size(); ++i)
    node.chip.set_register(registers[i],
                           (node.chip.register_value(registers[i]) & ~std::uint64_t{0xFFFFFFFF}) | values[i]);
}

void Network::schedule(const NetworkAction& action) {
  const ActionTarget what = target_of(action.kind);
  const std::size_t count = what == ActionTarget::link  ? links_.size()
                            : what == ActionTarget::net ? nets_.size()
                                                        : nodes_.size();
  if (action.target >= count)
    throw NetworkError(
        fmt::format("{}: there is no {} {}; the network has {}", name(action.kind), name(what), action.target, count));
  if (what == ActionTarget::net) {
    const NetDescription& net = nets_[action.target]->description();
    if (net.is_driven() && !net.open_drain)
      throw NetworkError(
          fmt::format("{}: net {} ({}) is driven by a chip; a net without a driver, or an open-drain net, is expected",
                      name(action.kind), net.name, to_text(net)));
  }
  if (action.kind == NetworkAction::Kind::pulse) {
    if (action.width <= Time{0}) throw NetworkError("pulse: a width of more than 0 us is expected");
    if (action.count != 1 && action.period <= action.width)
      throw NetworkError("pulse: a period of more than the width is expected");
  }
  if (what == ActionTarget::chip) check_not_pulled_out(action);
  if (action.time < now_)
    throw NetworkError(fmt::format("{} at {} ps: the network has already run to {} ps", name(action.kind),
                                   action.time.count(), now_.count()));
  add(action);
}

void Network::add(const NetworkAction& action) {
  actions_.insert(std::upper_bound(actions_.begin(), actions_.end(), action,
                                   [](const auto& a, const auto& b) { return a.time < b.time; }),
                  action);
  action_turn_->changed();
}

/// A chip that is pulled out has no action after that, in whichever order they are given. At one instant the order is
/// the given one.
void Network::check_not_pulled_out(const NetworkAction& action) const {
  using enum NetworkAction::Kind;
  const auto refuse = [&](const NetworkAction& late, std::string_view when) {
    throw NetworkError(fmt::format("{} at {} ps: chip {} {}", name(late.kind), late.time.count(), late.target, when));
  };
  if (nodes_[action.target]->status == ChipStatus::pulled_out) refuse(action, "has been pulled out");
  for (const NetworkAction& other : actions_) {
    if (other.target != action.target || target_of(other.kind) != ActionTarget::chip) continue;
    const bool is_later = action.time >= other.time;
    const NetworkAction &first = is_later ? other : action, &second = is_later ? action : other;
    if (first.kind == pull_out) refuse(second, fmt::format("is pulled out at {} ps", first.time.count()));
  }
}

// ---- what happens next ----

Time Network::effective(const NetworkAction& action) const {
  if (target_of(action.kind) != ActionTarget::chip) return action.time;
  const Node& node = *nodes_[action.target];
  return node.clock.at(std::max(node.chip.cycle(), node.first_cycle(action.time)));
}

/// The cycle before which the chip's own next action cannot be.
Cycles Network::find_next_action_on(const Node& node) const {
  const auto next = std::ranges::find_if(actions_, [&](const NetworkAction& action) {
    return action.target == node.number && target_of(action.kind) == ActionTarget::chip;
  });
  return next == actions_.end() ? never_cycle : node.first_cycle(next->time);
}

Time Network::next_action() const {
  Time next = never;
  for (const NetworkAction& action : actions_) {
    if (action.time >= next) break;  // no action happens before its time
    next = std::min(next, effective(action));
  }
  return next;
}

/// Nothing can happen any more, except loops that repeat, tokens that go back and forth, and timers without a listener.
/// Or every processor has ended, and only a DMA is armed.
bool Network::quiet() {
  if (!nodes_[moving_]->is_still() && !nodes_[moving_]->has_ended()) return false;
  if (!actions_.empty()) return false;
  if (std::any_of(links_.begin(), links_.end(),
                  [](const auto& link) { return link->next_event() != never && !link->only_exchanges_token(); }))
    return false;
  if (std::ranges::any_of(nets_, [](const auto& net) { return net->continues() && net->has_listener(); })) return false;
  if (std::ranges::any_of(nodes_, [](const auto& node) { return node->devices_continue(); })) return false;
  for (auto& node : nodes_) node->look_for_loop();
  const auto moves = std::find_if(nodes_.begin(), nodes_.end(), [](const auto& node) { return !node->is_still(); });
  if (moves == nodes_.end()) return true;
  const auto works = std::find_if(nodes_.begin(), nodes_.end(), [](const auto& node) { return !node->has_ended(); });
  if (works == nodes_.end()) return true;
  moving_ = static_cast<std::size_t>((*moves)->has_ended() ? works - nodes_.begin() : moves - nodes_.begin());
  return false;
}

bool Network::waits_forever() const {
  return std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& node) {
    return (node->patience.loop ? polls(*node) : node->status == ChipStatus::waiting) || node->awaits_dma_forever();
  });
}

namespace {
class Running {
 public:
  explicit Running(bool& runs) : runs_(runs) { runs_ = true; }
  ~Running() { runs_ = false; }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

 private:
  bool& runs_;
};
}  // namespace

NetworkStop Network::run_until(Time limit) {
  // Interval between two checks for a stop: a moment even for 64 chips with instruction traces.
  constexpr Time slice = std::chrono::microseconds{200};
  const Running running(runs_);
  for (;;) {
    NetworkStop stop = run_slice(std::min(limit, now_ + slice));
    const bool ends = stop.reason != NetworkStop::Reason::limit || now_ >= limit;
    if (!ends && !io::stop_asked()) continue;
    if (!ends) stop = {NetworkStop::Reason::interrupted, now_};
    settle_devices();
    return stop;
  }
}

NetworkStop Network::run_slice(Time limit) {
  for (auto& node : nodes_) node->note_device_event();  // its user may have typed
  scheduler_.all_changed();
  for (;;) {
    if (quiet())
      if (const auto stop = stop_at_rest(limit)) return *stop;
    if (scheduler_.shuffles()) {
      scheduler_.run_some_ahead(limit);
      if (quiet())
        if (const auto stop = stop_at_rest(limit)) return *stop;
    }
    if (!scheduler_.step(limit)) return finish(NetworkStop::Reason::limit, limit);
  }
}

// Of a quiet network, unless it comes to rest after the limit.
std::optional<NetworkStop> Network::stop_at_rest(Time limit) {
  const Time end = at_rest_since();
  if (end >= limit) return {};
  const auto reason = waits_forever() ? NetworkStop::Reason::deadlock : NetworkStop::Reason::ended;
  ends_at_ = end;
  while (scheduler_.earliest() < end) scheduler_.step(limit);
  ends_at_ = never;
  return finish(reason, end);
}

/// For a network that is quiet. The chip that finds a loop may be ahead of others, or behind: this is the instant at
/// which all have come to rest. Of a network that is not quiet: no earlier than this, where nothing that is still to
/// happen is earlier than `at_least`.
Time Network::at_rest_since(Time at_least) const {
  Time since = std::max(changed_, at_least);
  Time ahead{0};
  for (const auto& node : nodes_) {
    since = std::max(since, node->at_rest_since());
    if (!node->patience.loop) continue;
    if (node->chip.watches_ports())
      ahead = std::max(ahead, node->lookahead());
    else if (node->watches() || node->follows())
      ahead = std::max(ahead, node->clock.at(2));  // the effect of a pin on it
  }
  return since < never - ahead ? since + ahead : never;
}

void Network::link_happens(std::size_t number, Time time) {
  now_ = time;
  c40::Link& link = *links_[number];
  const NetworkLink& ends = description_.links[number];
  const std::array nodes{nodes_[ends.a.chip].get(), nodes_[ends.b.chip].get()};
  bool moved = false;
  for (Node* node : nodes) moved |= node->come_to(time);
  const bool passes_token = link.only_exchanges_token();
  link.advance_to(time);
  something_happened();
  if (!passes_token) changed_ = time;
  for (Node* node : nodes) {
    if (!moved && node->status == ChipStatus::running) continue;  // the chip does not look at its ports
    const bool became_ready = node->note_ready(time);
    if (node->status == ChipStatus::sleeping) node->wake_up();
    if (!moved && !became_ready && node->status == ChipStatus::waiting && !node->chip.dma_active())
      continue;  // no change
    node->changed();
    if (moved) node->tell_changes();
  }
}

void Network::poke(std::size_t n, Address address, Word value) {
  if (!runs_ && c40::register_at(address) != nullptr) nodes_.at(n)->stand_at_rest_until(now_);
  chip(n).poke(address, value);
}

void Network::changed_by_hand(std::optional<std::size_t> moved) {
  if (runs_) return;
  something_happened();
  changed_ = now_;
  for (auto& node : nodes_) node->look_again(node->number == moved);
}

void Network::perform_port(Node& node, Cycles cycle) {
  node.chip.complete_port(cycle);
  node.status = ChipStatus::running;
  node.forget_port();
}

// ---- the end, and queries ----

NetworkStop Network::finish(NetworkStop::Reason reason, Time end) {
  if (reason != NetworkStop::Reason::limit) {
    // What else happens up to the end, the end included, and has no effect: whichever of two things at that instant
    // has had its turn when the network is found to be at rest.
    for (auto& link : links_)
      while (link->next_event() <= end) link->advance_to(link->next_event());  // tokens
    for (auto& node : nodes_)
      if (node->next_pin_event() <= end) node->drive_on(end);
    for (auto& net : nets_)
      while (net->next() <= end) net->act(net->next());
  }
  now_ = reason == NetworkStop::Reason::limit ? std::max(now_, end) : end;
  for (auto& node : nodes_) {
    const bool runs = node->status == ChipStatus::running;
    const bool continues = reason == NetworkStop::Reason::limit && !node->patience.loop &&
                           (node->follows() || (runs && node->chip.dma_active()));
    if (continues || (runs && node->patience.loop))
      node->run_to(end);  // its last instruction, if it follows its ports only now; and its DMA, which may be behind
    else if (node->status == ChipStatus::waiting)
      node->bring_timers_to(end);
    else if (node->status == ChipStatus::sleeping || node->held())
      node->bring_to(end, false);
  }
  // Events since a chip was last checked are recorded at the end of every run, wherever the run was divided.
  for (auto& node : nodes_)
    if (!node->patience.is_private && node->patience.news != news_) node->begin_patience();
  check_words();
  return {reason, end};
}

void Network::check_words() const {
  for (std::size_t n = 0; n < links_.size(); ++n)
    if (const auto fault = links_[n]->unbalanced())
      throw std::logic_error(fmt::format("link {}: {}", machine::to_text(description_.links[n]), *fault));
}

Chip& Network::chip(std::size_t n) { return nodes_.at(n)->chip; }
const Chip& Network::chip(std::size_t n) const { return nodes_.at(n)->chip; }
const std::string& Network::chip_name(std::size_t n) const { return nodes_.at(n)->description.name; }
const IgnoredAccesses& Network::ignored(std::size_t n) const { return nodes_.at(n)->ignored; }

const toolchain::Image& Network::program(std::size_t n) const { return *nodes_.at(n)->description.program; }
const Clock& Network::clock(std::size_t n) const { return nodes_.at(n)->clock; }
ChipStatus Network::status(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  if (node.patience.loop) return ChipStatus::looping;
  if (node.status != ChipStatus::sleeping || !node.dma_waits()) return node.status;
  if (node.awaits_dma_forever()) return ChipStatus::waiting;
  return node.has_ended() ? node.chip.idle() ? ChipStatus::idle : ChipStatus::halt : ChipStatus::sleeping;
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
