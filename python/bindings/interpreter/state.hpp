#pragma once
// State as bytes for Python. A state has no version of its own: it is for builds of the same layout alone.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <string_view>

#include "state/archive.hpp"

template <class T>
pybind11::bytes state_bytes(const T& object) {
  return state::save(object);
}

inline pybind11::value_error no_state(std::string_view text, const state::StateError& error) {
  return pybind11::value_error("these " + std::to_string(text.size()) +
                               " bytes are no snapshot of this version: " + error.what());
}

// ValueError if the bytes are no state of this object; the object is then not usable.
template <class T>
void load_state(T& object, const pybind11::bytes& bytes) {
  const std::string_view text = bytes;
  try {
    state::load(object, text);
  } catch (const state::StateError& error) {
    throw no_state(text, error);
  }
}

// The same for a value that is copied as a whole, for pickle.
template <class T>
pybind11::bytes value_bytes(const T& value) {
  return state::save_value(value);
}
template <class T>
T value_of_bytes(const pybind11::bytes& bytes) {
  const std::string_view text = bytes;
  try {
    return state::load_value<T>(text);
  } catch (const state::StateError& error) {
    throw no_state(text, error);
  }
}

// A list of (path, offset, size): the place of each value in state_bytes.
template <class T>
pybind11::list state_leaves(const T& object) {
  state::Lister lister;
  const_cast<T&>(object).list_state(lister);  // NOLINT: a lister only reads
  pybind11::list all;
  for (const state::Leaf& leaf : lister.leaves()) all.append(pybind11::make_tuple(leaf.path, leaf.offset, leaf.size));
  return all;
}

// `class_` gets _state, _load_state, _state_leaves, and _state_difference(other): the first value that differs, or
// None.
template <class T, class Class>
void bind_state(Class& class_) {
  class_.def("_state", &state_bytes<T>)
      .def("_load_state", &load_state<T>, pybind11::arg("state"))
      .def("_state_leaves", &state_leaves<T>)
      .def("_state_difference", &state::difference<T>, pybind11::arg("other"));
}
