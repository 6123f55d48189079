#include "report/json/errors_json.hpp"

namespace report {

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json errors_json(const std::vector<HandledError>& errors) {
  const auto seconds = [](const std::optional<Time>& time) {
    return time ? Json(report::seconds(*time)) : Json(nullptr);
  };
  Json list = Json::array();
  for (const HandledError& of : errors)
    list.push_back({{"origin", of.origin},
                    {"robot", of.robot},
                    {"of", of.of},
                    {"happened_s", seconds(of.happened)},
                    {"because", of.happened ? Json(of.because) : Json(nullptr)},
                    {"noticed_s", seconds(of.noticed)},
                    {"decided_s", seconds(of.decided)},
                    {"response", of.decided ? Json(of.response) : Json(nullptr)},
                    {"done_s", seconds(of.done)},
                    {"cleared_s", seconds(of.cleared)},
                    {"stands", of.stands},
                    {"moved_until_noticed_m", of.moved_until_noticed_m},
                    {"moved_until_done_m", of.moved_until_done_m ? Json(*of.moved_until_done_m) : Json(nullptr)},
                    {"moved_most_m", of.moved_most_m}});
  return list;
}

}  // namespace report
