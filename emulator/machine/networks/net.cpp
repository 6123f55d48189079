#include "machine/networks/net.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "io/nearest.hpp"
#include "state/visitor.hpp"

namespace machine {

using c40::Drive;
using c40::Pin;

Net::Net(NetDescription description, const std::vector<PinOwner*>& owners)
    : description_{std::move(description)},
      drives_(description_.drivers.size() + 1, Drive::none),
      receivers_(description_.receivers.size(), Receiver{description_.rest, {}}),
      level_{description_.rest} {
  for (const ChipPin& pin : description_.drivers) drivers_.push_back(owners.at(pin.chip));
  for (const ChipPin& pin : description_.receivers) owners_.push_back(owners.at(pin.chip));
}

void Net::start() {
  for (std::size_t i = 0; i < receivers_.size(); ++i)
    owners_[i]->pin_changes(description_.receivers[i].pin, level_, Time{0});
}

// ---- drivers ----

void Net::add(const Change& change) {
  const auto later = std::ranges::upper_bound(changes_, change.time, {}, &Change::time);
  changes_.insert(later, change);
  changed();
}

void Net::driven(const ChipPin& pin, Drive drive, Time at) {
  const auto driver = std::ranges::find(description_.drivers, pin) - description_.drivers.begin();
  add({at, static_cast<std::size_t>(driver), drive});
}

void Net::script(Drive drive, Time at) {
  pulsing_ = false;
  add({at, script(), drive});
}

void Net::script(const PulseTrain& pulses) {
  pulses_ = pulses;
  pulse_ = 0;
  pulsing_ = true;
  changed();
}

std::optional<Net::Change> Net::next_pulse() const {
  if (!pulsing_) return {};
  const Time begins = pulses_.first + pulses_.period * static_cast<std::int64_t>(pulse_ / 2);
  const bool ends = pulse_ % 2 == 1;
  return Change{ends ? begins + pulses_.width : begins, script(),
                ends ? Drive::none : c40::drive_to(!description_.rest)};
}

bool Net::resulting_level() const {
  bool high = false, low = false;
  for (const Drive drive : drives_) high |= drive == Drive::high, low |= drive == Drive::low;
  return low ? false : high || description_.rest;
}

// ---- effects ----

Time Net::next() const {
  Time next = changes_.empty() ? never : changes_.front().time;
  if (const auto pulse = next_pulse()) next = std::min(next, pulse->time);
  for (const Receiver& receiver : receivers_)
    if (!receiver.seen.empty()) next = std::min(next, receiver.seen.front().due);
  return next;
}

void Net::act(Time now) {
  for (auto pulse = next_pulse(); pulse && pulse->time <= now; pulse = next_pulse()) {
    ++pulse_;
    if (pulses_.count != 0 && pulse_ == 2 * pulses_.count) pulsing_ = false;
    drives_[pulse->source] = pulse->drive;
  }
  while (!changes_.empty() && changes_.front().time <= now) {
    drives_[changes_.front().source] = changes_.front().drive;
    changes_.pop_front();
  }
  settle(now);
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Receiver& receiver = receivers_[i];
    while (!receiver.seen.empty() && receiver.seen.front().due <= now) {
      const bool level = receiver.seen.front().level;
      receiver.seen.pop_front();
      if (level == std::exchange(receiver.level, level)) continue;
      owners_[i]->pin_changes(description_.receivers[i].pin, level, now);
    }
  }
}

// All drivers of one instant together make one level.
void Net::settle(Time now) {
  const bool level = resulting_level();
  if (level == level_) return;
  level_ = level;
  ++edges_;
  if (listener != nullptr) listener->changed(*this, level, now);
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    Receiver& receiver = receivers_[i];
    const Time at = due(i, now);
    if (receiver.seen.empty() || receiver.seen.back().due != at) {
      receiver.seen.push_back({at, level});
      continue;
    }
    // The level changed and changed back between two looks.
    receiver.seen.pop_back();
    ++missed_;
    if (listener != nullptr) listener->missed(*this, description_.receivers[i].chip, now);
  }
}

/// When an edge reaches a receiver's pin, after the synchroniser.
Time Net::due(std::size_t receiver, Time edge) const {
  const PinOwner& owner = *owners_[receiver];
  return owner.time_of(owner.cycle_from(edge) + 1);
}

