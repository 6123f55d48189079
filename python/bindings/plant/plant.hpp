#pragma once
// The parts of cmrc._core.plant, in the order in which they are bound: what a signature names is bound before it.
#include <pybind11/stl.h>

#include <array>
#include <vector>

#include "python/bindings/bindings.hpp"

void bind_plant_parameters(py::module_& plant);
void bind_plant_surroundings(py::module_& plant);
void bind_plant_places(py::module_& plant);
void bind_plant_layout(py::module_& plant);
void bind_plant_motion(py::module_& plant);
void bind_plant_alone(py::module_& plant);
void bind_plant_records(py::module_& plant);
void bind_plant_dock(py::module_& plant);
void bind_plant_state(py::module_& plant);
void bind_plant_linkage(py::module_& plant);

template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <class T, std::size_t N>
inline constexpr bool is_list<std::array<T, N>> = true;

/// A list as a tuple of copies: an element in Python never points into a list that C++ may move.
template <class List>
py::tuple copied(const List& list) {
  py::tuple all(list.size());
  for (std::size_t n = 0; n < list.size(); ++n) {
    if constexpr (is_list<typename List::value_type>)
      all[n] = copied(list[n]);
    else
      all[n] = py::cast(list[n], py::return_value_policy::copy);
  }
  return all;
}

// A method of no class yet: def_property adds it. Error messages need the signature of a method.
template <class P, class T>
py::cpp_function reader(T P::* member) {
  const py::is_method method{py::handle()};
  if constexpr (is_list<T>)
    return {[member](const P& p) { return copied(p.*member); }, method};
  else
    return {[member](const P& p) -> const T& { return p.*member; }, method,
            py::return_value_policy::reference_internal};
}
template <class P, class T>
py::cpp_function writer(T P::* member) {
  return {[member](P& p, const T& value) { p.*member = value; }, py::is_method{py::handle()}};
}

// Binds a member of P, the type at hand, under its own name. A list is given back as a tuple of copies, and assigned
// whole.
#define FIELD(name) .def_property(#name, reader(&P::name), writer(&P::name))
