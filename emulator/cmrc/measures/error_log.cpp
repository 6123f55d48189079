#include "cmrc/measures/error_log.hpp"
#include "report/events/event.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace cmrc {
namespace {

using Place = std::array<double, 3>;

double distance(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// The place of the load, or of an AGV, at each recorded instant.
class RecordedPath {
 public:
  RecordedPath(const plant::Dock& dock, Robot robot) {
    const auto& rows = dock.signals();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool agv = robot > 0;
      if (agv && (robot > dock.agv_signals().size() || i >= dock.agv_signals()[robot - 1].size())) break;
      times_.push_back(rows[i].time);
      places_.push_back(agv ? Place{dock.agv_signals()[robot - 1][i].x, dock.agv_signals()[robot - 1][i].y, 0}
                            : rows[i].payload);
    }
  }
  Place at(Time time) const {
    if (times_.empty()) return {};
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return places_.front();
    if (after == times_.end()) return places_.back();
    const auto i = static_cast<std::size_t>(after - times_.begin());
    const double u =
        static_cast<double>((time - times_[i - 1]).count()) / static_cast<double>((times_[i] - times_[i - 1]).count());
    Place place{};
    for (std::size_t k = 0; k < 3; ++k) place[k] = places_[i - 1][k] + u * (places_[i][k] - places_[i - 1][k]);
    return place;
  }
  double farthest(Time from, Time to) const {
    const Place start = at(from);
    double most = distance(start, at(to));
    for (auto i = std::lower_bound(times_.begin(), times_.end(), from) - times_.begin();
         i < std::ssize(times_) && times_[static_cast<std::size_t>(i)] <= to; ++i)
      most = std::max(most, distance(start, places_[static_cast<std::size_t>(i)]));
    return most;
  }

 private:
  std::vector<Time> times_;
  std::vector<Place> places_;
};

constexpr std::array<std::string_view, 6> joints = {"travel", "slew",   "luff",
                                                    "hoist",  "rotate", "trolley"};  // numbered as in timed events

/// The joint of a drives' channel, numbered as in timed events.
unsigned joint_of(unsigned channel, bool gantry) {
  static constexpr std::array<unsigned, 5> of_gantry = {slew_joint, 0, trolley_joint, 3, 4};
  return gantry ? of_gantry.at(channel) : channel;
}

std::string_view name(ErrorOrigin origin) {
  switch (origin) {
    case ErrorOrigin::following: return "following error";
    case ErrorOrigin::fault: return "drive fault";
    case ErrorOrigin::late: return "drive time-out";
    case ErrorOrigin::encoder: return "encoder";
    case ErrorOrigin::sway: return "sway sensor";
    case ErrorOrigin::landing: return "landing";
    case ErrorOrigin::block: return "block given up";
    case ErrorOrigin::overspeed: return "drive overspeed";
    case ErrorOrigin::saturation: return "drive saturated";
    case ErrorOrigin::heat: return "drive overheated";
  }
  return "";
}

std::string_view name(Response response) {
  switch (response) {
    case Response::none: return "";
    case Response::stop: return "stop";
    case Response::hold: return "hold";
    case Response::set_down: return "set down";
    case Response::retry: return "retry";
    case Response::second_sensor: return "second sensor";
  }
  return "";
}

/// Timed events that can cause an error of a joint or axis.
std::vector<std::string_view> causes(const ErrorEntry& entry) {
  switch (entry.origin) {
    case ErrorOrigin::fault: return {"fail_drive"};
    case ErrorOrigin::encoder: return {"stick_encoder", "stick_drive_speed"};
    case ErrorOrigin::following: return {"fail_drive", "stick_encoder"};
    case ErrorOrigin::sway: return {entry.sensor == 0 ? "stick_sway" : "stick_second_sway"};
    default: return {};
  }
}

/// How long the cause of such an error has lasted at the least when the error is noticed. Only a failed drive shows a
/// fault, however late that is read.
Time lasts(const ErrorEntry& entry, const Config::Errors& limits) {
  switch (entry.origin) {
    case ErrorOrigin::following: return report::from_seconds(limits.following_ms * 1e-3);
    case ErrorOrigin::encoder: return report::from_seconds(limits.encoder_ms * 1e-3);
    case ErrorOrigin::sway: return limits.sway_samples * plant::tick_latches * plant::latch_period;
    default: return entry.noticed;
  }
}

/// The dock's event is a trip of one of the error's joints.
bool trips(const ErrorEntry& entry, bool gantry, const plant::Event& event) {
  const auto channels = plant::drive_channels(gantry ? plant::CraneKind::gantry : plant::CraneKind::slewing);
  const auto channel = static_cast<unsigned>(std::ranges::find(channels, event.index) - channels.begin());
  return (entry.of >> channel & 1) != 0 &&
         static_cast<int>(event.values[0]) == static_cast<int>(entry.origin) - static_cast<int>(ErrorOrigin::overspeed);
}

void find_beginning(const ErrorEntry& entry, const Config& config, const plant::Dock& dock,
                    report::HandledError& handled) {
  const bool gantry = config.dock.crane == CraneMachine::gantry;
  const auto concerns = [&](unsigned number) {
    for (unsigned bit = 0; bit < plant::joint_count; ++bit) {
      if ((entry.of >> bit & 1) != 0 && (entry.origin == ErrorOrigin::sway ? bit : joint_of(bit, gantry)) == number)
        return true;
    }
    return false;
  };
  const auto meet = [&](Time time, const std::string& because) {
    if (time <= entry.noticed && (!handled.happened || time >= *handled.happened))
      handled.happened = time, handled.because = because;
  };
  const auto names = causes(entry);
  const Time begun = entry.noticed - lasts(entry, config.errors);
  for (const TimedEvent& event : config.events) {
    if (std::ranges::find(names, event.action) == names.end() || !concerns(event.number)) continue;
    const auto over = [&](const TimedEvent& later) {
      const bool after = later.at_s > event.at_s || (later.at_s == event.at_s && &later > &event);
      return after && report::from_seconds(later.at_s) < begun && undoes(later, event);
    };
    if (std::ranges::none_of(config.events, over)) meet(report::from_seconds(event.at_s), describe(event));
  }
  const bool tripped = entry.origin >= ErrorOrigin::overspeed;
  if (entry.origin != ErrorOrigin::late && !tripped) return;
  for (const plant::Event& event : dock.events()) {
    if (event.kind == (tripped ? plant::EventKind::drive_tripped : plant::EventKind::drive_stopped) &&
        (!tripped || trips(entry, gantry, event)))
      meet(event.time, plant::name(event.kind));
  }
}

}  // namespace

