// Names of ports and links, and the links of generated topologies.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <map>

#include "isa/ascii.hpp"
#include "machine/networks/network.hpp"

namespace machine {
namespace {

// Side a has the token after reset: ports 0 to 2 go "forwards", 3 to 5 "backwards".
void join(std::vector<NetworkLink>& links, std::size_t from, std::size_t to, int dimension) {
  links.push_back({{from, dimension}, {to, dimension + 3}, {}});
}

}  // namespace

std::size_t chip_named(std::string_view text, const std::vector<std::string>& chips) {
  if (const auto named = std::find(chips.begin(), chips.end(), text); named != chips.end())
    return static_cast<std::size_t>(named - chips.begin());
  const auto number = ascii::number<std::size_t>(text);
  if (!number || *number >= chips.size())
    throw NetworkError(fmt::format("there is no chip {}; the network has {}", text,
                                   chips.size() == 1 ? "chip 0" : fmt::format("chips 0 to {}", chips.size() - 1)));
  return *number;
}

std::size_t link_named(std::string_view text, const std::vector<std::string>& chips,
                       const std::vector<NetworkLink>& links) {
  const NetworkLink wanted = parse_link(text, chips);
  const auto joins = [&](const NetworkLink& link) {
    return (link.a == wanted.a && link.b == wanted.b) || (link.a == wanted.b && link.b == wanted.a);
  };
  const auto found = std::find_if(links.begin(), links.end(), joins);
  if (found == links.end()) {
    std::vector<std::string> names;
    for (const NetworkLink& link : links) names.push_back(to_text(link));
    throw NetworkError(names.empty()
                           ? fmt::format("there is no link {}; the network has no links", text)
                           : fmt::format("there is no link {}; {} is expected", text, fmt::join(names, ", ")));
  }
  return static_cast<std::size_t>(found - links.begin());
}

PortName parse_port(std::string_view text, const std::vector<std::string>& chips) {
  const std::size_t dot = text.rfind('.');
  if (dot == std::string_view::npos || dot == 0 || dot + 1 == text.size())
    throw NetworkError(fmt::format("\"{}\" is not a port; CHIP.PORT is expected, as 0.3", text));
  const std::string_view chip = text.substr(0, dot), number = text.substr(dot + 1);
  PortName out;
  try {
    out.chip = chip_named(chip, chips);
  } catch (const NetworkError& error) {
    throw NetworkError(fmt::format("{}: {}", text, error.what()));
  }
  out.port = ascii::number<int>(number).value_or(-1);
  if (out.port < 0 || out.port >= c40::port_count)
    throw NetworkError(
        fmt::format("{}: chip {} has no port {}; 0 to {} are possible", text, out.chip, number, c40::port_count - 1));
  return out;
}

NetworkLink parse_link(std::string_view text, const std::vector<std::string>& chips) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos)
    throw NetworkError(fmt::format("link \"{}\": CHIP.PORT:CHIP.PORT is expected, as 0.3:1.0", text));
  try {
    return {parse_port(text.substr(0, colon), chips), parse_port(text.substr(colon + 1), chips), {}};
  } catch (const NetworkError& error) {
    throw NetworkError(fmt::format("link {}: {}", text, error.what()));
  }
}

std::string to_text(const PortName& port) { return fmt::format("{}.{}", port.chip, port.port); }
std::string to_text(const NetworkLink& link) { return to_text(link.a) + ":" + to_text(link.b); }

void check(const std::vector<NetworkLink>& links, std::size_t chips) {
  std::map<PortName, std::string> taken;
  for (const NetworkLink& link : links) {
    const std::string name = to_text(link);
    for (const PortName& end : {link.a, link.b}) {
      if (end.chip >= chips)
        throw NetworkError(fmt::format("link {}: there is no chip {}; the network has {}", name, end.chip, chips));
      if (end.port < 0 || end.port >= c40::port_count)
        throw NetworkError(fmt::format("link {}: chip {} has no port {}; 0 to {} are possible", name, end.chip,
                                       end.port, c40::port_count - 1));
      if (const auto other = taken.find(end); other != taken.end() && link.a != link.b)
        throw NetworkError(fmt::format("link {}: port {} of chip {} already has link {}; a port has one link", name,
                                       end.port, end.chip, other->second));
    }
    taken.emplace(link.a, name), taken.emplace(link.b, name);
  }
}

