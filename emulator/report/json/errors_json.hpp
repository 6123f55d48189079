#pragma once
#include <nlohmann/json.hpp>

#include "report/values/handled_error.hpp"

namespace report {

/// `errors_handled` of the report (docs/report.md).
nlohmann::ordered_json errors_json(const std::vector<HandledError>& errors);

}  // namespace report
