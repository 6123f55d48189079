#pragma once
// What the files that bind networks share.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "machine/networks/network.hpp"
#include "python/bindings/bindings.hpp"

/// A network from its parts as Python gives them. \throws machine::NetworkError
std::unique_ptr<machine::Network> made_network(const py::list& chips,
                                               const std::vector<std::pair<std::string, py::dict>>& links,
                                               const std::optional<std::string>& topology, const py::list& memories,
                                               const std::vector<std::string>& nets, std::uint64_t turn_order);
/// A network from a file; `program` gives the program of a file. \throws machine::NetworkError
std::unique_ptr<machine::Network> network_from_file(const std::string& path, const py::function& program,
                                                    std::uint64_t turn_order);
