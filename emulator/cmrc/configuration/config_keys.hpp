#pragma once
// The schema's keys: how one is made, and the parts of the list. docs/configuration.md lists the same keys, and a test
// compares the two.
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "state/enumerators.hpp"

namespace cmrc::schema {

/// The parts of the list, in its order. Traces have the number of a key: a new one stands at the end of its table.
std::vector<Key> controller_keys();  ///< run, machine, rates, scheduling, watchdog, host, kernels, load
std::vector<Key> bus_keys();         ///< bus, topology
std::vector<Key> dock_keys();        ///< dock, control, errors, report

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// Gives the member of Config, so that one entry can both read and write it.
template <class T>
using Member = T& (*)(Config&);

// No templates: a key has many neighbours, and each would be compiled again.
Key integer(std::string name, Member<std::int64_t> get, std::string unit, double minimum, double maximum,
            std::string meaning, std::string source);
Key number(std::string name, Member<double> get, std::string unit, double minimum, double maximum, std::string meaning,
           std::string source);
Key boolean(std::string name, Member<bool> get, std::string meaning, std::string source);
Key text(std::string name, Member<std::string> get, std::string meaning, std::string source);

/// `words` in the order of the enumeration's values.
template <class Get, std::size_t count>
Key choice(std::string name, Get get, const char* const (&words)[count], std::string meaning, std::string source) {
  using Enum = std::remove_reference_t<decltype(get(std::declval<Config&>()))>;
  static_assert(count == state::enumerator_count<Enum>(), "each value of the enumeration has one word");
  std::vector<std::string> choices(std::begin(words), std::end(words));
  auto assign = [get, choices](Config& config, const Value& value) {
    for (std::size_t i = 0; i < choices.size(); ++i) {
      if (choices[i] == std::get<std::string>(value)) get(config) = static_cast<Enum>(i);
    }
  };
  auto read = [get, choices](const Config& config) {
    return Value{choices[static_cast<std::size_t>(get(const_cast<Config&>(config)))]};
  };
  return {std::move(name),   Key::Type::choice, "", 0, 0, std::move(choices), std::move(meaning), std::move(source),
          std::move(assign), std::move(read)};
}

/// The same key, marked as changeable by an operator during a run.
Key live(Key key);
/// The same key, marked as the path of a file or a folder.
Key path(Key key);

}  // namespace cmrc::schema

/// Gives the member of Config for a key.
#define FIELD(path) [](Config& c) -> auto& { return c.path; }
