#pragma once
// What was not measured is null in JSON.
#include <nlohmann/json.hpp>
#include <optional>

namespace report {

template <class Value>
nlohmann::ordered_json or_null(const std::optional<Value>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace report
