// Networks from a description: Python's lists, or a file.
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "machine/networks/network_file.hpp"
#include "python/bindings/c40/devices.hpp"
#include "python/bindings/interpreter/warnings.hpp"
#include "python/bindings/network/network.hpp"

namespace {

using machine::NetworkDescription;

machine::NetworkChip chip_of(const py::dict& given) {
  machine::NetworkChip chip;
  chip.program = std::make_shared<toolchain::Image>(given["program"].cast<const toolchain::Image&>());
  chip.board = python::read_board(given["board"].cast<std::string>());
  chip.name = given["name"].cast<std::string>();
  chip.clock_mhz = given["clock_mhz"].cast<std::optional<double>>();
  chip.until = given["until"].cast<std::optional<c40::Address>>();
  chip.boot = given["boot"].cast<bool>();
  for (const py::handle device : given["devices"])
    chip.devices.push_back(PythonDevice::place(py::reinterpret_borrow<py::object>(device)));
  return chip;
}

}  // namespace

std::unique_ptr<machine::Network> made_network(const py::list& chips,
                                               const std::vector<std::pair<std::string, py::dict>>& links,
                                               const std::optional<std::string>& topology, const py::list& memories,
                                               const std::vector<std::string>& nets, std::uint64_t turn_order) {
  NetworkDescription d;
  std::vector<std::string> names;
  if (topology) {
    const std::size_t needed = machine::set_topology(d, *topology);
    if (py::len(chips) != needed)
      throw machine::NetworkError("topology " + *topology + " has " + std::to_string(needed) + " chips, and " +
                                  std::to_string(py::len(chips)) + " are given");
  }
  for (const py::handle chip : chips) {
    d.chips.push_back(chip_of(chip.cast<py::dict>()));
    names.push_back(d.chips.back().name.empty() ? std::to_string(names.size()) : d.chips.back().name);
  }
  for (const auto& [text, cycles] : links) {
    machine::NetworkLink link = machine::parse_link(text, names);
    const std::vector<std::pair<std::string, int*>> known = {{"word_cycles", &link.parameters.word_cycles},
                                                             {"token_cycles", &link.parameters.token_cycles},
                                                             {"enter_cycles", &link.parameters.enter_cycles},
                                                             {"exit_cycles", &link.parameters.exit_cycles}};
    for (const auto& [key, value] : cycles) {
      const auto name = key.cast<std::string>();
      const auto found = std::ranges::find(known, name, &std::pair<std::string, int*>::first);
      if (found == known.end()) {
        std::vector<std::string> all;
        for (const auto& row : known) all.push_back(row.first);
        throw machine::NetworkError(
            fmt::format("link {}: no such key {}; known are {}", text, name, fmt::join(all, ", ")));
      }
      *found->second = value.cast<int>();
    }
    d.links.push_back(link);
  }
  for (const py::handle given : memories) {
    const auto memory = given.cast<py::dict>();
    d.memories.push_back({memory["name"].cast<std::string>(),
                          memory["words"].cast<c40::Address>(),
                          memory["waits"].cast<int>(),
                          memory["places"].cast<std::vector<std::pair<std::size_t, c40::Address>>>(),
                          memory["dual_port"].cast<bool>(),
                          {}});
    for (const auto& pin : memory["pins"].cast<std::vector<std::optional<std::string>>>())
      d.memories.back().pins.push_back(pin ? machine::interrupt_pin_named(*pin) : std::nullopt);
  }
  try {
    for (const std::string& net : nets) d.nets.push_back(machine::parse_net(net, names));
  } catch (const std::invalid_argument& error) {
    throw machine::NetworkError(error.what());
  }
  return std::make_unique<machine::Network>(std::move(d), turn_order);
}

std::unique_ptr<machine::Network> network_from_file(const std::string& path, const py::function& program,
                                                    std::uint64_t turn_order) {
  machine::NetworkDescription read =
      machine::read_network(path, [&](const std::string& file) { return program(file).cast<toolchain::Image>(); });
  for (const machine::NetworkChip& chip : read.chips) python::warn_of(chip.board);
  return std::make_unique<machine::Network>(std::move(read), turn_order);
}
