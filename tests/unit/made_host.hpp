#pragma once
// A host that notes what the processes ask of it, and words that are distinct.
#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cmrc/processes/host_services.hpp"
#include "cmrc/tasks/ti_float.hpp"

namespace made {

using cmrc::Word;

/// Each name has a number of its own; areas are far apart, and bits of results are single bits.
inline cmrc::Words words() {
  Word next = 0;
  cmrc::Words all([&](std::string_view) { return next += 0x200; });
  all.cr_base = 0x100'0000;
  all.ag_base = 0x200'0000;
  all.ag_words = 0x10'0000;
  all.agv_unit = 0x300'0000;
  all.agv_unit_words = 0x100;
  all.ag_avoid_beside = all.ag_avoid_limit + 2;
  all.segments_max = all.segment_words = 8;
  all.leg_words = 64;
  all.must_process = 1;
  all.must_trajectory = 0x200;
  all.must_inverse = 0x400;
  all.end_of_leg = 1;
  Word bit = 0x10000;
  for (Word* one : {&all.pid_landed, &all.pid_locked, &all.pid_open, &all.pid_starved, &all.pid_settled,
                    &all.pid_ramp_done, &all.pid_began, &all.pid_steady, &all.pid_windy})
    *one = std::exchange(bit, bit << 1);
  all.torque_wind = 1;
  all.torque_load = 8;
  return all;
}

/// "3.25", as the C40 reads it.
inline std::string number(Word word) { return fmt::format("{:.6g}", cmrc::from_ti_float(word)); }

class Host final : public cmrc::HostServices {
 public:
  std::int64_t now = 0;
  std::int64_t behind = 0;  ///< refreshes by which the path's clock is behind
  bool resting = true;
  std::map<Word, Word> words;
  std::vector<std::pair<cmrc::Task, std::optional<std::int64_t>>> loaded;
  std::vector<std::string> told;

  /// What has been told since the last call, with blanks between.
  std::string news() {
    std::string all;
    for (const std::string& one : std::exchange(told, {})) all += (all.empty() ? "" : " ") + one;
    return all;
  }
  /// The kinds loaded since the last call.
  std::vector<Word> kinds() {
    std::vector<Word> all;
    for (const auto& one : std::exchange(loaded, {})) all.push_back(one.first.kind);
    return all;
  }
  Word take(Word offset) {
    const auto found = words.find(offset);
    if (found == words.end()) return 0xDEAD'DEAD;
    const Word value = found->second;
    words.erase(found);
    return value;
  }

  using HostServices::write;
  std::int64_t tick() const override { return now; }
  void load(const cmrc::Task& task, std::optional<std::int64_t> deadline) override {
    loaded.emplace_back(task, deadline);
  }
  void load_within(const cmrc::Task& task, report::Time) override { load(task, std::nullopt); }
  void drop(const cmrc::Task&, std::int64_t due, std::int64_t) override { told.push_back(fmt::format("drop {}", due)); }
  void drop_within(const cmrc::Task&, std::int64_t due, std::optional<report::Time>) override {
    told.push_back(fmt::format("drop {}", due));
  }
  std::size_t load_tick(const cmrc::Task& task, const cmrc::NominalTick& tick) override {
    load(task, tick.deadline);
    return loaded.size();
  }
  void drop_tick(const cmrc::Task&, const cmrc::NominalTick& tick, std::size_t, report::Wait) override {
    told.push_back(fmt::format("drop {}", tick.number));
  }
  void write(Word offset, std::span<const Word> values) override {
    for (const Word value : values) words[offset++] = value;
  }
  bool servo_resting() const override { return resting; }
  std::int64_t path(std::int64_t refresh) const override { return refresh - behind; }
  void error(Word number, Word, cmrc::Robot, Word phase, Word) override {
    told.push_back(fmt::format("error {} {}", number, phase));
  }
  void control(Word generation, Word) override { told.push_back(fmt::format("control {}", generation)); }
  void process(unsigned number, bool started, cmrc::Robot robot) override {
    told.push_back(fmt::format("process {} {} {}", number, started ? "starts" : "ends", robot));
  }
  void landing_missed(bool last) override { told.emplace_back(last ? "missed-last" : "missed"); }
  void agv_waits(unsigned agv, bool waits) override {
    told.push_back(fmt::format("{}-{}", agv, waits ? "waits" : "leaves"));
  }
  void agv_sent(unsigned agv, std::int64_t interval) override {
    told.push_back(fmt::format("{}-sent-{}", agv, interval));
  }
  void robot_begins(cmrc::Robot, unsigned) override {}
  void leg_begun(cmrc::Robot robot, std::int64_t first, std::int64_t interval, std::int64_t at) override {
    told.push_back(fmt::format("{}-leg-{}-{}@{}", robot, first, interval, at));
  }
  void milestone(cmrc::Robot robot, cmrc::Milestone::Kind kind, std::int64_t number, std::int64_t at) override {
    using enum cmrc::Milestone::Kind;
    const char* name = kind == point        ? "point"
                       : kind == leg_ended  ? "leg-ended"
                       : kind == ramp_begun ? "ramp"
                       : kind == ramp_ended ? "ramp-ended"
                       : kind == locked     ? "locked"
                       : kind == opened     ? "opened"
                                            : "?";
    told.push_back(fmt::format("{}-{}-{}@{}", robot, name, number, at));
  }
};

}  // namespace made
