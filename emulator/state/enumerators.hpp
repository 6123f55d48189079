#pragma once
/// The enumerators of an enumeration, as the compiler knows them. Rows and names that belong to an enumeration are
/// checked against them: an entry that is appended without its row does not compile.
#include <cstddef>
#include <string_view>
#include <utility>

namespace state {

/// "heat" of `plant::Trip::heat`; empty if no enumerator has the value. C++20 has no reflection, but the compiler's
/// name of a function names its template argument: "plant::Trip::heat", or "(plant::Trip)3" without an enumerator.
template <auto value>
consteval std::string_view enumerator_name() {
  std::string_view name = __PRETTY_FUNCTION__;
  name = name.substr(0, name.find_first_of(";]", name.find("value = ")));
  const std::size_t before = name.find_last_of(":)");
  return name[before] == ')' ? std::string_view() : name.substr(before + 1);
}

/// The number of consecutive enumerators from 0 on.
template <class Enum, std::size_t from = 0>
consteval std::size_t enumerator_count() {
  if constexpr (enumerator_name<static_cast<Enum>(from)>().empty())
    return from;
  else
    return enumerator_count<Enum, from + 1>();
}

/// Whether `holds(value, name)` is true for each enumerator whose value is 0 to 127.
template <class Enum>
constexpr bool all_enumerators(auto holds) {
  return [&]<std::size_t... value>(std::index_sequence<value...>) {
    return ((enumerator_name<static_cast<Enum>(value)>().empty() ||
             holds(static_cast<Enum>(value), enumerator_name<static_cast<Enum>(value)>())) &&
            ...);
  }(std::make_index_sequence<128>());
}

}  // namespace state
