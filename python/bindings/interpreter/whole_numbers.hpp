#pragma once
// Whole numbers from Python. Every source of the module includes this first (python/CMakeLists.txt), since pybind11
// must not have made its own casters before: they cut off what is behind the point of a NumPy float, Decimal or
// Fraction.
#include <pybind11/cast.h>

#include <limits>
#include <type_traits>

namespace pybind11::detail {

/// Takes what Python takes for an index, if it is in the range of T.
template <class T>
struct whole_number_caster {
  PYBIND11_TYPE_CASTER(T, io_name("typing.SupportsInt | typing.SupportsIndex", "int"));

  bool load(handle source, bool) {
    if (!source || !PyIndex_Check(source.ptr())) return false;
    const auto number = reinterpret_steal<object>(PyNumber_Index(source.ptr()));
    if (!number) {  // an array of several numbers
      PyErr_Clear();
      return false;
    }
    using Wide = std::conditional_t<std::is_signed_v<T>, long long, unsigned long long>;
    Wide wide;
    if constexpr (std::is_signed_v<T>)
      wide = PyLong_AsLongLong(number.ptr());
    else
      wide = PyLong_AsUnsignedLongLong(number.ptr());
    if (PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      return false;
    }
    value = static_cast<T>(wide);
    return wide >= Wide{std::numeric_limits<T>::min()} && wide <= Wide{std::numeric_limits<T>::max()};
  }

  static handle cast(T number, return_value_policy, handle) {
    if constexpr (std::is_signed_v<T>)
      return PyLong_FromLongLong(number);
    else
      return PyLong_FromUnsignedLongLong(number);
  }
};

template <>
struct type_caster<signed char> : whole_number_caster<signed char> {};
template <>
struct type_caster<unsigned char> : whole_number_caster<unsigned char> {};
template <>
struct type_caster<short> : whole_number_caster<short> {};
template <>
struct type_caster<unsigned short> : whole_number_caster<unsigned short> {};
template <>
struct type_caster<int> : whole_number_caster<int> {};
template <>
struct type_caster<unsigned> : whole_number_caster<unsigned> {};
template <>
struct type_caster<long> : whole_number_caster<long> {};
template <>
struct type_caster<unsigned long> : whole_number_caster<unsigned long> {};
template <>
struct type_caster<long long> : whole_number_caster<long long> {};
template <>
struct type_caster<unsigned long long> : whole_number_caster<unsigned long long> {};

}  // namespace pybind11::detail
