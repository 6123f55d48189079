// The schema: one entry per key, in config_keys_*.cpp.
#include "cmrc/configuration/config_keys.hpp"

#include <utility>

namespace cmrc {
namespace schema {
namespace {

/// \param get a Member, or the like with a state of its own
template <class T, class Get>
Key entry(Key::Type type, std::string name, Get get, std::string unit, double minimum, double maximum,
          std::string meaning, std::string source) {
  return {std::move(name),
          type,
          std::move(unit),
          minimum,
          maximum,
          {},
          std::move(meaning),
          std::move(source),
          [get](Config& config, const Value& value) { get(config) = std::get<T>(value); },
          [get](const Config& config) { return Value{get(const_cast<Config&>(config))}; }};
}

}  // namespace

Key integer(std::string name, Member<std::int64_t> get, std::string unit, double minimum, double maximum,
            std::string meaning, std::string source) {
  return entry<std::int64_t>(Key::Type::integer, std::move(name), get, std::move(unit), minimum, maximum,
                             std::move(meaning), std::move(source));
}

Key number(std::string name, Member<double> get, std::string unit, double minimum, double maximum, std::string meaning,
           std::string source) {
  return entry<double>(Key::Type::number, std::move(name), get, std::move(unit), minimum, maximum, std::move(meaning),
                       std::move(source));
}

Key boolean(std::string name, Member<bool> get, std::string meaning, std::string source) {
  return entry<bool>(Key::Type::boolean, std::move(name), get, "", 0, 1, std::move(meaning), std::move(source));
}

Key text(std::string name, Member<std::string> get, std::string meaning, std::string source) {
  return entry<std::string>(Key::Type::text, std::move(name), get, "", 0, 0, std::move(meaning), std::move(source));
}

Key live(Key key) {
  key.live = true;
  return key;
}

Key path(Key key) {
  key.path = true;
  return key;
}

}  // namespace schema

std::span<const Key> keys() {
  static const std::vector<Key> all = [] {
    std::vector<Key> keys = schema::controller_keys();
    for (const auto part : {schema::bus_keys, schema::dock_keys})
      for (Key& key : part()) keys.push_back(std::move(key));
    for (std::size_t i = 0; i < plant_parameters().size(); ++i) {
      const PlantParameter& row = plant_parameters()[i];
      keys.push_back(schema::entry<double>(
          Key::Type::number, row.name, [i](Config& c) -> double& { return c.plant[i]; }, row.unit, row.minimum,
          row.maximum, row.meaning, row.source));
    }
    return keys;
  }();
  return all;
}

std::string_view name(Key::Type type) {
  switch (type) {
    case Key::Type::boolean: return "boolean";
    case Key::Type::integer: return "integer";
    case Key::Type::number: return "number";
    case Key::Type::text: return "string";
    case Key::Type::choice: return "choice";
  }
  return "";
}

}  // namespace cmrc
