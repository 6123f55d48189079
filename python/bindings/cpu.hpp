#pragma once
// Processors by their names in Python.
#include <string>

#include "isa/types.hpp"
#include "python/bindings/bindings.hpp"

/// \throws py::value_error for another name.
inline isa::Cpu cpu_called(const std::string& name) {
  const auto found = isa::cpu_named(name);
  if (!found) throw py::value_error("cpu: \"" + name + "\" is unknown; \"c40\" or \"c3x\" is expected");
  return *found;
}