std::vector<NetworkLink> grid_links(const std::vector<std::size_t>& size, bool closed) {
  std::size_t chips = 1;
  for (const std::size_t n : size) {
    if (n == 0 || n > most_chips)
      throw NetworkError(fmt::format("a dimension of {} chips; 1 to {} are possible", n, most_chips));
    chips *= n;
    if (chips > most_chips) throw NetworkError(fmt::format("a network has at most {} chips", most_chips));
  }
  if (size.empty() || size.size() > 3)
    throw NetworkError(fmt::format("a grid of {} dimensions; 1 to 3 are possible", size.size()));
  std::vector<NetworkLink> links;
  for (std::size_t chip = 0; chip < chips; ++chip) {
    std::size_t stride = 1;
    for (std::size_t d = 0; d < size.size(); ++d) {
      const std::size_t at = chip / stride % size[d];
      if (at + 1 < size[d])
        join(links, chip, chip + stride, static_cast<int>(d));
      else if (closed)
        join(links, chip, chip - at * stride, static_cast<int>(d));
      stride *= size[d];
    }
  }
  return links;
}

// Along dimension d, chips with an even number of ones send first if d is even, and chips with an odd number if d is
// odd: so every chip has at most three ports of either kind.
std::vector<NetworkLink> hypercube_links(unsigned dimensions) {
  if (dimensions > c40::port_count)
    throw NetworkError(fmt::format("a hypercube of {} dimensions; a chip has {} ports", dimensions, c40::port_count));
  std::vector<NetworkLink> links;
  for (std::size_t chip = 0; chip < std::size_t{1} << dimensions; ++chip)
    for (unsigned d = 0; d < dimensions; ++d) {
      const std::size_t other = chip ^ std::size_t{1} << d;
      if ((static_cast<unsigned>(std::popcount(chip)) + d) % 2 == 0) join(links, chip, other, static_cast<int>(d / 2));
    }
  return links;
}

std::size_t set_topology(NetworkDescription& network, std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  std::vector<std::size_t> size;
  const auto unclear = [&] {
    return NetworkError(fmt::format(
        "\"{}\" is not a topology; ring:4, line:4, grid:4x4, torus:4x4x4 or hypercube:16 is expected", text));
  };
  if (colon == std::string_view::npos) throw unclear();
  for (std::string_view rest = text.substr(colon + 1);; rest.remove_prefix(1)) {
    std::size_t n = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), n);
    if (error != std::errc{}) throw unclear();
    size.push_back(n);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    if (rest.empty()) break;
    if (rest.front() != 'x') throw unclear();
  }
  const bool one_dimension = kind == "ring" || kind == "line" || kind == "hypercube";
  if ((!one_dimension && kind != "grid" && kind != "torus") || (one_dimension && size.size() != 1)) throw unclear();
  try {
    if (kind == "hypercube") {
      if (!std::has_single_bit(size[0]) || size[0] > most_chips)
        throw NetworkError("a hypercube has 1, 2, 4, 8, 16, 32 or 64 chips");
      network.links = hypercube_links(static_cast<unsigned>(std::countr_zero(size[0])));
      return size[0];
    }
    network.links = grid_links(size, kind == "ring" || kind == "torus");
  } catch (const NetworkError& error) {
    throw NetworkError(fmt::format("{}: {}", text, error.what()));
  }
  std::size_t chips = 1;
  for (const std::size_t n : size) chips *= n;
  network.shape = {static_cast<c40::Word>(size[0]), static_cast<c40::Word>(size.size() > 1 ? size[1] : 1)};
  return chips;
}

}  // namespace machine
