#include "machine/networks/net_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "io/nearest.hpp"
#include "isa/ascii.hpp"

namespace machine {

using c40::Pin;

namespace {

constexpr std::string_view blank = " ";

std::vector<ChipPin> parse_pins(std::string_view text, char between, const std::vector<std::string>& chips) {
  std::vector<ChipPin> pins;
  for (const std::string_view one : ascii::split(text, between)) {
    try {
      pins.push_back(parse_pin(ascii::trimmed(one, blank), chips));
    } catch (const std::invalid_argument& error) {
      if (one.find_first_of(",;&+") == std::string_view::npos) throw;
      throw std::invalid_argument(
          fmt::format("{} (+ joins receivers, & joins drivers, as 0.IIOF1&1.IIOF1>2.IIOF0+2.IIOF2)", error.what()));
    }
  }
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
    net.name = ascii::trimmed(rest.substr(0, colon), blank);
    rest.remove_prefix(colon + 1);
  }
  const std::size_t arrow = rest.find('>');
  if (arrow == std::string_view::npos || rest.find('>', arrow + 1) != std::string_view::npos)
    throw std::invalid_argument(
        fmt::format("\"{}\" is not a net; DRIVER>RECEIVER is expected, as 0.TCLK0>1.IIOF1", text));
  const std::string_view from = ascii::trimmed(rest.substr(0, arrow), blank);
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
  if (ascii::trimmed(text, blank).empty()) return nets;
  std::vector<std::string> names;
  for (std::size_t slot = 0; slot < slots; ++slot) names.push_back(fmt::format("{}", slot));
  for (const std::string_view one : ascii::split(text, ',')) {
    nets.push_back(parse_net(ascii::trimmed(one, blank), names));
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
