#include "page/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <unordered_map>

#include "bus_model/bus.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/machine.hpp"
#include "machine/system/scripted_events.hpp"
#include "page/columns.hpp"
#include "report/events/event.hpp"
#include "report/values/task_account.hpp"
#include "report/values/why_late.hpp"
#include "state/enumerators.hpp"

namespace page {
namespace {

using report::EventKind;

constexpr std::int64_t bus_slices_max = 16'384;
constexpr Time shortest_slice = std::chrono::milliseconds{1};

/// The kind of an interval; from `job` on a job of kind n - `job`.
enum What : std::uint8_t { off, broken, asleep, awake, job };

std::int64_t tick(Time time) { return time / lane_tick; }

Time slice_for(Time span) {
  const Time least{(span.count() + bus_slices_max - 1) / bus_slices_max};
  return std::max(shortest_slice, (least + shortest_slice - Time{1}) / shortest_slice * shortest_slice);
}

template <class Rows, class Value>
std::vector<std::int64_t> values_of(const Rows& rows, Value value) {
  std::vector<std::int64_t> all;
  all.reserve(rows.size());
  for (const auto& row : rows) all.push_back(static_cast<std::int64_t>(value(row)));
  return all;
}

Time end_of(const cmrc::Simulation& simulation) { return report::from_seconds(simulation.config().run.duration_s); }

/// By number, as the columns have them.
template <class Enum>
std::vector<std::string> names() {
  std::vector<std::string> all;
  for (std::size_t value = 0; value < state::enumerator_count<Enum>(); ++value)
    all.push_back(name(static_cast<Enum>(value)));
  return all;
}

}  // namespace

Recorder::Recorder(cmrc::Simulation& simulation, std::size_t stretches)
    : simulation_(simulation),
      most_(stretches),
      from_(simulation.time()),
      bus_slice_(slice_for(end_of(simulation) - from_)),
      samples_(simulation, from_, end_of(simulation)) {
  simulation.listen(*this);
  simulation.watch(*this);
}

// Kind and robot have eight bits each: no task has a larger number of either.
Recorder::JobKey Recorder::key(const report::JobName& name) {
  return static_cast<JobKey>(name.number) << 16 | static_cast<JobKey>(name.robot & 0xFF) << 8 |
         static_cast<JobKey>(name.kind & 0xFF);
}

void Recorder::latched(const plant::Dock& /*dock*/, Time now) {
  if (now % samples_.period() == Time{}) samples_.take(now);
}

void Recorder::interval(const cmrc::DspInterval& interval) {
  if (stretches_.size() >= most_) {
    ++left_out_;
    lanes_until_ = std::min(lanes_until_, interval.from);
    return;
  }
  Lane lane;
  lane.slot = static_cast<std::uint8_t>(interval.slot);
  lane.from = std::max(interval.from, from_);
  lane.to = std::max(interval.to, lane.from);
  lane.held_up = interval.held_up;
  switch (interval.doing) {
    case cmrc::SlotState::off: lane.what = off; break;
    case cmrc::SlotState::asleep: lane.what = asleep; break;
    case cmrc::SlotState::awake: lane.what = awake; break;
    case cmrc::SlotState::busy:
      lane.what = static_cast<std::uint8_t>(job + interval.block.job.kind);
      lane.job = key(interval.block.job);
      lane.end = static_cast<std::uint8_t>(interval.end);
      break;
  }
  stretches_.push_back(lane);
}

void Recorder::ended(const cmrc::EndedJob& ended) {
  if (jobs_.size() >= most_ / 2) {
    lanes_until_ = std::min(lanes_until_, ended.released);
    return;
  }
  const std::int64_t allowed = ended.deadline ? tick(*ended.deadline) - tick(ended.released) + 1 : 0;
  jobs_.push_back({key(ended.job), ended.released, ended.end, allowed, static_cast<std::uint8_t>(ended.outcome),
                   ended.missed, false});
}

void Recorder::on_bus(machine::BusId id, const pci::Attempt& attempt, const machine::Clock& clock) {
  Time from = clock.at(attempt.frame);
  const Time to = clock.at(attempt.last + 1);
  if (from < from_) return;
  const auto number = static_cast<std::size_t>(id);
  if (buses_.size() <= number) buses_.resize(number + 1);
  Bus& bus = buses_[number];
  const auto book = [](std::vector<std::int64_t>& row, std::size_t slice, std::int64_t amount) {
    if (row.size() <= slice) row.resize(slice + 1);
    row[slice] += amount;
  };
  if (attempt.kind != pci::Attempt::Kind::data)
    book(bus.refused, static_cast<std::size_t>((from - from_) / bus_slice_), 1);
  while (from < to) {
    const auto slice = static_cast<std::size_t>((from - from_) / bus_slice_);
    const Time until = std::min(to, from_ + static_cast<std::int64_t>(slice + 1) * bus_slice_);
    book(bus.held[attempt.master], slice, (until - from).count());
    from = until;
  }
}

void Recorder::event(const report::Event& event) {
  const auto note = [&](unsigned slot, bool fails) { failures_[slot].emplace_back(event.time, fails); };
  if (event.kind == EventKind::scripted) {
    const auto action = static_cast<machine::Action>(event.arguments[0]);
    if (action == machine::Action::fail || action == machine::Action::freeze || action == machine::Action::hang)
      note(event.arguments[1], true);
  } else if (event.kind == EventKind::fault) {
    note(event.component - report::first_dsp, true);
  } else if (event.kind == EventKind::reset) {
    note(event.component - report::first_dsp, false);
  }
}

// In order of their beginnings. A DSP that is off counts as failed from its failure to its reset.
std::vector<Recorder::Lane> Recorder::lanes_in_order() {
  std::vector<Lane> all;
  all.reserve(stretches_.size());
  for (Lane lane : stretches_) {
    const auto found = failures_.find(lane.slot);
    if (lane.what != off || found == failures_.end()) {
      all.push_back(lane);
      continue;
    }
    bool fails = false;
    for (const auto& [at, failing] : found->second) {
      if (at > lane.from && at < lane.to && failing != fails) {
        Lane part = lane;
        part.to = at;
        part.what = fails ? broken : off;
        all.push_back(part);
        lane.from = at;
      }
      if (at < lane.to) fails = failing;
    }
    lane.what = fails ? broken : off;
    all.push_back(lane);
  }
  std::ranges::stable_sort(all, {}, [](const Lane& lane) { return std::pair(lane.from, lane.slot); });
  return all;
}

// An interval begins at the end of the one before on its DSP, so only its length is written; for a busy interval also
// its job. A job's number is written minus the number of the job before of the same kind and robot.
void Recorder::put_lanes(Columns& columns) {
  const std::vector<Lane> lanes = lanes_in_order();
  std::unordered_map<JobKey, std::size_t> by_key;
  by_key.reserve(jobs_.size());
  for (std::size_t i = 0; i < jobs_.size(); ++i) by_key[jobs_[i].key] = i;
  columns.whole("lane.slot", values_of(lanes, [](const Lane& lane) { return lane.slot; }));
  columns.whole("lane.what", values_of(lanes, [](const Lane& lane) { return lane.what; }));
  columns.whole("lane.took", values_of(lanes, [](const Lane& lane) { return tick(lane.to) - tick(lane.from); }));
  for (std::size_t by = 0; by < cmrc::held_up_count; ++by) {
    static constexpr std::array<const char*, cmrc::held_up_count> names = {"lane.bus_a", "lane.bus_b", "lane.list"};
    columns.whole(names[by], values_of(lanes, [by](const Lane& lane) { return tick(Time{lane.held_up[by]}); }));
  }
  std::vector<Lane> runs;
  std::ranges::copy_if(lanes, std::back_inserter(runs), [](const Lane& lane) { return lane.what >= job; });
  std::map<std::uint64_t, std::int64_t> before;
  const auto number = [&](JobKey of) {
    const auto value = static_cast<std::int64_t>(of >> 16);
    return value - std::exchange(before[of & 0xFFFF], value);
  };
  const auto of_job = [&](auto value, std::int64_t unknown) {
    return values_of(runs, [&, value, unknown](const Lane& lane) {
      const auto found = by_key.find(lane.job);
      if (found == by_key.end()) return unknown;
      jobs_[found->second].has_run = true;
      return static_cast<std::int64_t>(value(lane, jobs_[found->second]));
    });
  };
  columns.whole("run.number", values_of(runs, [&](const Lane& lane) { return number(lane.job); }));
  columns.whole("run.robot", values_of(runs, [](const Lane& lane) { return lane.job >> 8 & 0xFF; }));
  columns.whole("run.end", values_of(runs, [](const Lane& lane) { return lane.end; }));
  columns.whole("run.waited",
                of_job([](const Lane& lane, const Job& of) { return tick(lane.from) - tick(of.released); }, 0));
  columns.whole("run.allowed", of_job([](const Lane&, const Job& of) { return of.allowed; }, 0));
  columns.whole("run.outcome", of_job([](const Lane&, const Job& of) { return of.outcome; }, 2));
  columns.whole("run.missed", of_job([](const Lane&, const Job& of) { return of.missed; }, 0));
  std::vector<Job> never;
  std::ranges::copy_if(jobs_, std::back_inserter(never), [](const Job& one) { return !one.has_run; });
  std::ranges::stable_sort(never, {}, &Job::released);
  before.clear();
  columns.whole("job.kind", values_of(never, [](const Job& one) { return one.key & 0xFF; }));
  columns.whole("job.robot", values_of(never, [](const Job& one) { return one.key >> 8 & 0xFF; }));
  columns.whole("job.number", values_of(never, [&](const Job& one) { return number(one.key); }));
  columns.whole("job.released", values_of(never, [](const Job& one) { return tick(one.released); }));
  columns.whole("job.took", values_of(never, [](const Job& one) { return tick(one.end) - tick(one.released); }));
  columns.whole("job.allowed", values_of(never, [](const Job& one) { return one.allowed; }));
  columns.whole("job.outcome", values_of(never, [](const Job& one) { return one.outcome; }));
  columns.whole("job.missed", values_of(never, [](const Job& one) { return one.missed; }));
}

// How long each master owned a bus, in thousandths of a slice.
void Recorder::put_buses(Columns& columns, const report::RunReport& report) const {
  const auto slices = static_cast<std::size_t>((simulation_.time() - from_) / bus_slice_ + 1);
  for (std::size_t bus = 0; bus < std::min(buses_.size(), report.buses.size()); ++bus) {
    const std::string name = "bus." + report.buses[bus].name;
    for (const auto& [master, held] : buses_[bus].held) {
      std::vector<std::int64_t> shares =
          values_of(held, [&](std::int64_t ps) { return 1000 * ps / bus_slice_.count(); });
      shares.resize(slices);
      columns.whole(fmt::format("{}.{}", name, report.buses[bus].masters.at(master).name), shares);
    }
    std::vector<std::int64_t> refused = buses_[bus].refused;
    refused.resize(slices);
    columns.whole(name + ".refused", refused);
  }
}

void Recorder::failed() {
  try {
    throw;
  } catch (const std::exception& error) {
    if (!problem_) problem_ = error.what();
  }
}

std::string Recorder::recording(const report::RunReport& report, const std::string& title) {
  if (problem_) throw std::runtime_error(fmt::format("nothing was recorded after an error: {}", *problem_));
  const Time now = simulation_.time();
  samples_.take(now);
  intervals_.finish(now);
  simulation_.close_watch(*this);
  const machine::Clock& clock = simulation_.machine().chip_clock();

  Columns columns;
  nlohmann::json header = {
      {"format", 1},
      {"title", title},
      {"from_s", report::seconds(from_)},
      {"to_s", report::seconds(now)},
      {"tick_ps", lane_tick.count()},
      {"slots", simulation_.machine().slots()},
      {"cycle_s", report::seconds(clock.at(1'000'000'000) - clock.at(0)) / 1e9},
      {"kinds", cmrc::job_kinds(simulation_.config().tasks)},
      {"outcomes", names<report::Outcome>()},
      {"ends", names<report::Run::End>()},
      {"bus_slice_s", report::seconds(bus_slice_)},
      {"stretches_left_out", left_out_},
      {"lanes_until_s", lanes_until_ == Time::max() ? nlohmann::json() : nlohmann::json(report::seconds(lanes_until_))},
  };
  nlohmann::json dock_events = nlohmann::json::array();
  const plant::CraneKind crane = simulation_.dock().config().crane.machine;
  for (const plant::Event& event : simulation_.dock().events())
    if (event.time >= from_ && dock_events.size() < dock_events_max)
      dock_events.push_back({report::seconds(event.time), plant::name(event.kind), plant::object_of(event, crane),
                             plant::values_of(event)});
  header["dock_events"] = dock_events;
  samples_.put(columns, header, simulation_.config().run.ideal ? nullptr : simulation_.reference().get());
  put_lanes(columns);
  put_buses(columns, report);
  columns.text("report", to_json(report));
  return columns.bytes(std::move(header));
}

}  // namespace page