Time Net::reaches(std::size_t chip) const {
  Time edge = changes_.empty() ? never : changes_.front().time;
  if (const auto pulse = next_pulse()) edge = std::min(edge, pulse->time);
  for (const PinOwner* driver : drivers_) edge = std::min(edge, driver->drives_from());
  for (const PinOwner* mover : movers_) edge = std::min(edge, mover->drives_from());
  Time reach = never;
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    if (description_.receivers[i].chip != chip) continue;
    if (!receivers_[i].seen.empty()) reach = std::min(reach, receivers_[i].seen.front().due);
    if (edge != never) reach = std::min(reach, due(i, edge));
  }
  return reach;
}

bool Net::has_listener() const {
  for (std::size_t i = 0; i < owners_.size(); ++i)
    if (owners_[i]->listens_to(description_.receivers[i].pin)) return true;
  return false;
}

bool Net::is_low_at(const ChipPin& pin) const {
  const auto receiver = std::ranges::find(description_.receivers, pin) - description_.receivers.begin();
  return receiver != std::ssize(receivers_) && !receivers_[static_cast<std::size_t>(receiver)].level;
}

void Net::Receiver::list_state(state::Visitor& list) {
  list("level", level);
  list("seen", seen);
}

void Net::list_state(state::Visitor& list) {
  list("drives", drives_);
  list("changes", changes_);
  list("receivers", receivers_);
  list("pulses", pulses_);
  list("pulse", pulse_);
  list("pulsing", pulsing_);
  list("level", level_);
  list("edges", edges_);
  list("missed", missed_);
}

// ---- names ----

namespace {

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (std::size_t from = 0;;) {
    const std::size_t to = text.find(at, from);
    parts.push_back(trimmed(text.substr(from, to - from)));
    if (to == std::string_view::npos) return parts;
    from = to + 1;
  }
}

std::vector<ChipPin> parse_pins(std::string_view text, char between, const std::vector<std::string>& chips) {
  std::vector<ChipPin> pins;
  for (const std::string_view one : split(text, between)) pins.push_back(parse_pin(one, chips));
  return pins;
}

}  // namespace

ChipPin parse_pin(std::string_view text, const std::vector<std::string>& chips) {
  const auto unclear = [&](const std::string& right) {
    return std::invalid_argument(fmt::format("\"{}\" is not a pin of a chip; {}", text, right));
  };
  const std::size_t dot = text.rfind('.');
  if (dot == std::string_view::npos) throw unclear("CHIP.PIN is expected, as 0.TCLK0 or 1.IIOF2");
  const std::string_view chip = text.substr(0, dot), pin = text.substr(dot + 1);
  ChipPin found;
  auto named = std::ranges::find(chips, chip);
  if (named == chips.end()) {
    for (std::size_t n = 0; n < chips.size(); ++n)
      if (fmt::format("{}", n) == chip) named = chips.begin() + static_cast<std::ptrdiff_t>(n);
  }
  if (named == chips.end())
    throw unclear(
        fmt::format("there is no chip {}; {} is expected", chip, chips.empty() ? "a chip" : io::one_of(chips)));
  found.chip = static_cast<std::size_t>(named - chips.begin());
  for (std::size_t n = 0; n < c40::pin_count; ++n) {
    found.pin = static_cast<Pin>(n);
    if (name(found.pin) == pin) return found;
  }
  throw unclear("IIOF0 to IIOF3, TCLK0, TCLK1, NMI or RESET is expected");
}

NetDescription parse_net(std::string_view text, const std::vector<std::string>& chips) {
  NetDescription net;
  std::string_view rest = text;
  if (const std::size_t colon = rest.find(':'); colon != std::string_view::npos) {
    net.name = trimmed(rest.substr(0, colon));
    rest.remove_prefix(colon + 1);
  }
  const std::size_t arrow = rest.find('>');
  if (arrow == std::string_view::npos || rest.find('>', arrow + 1) != std::string_view::npos)
    throw std::invalid_argument(
        fmt::format("\"{}\" is not a net; DRIVER>RECEIVER is expected, as 0.TCLK0>1.IIOF1", text));
  const std::string_view from = trimmed(rest.substr(0, arrow));
  net.open_drain = from.find('&') != std::string_view::npos;
  if (!from.empty()) net.drivers = parse_pins(from, net.open_drain ? '&' : '+', chips);
  net.receivers = parse_pins(rest.substr(arrow + 1), '+', chips);
  return net;
}

