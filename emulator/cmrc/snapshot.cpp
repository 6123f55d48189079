#include "cmrc/snapshot.hpp"

#include <utility>

#include "state/archive.hpp"
#include "state/file.hpp"

namespace cmrc {

namespace {

constexpr std::string_view kind = "run";

struct Content {
  report::Time time{};
  std::string configuration, files, state;

  void list_state(state::Visitor& list) {
    list("time", time);
    list("configuration", configuration);
    list("files", files);
    list("state", state);
  }
};

}  // namespace

Snapshot::Snapshot(report::Time time, std::string configuration, std::string files, std::string state)
    : time_(time), configuration_(std::move(configuration)), files_(std::move(files)), state_(std::make_shared<const std::string>(std::move(state))) {}

std::string Snapshot::to_bytes() const { return state::seal(kind, {}, state::save(Content{time_, configuration_, files_, *state_})); }

Snapshot Snapshot::from_bytes(std::string_view bytes) {
  Content content;
  state::load(content, state::opened(bytes, kind, {}));
  return {content.time, std::move(content.configuration), std::move(content.files), std::move(content.state)};
}

}  // namespace cmrc
