#include "cmrc/run/snapshot.hpp"

#include <utility>

#include "state/archive.hpp"
#include "state/file.hpp"

namespace cmrc {

namespace {

constexpr std::string_view run_state = "run";

struct Content {
  report::Time time{};
  std::string configuration, files, state;  // the state comes last: places of its tables count from its beginning

  void list_state(state::Visitor& list) {
    list("time", time);
    list("configuration", configuration);
    list("files", files);
    list("state", state);
  }
};

}  // namespace

Snapshot::Snapshot(report::Time time, std::string configuration, std::string files, state::Saved state)
    : time_(time),
      configuration_(std::move(configuration)),
      files_(std::move(files)),
      state_(std::make_shared<const state::Saved>(std::move(state))) {}

std::string Snapshot::to_bytes() const {
  state::Saved whole = state::save_with_tables(Content{time_, configuration_, files_, state_->text});
  const std::size_t head = whole.text.size() - state_->text.size();
  for (state::Table table : state_->tables) table.offset += head, whole.tables.push_back(table);
  return state::seal(run_state, {}, std::move(whole));
}

Snapshot Snapshot::from_bytes(std::string_view bytes) {
  Content content;
  state::Saved whole = state::opened(bytes, run_state, {});
  state::load(content, whole.text);
  const std::size_t head = whole.text.size() - content.state.size();
  for (state::Table& table : whole.tables) table.offset -= head;
  return {content.time,
          std::move(content.configuration),
          std::move(content.files),
          {std::move(content.state), std::move(whole.tables)}};
}

}  // namespace cmrc