std::string to_text(const ChipPin& pin) { return fmt::format("{}.{}", pin.chip, name(pin.pin)); }

std::string to_text(const NetDescription& net) {
  const auto all = [](const std::vector<ChipPin>& pins, const char* between) {
    std::vector<std::string> texts;
    for (const ChipPin& pin : pins) texts.push_back(to_text(pin));
    return fmt::format("{}", fmt::join(texts, between));
  };
  return all(net.drivers, net.open_drain ? "&" : "+") + ">" + all(net.receivers, "+");
}

void check(const std::vector<NetDescription>& nets, std::size_t chips) {
  std::vector<std::pair<ChipPin, const NetDescription*>> taken;
  for (const NetDescription& net : nets) {
    const auto refuse = [&](const std::string& why) {
      return std::invalid_argument(fmt::format("net {} ({}): {}", net.name, to_text(net), why));
    };
    if (net.receivers.empty()) throw refuse("no pin receives; one at least is expected");
    if (net.drivers.size() > 1 && !net.open_drain)
      throw refuse("two pins drive it; an open-drain net is written with &, as 0.IIOF1&1.IIOF1>2.IIOF0");
    if (net.open_drain && !net.rest) throw refuse("an open-drain net is high at rest");
    for (const ChipPin& pin : net.drivers)
      if (!c40::can_be_output(pin.pin))
        throw refuse(fmt::format("{} cannot drive it; IIOF and TCLK are outputs", to_text(pin)));
    for (const std::vector<ChipPin>* pins : {&net.drivers, &net.receivers}) {
      for (const ChipPin& pin : *pins) {
        if (pin.chip >= chips) throw refuse(fmt::format("there is no chip {}; the last is {}", pin.chip, chips - 1));
        const auto other = std::ranges::find(taken, pin, &std::pair<ChipPin, const NetDescription*>::first);
        if (other != taken.end() && other->second == &net)
          throw refuse(fmt::format("pin {} is in it twice", to_text(pin)));
        if (other != taken.end())
          throw refuse(fmt::format("pin {} is already on net {}", to_text(pin), other->second->name));
        taken.emplace_back(pin, &net);
      }
    }
  }
}

std::vector<NetDescription> parse_slot_nets(std::string_view text, std::size_t slots) {
  std::vector<NetDescription> nets;
  if (trimmed(text).empty()) return nets;
  std::vector<std::string> names;
  for (std::size_t slot = 0; slot < slots; ++slot) names.push_back(fmt::format("{}", slot));
  for (const std::string_view one : split(text, ',')) {
    nets.push_back(parse_net(one, names));
    if (nets.back().name.empty()) nets.back().name = fmt::format("{}", nets.size() - 1);
  }
  check_slot_nets(nets, slots);
  return nets;
}

void check_slot_nets(const std::vector<NetDescription>& nets, std::size_t slots) {
  check(nets, slots);
  for (const NetDescription& net : nets) {
    const auto refuse = [&](std::string_view why) {
      return std::invalid_argument(fmt::format("net {} ({}): {}", net.name, to_text(net), why));
    };
    if (net.drivers.empty()) throw refuse("no pin drives it; IIOF1 to IIOF3 or TCLK of a slot is expected");
    for (const std::vector<ChipPin>* pins : {&net.drivers, &net.receivers})
      for (const ChipPin& pin : *pins)
        if (pin.pin == Pin::iiof0) throw refuse("IIOF0 of every DSP is the host's doorbell; IIOF1 to IIOF3 are free");
  }
}

std::size_t net_named(std::string_view text, const std::vector<NetDescription>& nets) {
  std::vector<std::string> names;
  for (std::size_t n = 0; n < nets.size(); ++n) {
    if (nets[n].name == text) return n;
    names.push_back(nets[n].name);
  }
  for (std::size_t n = 0; n < nets.size(); ++n)
    if (fmt::format("{}", n) == text) return n;
  throw std::invalid_argument(names.empty()
                                  ? fmt::format("there is no net {}; there are no nets", text)
                                  : fmt::format("there is no net {}; {} is expected", text, fmt::join(names, ", ")));
}

}  // namespace machine
