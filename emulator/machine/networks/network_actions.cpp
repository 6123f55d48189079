// Actions on a network at an instant: their names and text.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "io/nearest.hpp"
#include "isa/ascii.hpp"
#include "machine/networks/network.hpp"

namespace machine {
namespace {

struct Row {
  NetworkAction::Kind kind;
  std::string_view name;
  ActionTarget target;
};
using enum NetworkAction::Kind;
constexpr std::array rows{
    Row{cut, "cut", ActionTarget::link},         Row{restore, "restore", ActionTarget::link},
    Row{reset, "reset", ActionTarget::chip},     Row{hold, "hold", ActionTarget::chip},
    Row{release, "release", ActionTarget::chip}, Row{pull_out, "pull_out", ActionTarget::chip},
    Row{low, "low", ActionTarget::net},          Row{high, "high", ActionTarget::net},
    Row{open, "open", ActionTarget::net},        Row{pulse, "pulse", ActionTarget::net},
};
constexpr const Row& row_of(NetworkAction::Kind kind) { return rows[static_cast<std::size_t>(kind)]; }
static_assert([] {
  for (std::size_t n = 0; n < rows.size(); ++n)
    if (rows[n].kind != static_cast<NetworkAction::Kind>(n)) return false;
  return true;
}());

constexpr double most_microseconds = 1e12;

std::optional<double> number(std::string_view text) {
  const auto value = ascii::number<double>(text);
  return value && *value >= 0 && *value <= most_microseconds ? value : std::nullopt;
}

Time microseconds(double value) { return Time{std::llround(value * 1e6)}; }

}  // namespace

std::string_view name(NetworkAction::Kind kind) { return row_of(kind).name; }
ActionTarget target_of(NetworkAction::Kind kind) { return row_of(kind).target; }
std::string_view name(ActionTarget target) {
  constexpr std::array<std::string_view, 3> names{"link", "chip", "net"};
  return names[static_cast<std::size_t>(target)];
}

NetworkAction::Kind action_named(std::string_view text) {
  std::vector<std::string_view> names;
  for (const Row& row : rows) {
    if (row.name == text) return row.kind;
    names.push_back(row.name);
  }
  throw NetworkError(fmt::format("there is no action \"{}\"; {} is expected{}", text, fmt::join(names, ", "),
                                 io::did_you_mean(text, names)));
}

std::size_t action_target_named(NetworkAction::Kind kind, std::string_view text, const NetworkDescription& network) {
  std::vector<std::string> chips;
  for (const NetworkChip& chip : network.chips)
    chips.push_back(chip.name.empty() ? fmt::format("{}", chips.size()) : chip.name);
  switch (target_of(kind)) {
    case ActionTarget::link: return link_named(text, chips, network.links);
    case ActionTarget::chip: return chip_named(text, chips);
    case ActionTarget::net: break;
  }
  try {
    return net_named(text, network.nets);
  } catch (const std::invalid_argument& error) {
    throw NetworkError(error.what());
  }
}

void set_pulses(NetworkAction& action, double width_us, std::optional<double> period_us,
                std::optional<std::uint64_t> count) {
  action.width = microseconds(width_us);
  if (period_us) action.period = microseconds(*period_us);
  action.count = count ? *count : period_us ? 0 : 1;
}

NetworkAction parse_action(std::string_view text, const NetworkDescription& network) {
  const std::vector<std::string_view> parts = ascii::split(text, ',');
  const auto at = number(parts[0]);
  if (parts.size() < 3 || !at)
    throw NetworkError("AT_US,ACTION,TARGET is expected, as 12.5,cut,0.3:1.0 or 20,reset,1 or 5,pulse,index,2");
  NetworkAction action;
  action.time = microseconds(*at);
  action.kind = action_named(parts[1]);
  action.target = action_target_named(action.kind, parts[2], network);
  if (action.kind != pulse) {
    if (parts.size() > 3)
      throw NetworkError(fmt::format("{} has only a target; \"{}\" is too much", name(action.kind), parts[3]));
    return action;
  }
  std::array<std::optional<double>, 3> values;
  for (std::size_t n = 3; n < parts.size(); ++n)
    if (n >= 6 || !(values[n - 3] = number(parts[n])))
      throw NetworkError("AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected");
  if (!values[0]) throw NetworkError("AT_US,pulse,NET,WIDTH_US[,PERIOD_US[,COUNT]] is expected");
  if (values[2] && (*values[2] != std::floor(*values[2]) || *values[2] < 1))
    throw NetworkError("pulse: COUNT is an integer, 1 or more");
  set_pulses(action, *values[0], values[1],
             values[2] ? std::optional(static_cast<std::uint64_t>(*values[2])) : std::nullopt);
  return action;
}

}  // namespace machine
