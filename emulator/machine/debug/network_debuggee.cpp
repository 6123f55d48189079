#include "machine/debug/network_debuggee.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "io/stop.hpp"
#include "machine/debug/error.hpp"
#include "state/archive.hpp"

namespace machine::debug {
namespace {

using Kind = NetworkEvent::Kind;

constexpr std::array kinds_of_events{
    std::pair{Kind::lost, "a word is lost on a link that is cut"},
    std::pair{Kind::dead, "a link can never move a word again"},
    std::pair{Kind::cut, "an action cuts a link"},
    std::pair{Kind::restored, "an action restores a link"},
    std::pair{Kind::missed, "a chip misses a pulse on a net"},
    std::pair{Kind::discarded, "a word in a FIFO is lost in a reset"},
    std::pair{Kind::reset, "an action resets a chip"},
    std::pair{Kind::hold, "an action freezes a chip until `release`"},
    std::pair{Kind::release, "an action releases a chip"},
    std::pair{Kind::pull_out, "an action pulls a chip out"},
};

constexpr bool is_of_chip(Kind kind) { return kind >= Kind::discarded; }

/// Not events of the network, but of a chip.
constexpr std::array ends{ChipStatus::fault, ChipStatus::halt,    ChipStatus::idle,
                          ChipStatus::until, ChipStatus::looping, ChipStatus::external_access};
bool is_end(ChipStatus status) { return std::ranges::find(ends, status) != ends.end(); }

}  // namespace

NetworkDebuggee::NetworkDebuggee(Network& network, EndWords ends)
    : network_(network), end_words_(std::move(ends)), now_(network.now()), reported_(network.events().size()) {
  for (std::size_t n = 0; n < network.chip_count(); ++n) status_.push_back(network.status(n));
}
NetworkDebuggee::~NetworkDebuggee() { network_.watch_memory({}); }

std::size_t NetworkDebuggee::chips() const { return network_.chip_count(); }
std::string NetworkDebuggee::chip_name(std::size_t n) const {
  const std::string& name = network_.chip_name(n);
  const std::string number = fmt::format("{}", n);
  return name.empty() || name == number ? "chip " + number : fmt::format("chip {} ({})", n, name);
}
c40::Chip& NetworkDebuggee::chip(std::size_t n) { return network_.chip(n); }
const toolchain::Image& NetworkDebuggee::program(std::size_t n) const { return network_.program(n); }
Time NetworkDebuggee::time_of(std::size_t n, c40::Cycles cycle) const { return network_.clock(n).at(cycle); }
std::string NetworkDebuggee::describe(std::size_t n) {
  if (network_.status(n) == ChipStatus::running) return "running";
  return described(n);
}
std::string NetworkDebuggee::described(std::size_t n) const {
  return network_.calls_debugger(n) ? waits_before_swi(network_.chip(n).pc()) : network_.describe(n);
}
void NetworkDebuggee::set_trace(std::size_t n, c40::TraceSink* sink) { network_.set_trace(n, sink); }

std::optional<std::string> NetworkDebuggee::over() const {
  if (!ended_) return std::nullopt;
  if (!holds_.empty()) return holds_;
  if (network_.description().chips.front().is_alone) return described(0);
  std::string text(ended_->reason == NetworkStop::Reason::deadlock ? "no event is left"
                                                                   : "all chips have come to rest");
  for (std::size_t n = 0; n < network_.chip_count(); ++n) text += fmt::format("; {}: {}", chip_name(n), described(n));
  return text;
}

std::optional<std::size_t> NetworkDebuggee::calls() const {
  for (std::size_t n = 0; ended_ && n < network_.chip_count(); ++n)
    if (network_.calls_debugger(n)) return n;
  return std::nullopt;
}

void NetworkDebuggee::changed_by_hand(std::optional<std::size_t> moved) {
  ended_.reset();
  holds_.clear();
  network_.changed_by_hand(moved);
  for (std::size_t n = 0; n < status_.size(); ++n) status_[n] = network_.status(n);
}

void NetworkDebuggee::run_until(Time time) {
  if (end_words_.empty()) return advance_to(time);
  look_at_words();
  while (!ended_ && now_ < time && !io::stop_asked()) {
    const c40::Cycles cycle = network_.chip(0).cycle();
    const Time instruction_ends = time_of(0, cycle);
    advance_to(std::min(time, instruction_ends > now_ ? instruction_ends : time_of(0, cycle + 1)));
    look_at_words();
  }
}

/// After each instruction.
void NetworkDebuggee::look_at_words() {
  if (ended_ || time_of(0, network_.chip(0).cycle()) > now_) return;
  for (const auto& [address, word] : end_words_)
    if (peek(0, address) == word) {
      ended_ = NetworkStop{.reason = NetworkStop::Reason::ended, .time = now_};
      holds_ = fmt::format("{:08X}h holds {:08X}h, at {:08X}h", address, word, network_.chip(0).pc());
      return;
    }
}

void NetworkDebuggee::advance_to(Time time) {
  if (ended_) return;
  const NetworkStop stop = network_.run_until(time);
  if (stop.reason == NetworkStop::Reason::ended || stop.reason == NetworkStop::Reason::deadlock) ended_ = stop;
  now_ = stop.reason == NetworkStop::Reason::limit ? time : std::max(now_, stop.time);
  tell_new();
}

void NetworkDebuggee::tell_new() {
  const std::vector<NetworkEvent> events = network_.events();
  const auto wanted = [&](std::string_view kind) {
    return listener_ != nullptr && (kinds_.contains(std::string(kind)) || kinds_.contains("any"));
  };
  for (; reported_ < events.size(); ++reported_) {
    const NetworkEvent& event = events[reported_];
    if (is_common(event.kind) || !wanted(machine::name(event.kind))) continue;
    DebugEvent told{.time = event.time,
                    .kind = std::string(machine::name(event.kind)),
                    .chip = {},
                    .fields = {},
                    .text = network_.text(event)};
    if (is_of_chip(event.kind)) told.chip = event.place;
    listener_->happened(told);
  }
  for (std::size_t n = 0; n < status_.size(); ++n) {
    const ChipStatus status = network_.status(n);
    if (std::exchange(status_[n], status) == status || !is_end(status) || network_.calls_debugger(n)) continue;
    const std::string kind = status == ChipStatus::fault ? "fault" : "end";
    if (!wanted(kind)) continue;
    const Time at = std::max(network_.clock(n).at(network_.chip(n).cycle()), Time{0});
    listener_->happened({.time = std::min(at, now_),
                         .kind = kind,
                         .chip = n,
                         .fields = {{"status", std::string(machine::name(status))}},
                         .text = fmt::format("{}: {}", chip_name(n), network_.describe(n))});
  }
}

std::string NetworkDebuggee::save() { return state::save(network_); }

void NetworkDebuggee::load(std::string_view state) {
  state::load(network_, state);
  ended_.reset();
  holds_.clear();
  now_ = network_.now();
  reported_ = network_.events().size();
  for (std::size_t n = 0; n < status_.size(); ++n) status_[n] = network_.status(n);
}

std::optional<Word> NetworkDebuggee::peek(std::size_t n, Address address) {
  if (const auto place = network_.memory_place(n, address)) return network_.memory(place->memory)[place->word];
  try {
    return network_.chip(n).peek(address);
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

void NetworkDebuggee::poke(std::size_t n, Address address, Word value) {
  if (const auto place = network_.memory_place(n, address))
    network_.memory(place->memory)[place->word] = value;
  else
    network_.poke(n, address, value);
}

// Memories are numbered one after the other.
std::optional<Address> NetworkDebuggee::shared_word(std::size_t n, Address address) const {
  const auto place = network_.memory_place(n, address);
  if (!place) return std::nullopt;
  Address first = 0;
  for (std::size_t m = 0; m < place->memory; ++m) first += network_.description().memories[m].words;
  return first + place->word;
}

void NetworkDebuggee::watch_shared(SharedListener* listener, std::vector<c40::AddressRange> words) {
  if (listener == nullptr) return network_.watch_memory({});
  network_.watch_memory([this, listener, words = std::move(words)](std::size_t chip, Network::MemoryPlace, Word before,
                                                                   const c40::ExternalAccess& access, Time time) {
    const Address word = *shared_word(chip, access.address);
    if (std::ranges::none_of(words, [&](const c40::AddressRange& range) { return range.contains(word); })) return;
    const std::string who =
        access.channel < 0 ? chip_name(chip) : fmt::format("DMA channel {} of {}", access.channel, chip_name(chip));
    listener->shared_access({.time = time + Time{1},
                             .word = word,
                             .before = before,
                             .value = access.write ? access.value : before,
                             .write = access.write,
                             .chip = chip,
                             .who = who});
  });
}

std::vector<EventKind> NetworkDebuggee::event_kinds() const {
  EventField fault{.name = "status", .is_number = false}, end = fault;
  for (const ChipStatus status : ends) (status == ChipStatus::fault ? fault : end).words.emplace_back(name(status));
  std::vector<EventKind> all{
      {.name = "fault", .what = "a chip cannot continue", .of_chip = true, .fields = {fault}},
      {.name = "end", .what = "a chip's program has ended, or waits forever", .of_chip = true, .fields = {end}}};
  for (const auto& [kind, what] : kinds_of_events)
    all.push_back({.name = std::string(machine::name(kind)), .what = what, .of_chip = is_of_chip(kind)});
  return all;
}

void NetworkDebuggee::listen(DebugEventListener* listener, const std::set<std::string>& kinds) {
  listener_ = listener;
  kinds_ = kinds;
}

std::string NetworkDebuggee::output() {
  std::string all;
  for (std::size_t n = 0; n < chips(); ++n)
    if (const BoardDevices* devices = network_.devices(n)) all += devices->console();
  return all;
}

std::vector<std::string> NetworkDebuggee::page_names() const { return {"chips", "events", "devices"}; }

std::string NetworkDebuggee::devices_page() {
  std::string text;
  for (std::size_t n = 0; n < chips(); ++n) {
    const BoardDevices* devices = network_.devices(n);
    if (devices == nullptr) continue;
    for (const auto& [described, device] : devices->places()) {
      text += fmt::format("{}: {} {} at {:08X}h{}{}", chip_name(n), machine::name(described.kind), described.name,
                          described.base, described.pin ? fmt::format(", {}", c40::name(*described.pin)) : "",
                          described.pin && device->interrupts() ? " low" : "");
      if (device->sent() != nullptr) text += fmt::format(", has sent {} words", device->sent()->size());
      text += '\n';
    }
    for (const BoardDevices::Change& change : devices->changes())
      text += fmt::format("{}: led {}: {:X}h at cycle {}\n", chip_name(n), change.device, change.value, change.cycle);
    if (const auto more = devices->change_count() - devices->changes().size(); more > 0)
      text += fmt::format("{}: {} more changes of LEDs\n", chip_name(n), more);
  }
  return text.empty() ? "no chip has a device\n" : text;
}

std::string NetworkDebuggee::page(std::string_view name) {
  std::string text;
  if (name == "chips")
    for (std::size_t n = 0; n < chips(); ++n)
      text += fmt::format("{}: {}, at {:08X}h, cycle {}\n", chip_name(n), describe(n), network_.chip(n).pc(),
                          network_.chip(n).cycle());
  else if (name == "events")
    for (const NetworkEvent& event : network_.events()) text += network_.text(event) + "\n";
  else if (name == "devices")
    text = devices_page();
  else
    throw DebugError(fmt::format("{}: chips, events or devices is expected", name));
  return text;
}

}  // namespace machine::debug
