#include "cmrc/snapshot.hpp"

#include <charconv>
#include <utility>

#include "state/file.hpp"

namespace cmrc {

namespace {

constexpr std::string_view kind = "run of the dock";

}  // namespace

Snapshot::Snapshot(report::Time time, std::string configuration, std::string files, std::string state)
    : time_(time), configuration_(std::move(configuration)), files_(std::move(files)), state_(std::make_shared<const std::string>(std::move(state))) {}

std::string Snapshot::to_bytes() const {
  const std::string time = std::to_string(time_.count());
  return state::sealed(kind, {time, configuration_, files_, *state_});
}

Snapshot Snapshot::from_bytes(std::string_view bytes) {
  std::vector<std::string> parts = state::opened(bytes, kind, 4);
  report::Time::rep time = 0;
  std::from_chars(parts[0].data(), parts[0].data() + parts[0].size(), time);
  return {report::Time(time), std::move(parts[1]), std::move(parts[2]), std::move(parts[3])};
}

}  // namespace cmrc