std::vector<report::HandledError> handled_errors(std::span<const ErrorEntry> entries, const Config& config,
                                                 const plant::Dock& dock, Time end,
                                                 const std::function<std::string(Word kind)>& block_name) {
  std::vector<report::HandledError> all;
  std::map<unsigned, RecordedPath> ways;  // by robot
  for (const ErrorEntry& entry : entries) {
    report::HandledError handled;
    handled.origin = name(entry.origin);
    handled.robot = entry.robot == 0 ? "crane" : "agv " + std::to_string(entry.robot - 1);
    if (entry.origin == ErrorOrigin::block) handled.of.push_back(block_name(entry.of));
    for (unsigned bit = 0; bit < plant::joint_count && entry.origin != ErrorOrigin::block; ++bit) {
      if ((entry.of >> bit & 1) == 0) continue;
      if (entry.origin == ErrorOrigin::sway)
        handled.of.emplace_back(bit == 0 ? "alpha" : "beta");
      else
        handled.of.emplace_back(joints.at(joint_of(bit, config.dock.crane == CraneMachine::gantry)));
    }
    find_beginning(entry, config, dock, handled);
    handled.noticed = entry.noticed;
    handled.decided = entry.decided;
    handled.response = name(entry.response);
    handled.done = entry.done;
    handled.cleared = entry.cleared;
    handled.stands = entry.stands && !entry.cleared;
    const RecordedPath& way = ways.try_emplace(entry.robot, dock, entry.robot).first->second;
    const Time begin = handled.happened.value_or(handled.noticed);
    handled.moved_until_noticed_m = distance(way.at(begin), way.at(handled.noticed));
    if (handled.done) handled.moved_until_done_m = distance(way.at(begin), way.at(*handled.done));
    handled.moved_most_m =
        way.farthest(begin, handled.cleared.value_or(entry.stands ? end : handled.done.value_or(end)));
    all.push_back(std::move(handled));
  }
  return all;
}

}  // namespace cmrc
