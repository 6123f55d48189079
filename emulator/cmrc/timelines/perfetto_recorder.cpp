#include "cmrc/timelines/perfetto_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <stdexcept>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/timeline.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "machine/system/observer.hpp"

namespace cmrc {
namespace {

using report::EventKind;
using Trace = report::PerfettoTrace;

constexpr std::array<std::string_view, held_up_count> held_up_names = {"bus_a_ps", "bus_b_ps", "list_ps"};
constexpr std::array<std::string_view, held_up_count> wait_names = {"bus A", "bus B", "list"};

void add_held_up(std::vector<Trace::Note>& notes, const std::array<std::int64_t, held_up_count>& held_up) {
  for (std::size_t i = 0; i < held_up_count; ++i) {
    if (held_up[i] != 0) notes.push_back({held_up_names[i], held_up[i]});
  }
}

/// An instant within the slice of a block that was claimed at `claimed` and was in the way from `from` to `to`. It is
/// at least a nanosecond after the slice's beginning: of two events at one time the one written first comes first, and
/// the slice may be written later.
Time inside(Time claimed, Time from, Time to) {
  using std::chrono::floor, std::chrono::nanoseconds;
  constexpr Time one = nanoseconds{1};
  return std::max<Time>(floor<nanoseconds>(claimed) + one, std::min(from, Time(floor<nanoseconds>(to)) - one));
}

}  // namespace

PerfettoRecorder::PerfettoRecorder(Simulation& simulation, std::ostream& out, PerfettoDetail detail,
                                   report::Window window)
    : simulation_(simulation),
      detail_(detail),
      window_(window),
      kinds_(job_kinds(simulation.config().tasks)),
      causes_(Simulation::causes()),
      trace_(out),
      buses_(add_tracks()),
      processes_group_(trace_.add_group("processes", 0, "Processes of the crane and the AGVs")),
      events_(trace_.add_slices("events")),
      plant_(trace_, simulation.dock(), window) {
  simulation.listen(*this);
  simulation.watch(*this);
}

// In the order of their display.
PerfettoBuses PerfettoRecorder::add_tracks() {
  const machine::Machine& machine = simulation_.machine();
  const bool all = detail_ == PerfettoDetail::all;
  const Trace::Track dsps =
      trace_.add_group("DSPs", 0, "The state of each DSP. In gaps it is asleep, until its doorbell rings");
  for (unsigned slot = 0; slot < machine.slots(); ++slot) {
    Dsp dsp{.track = trace_.add_slices(fmt::format("DSP {}", slot), dsps,
                                       "Within the executive the block that it runs, by kind")};
    if (all)
      dsp.waits =
          trace_.add_slices(fmt::format("DSP {} waits", slot), dsp.track, "Accesses for which it waited, by window");
    dsps_.push_back(dsp);
  }
  const Trace::Track host = trace_.add_group("host");
  refreshes_.emplace(trace_, "refreshes", host);
  list_length_ = trace_.add_counter("list length", "blocks", host);
  if (all) list_owner_ = trace_.add_slices("list held by", host);
  jobs_group_ = trace_.add_group("jobs", 0, "From release to end, and late: from the deadline to the end");
  misses_ = trace_.add_slices("misses", jobs_group_, "Each missed job at the end of its account: what it waited for");
  return PerfettoBuses(trace_, machine, detail_ != PerfettoDetail::tasks, window_);
}

// ---- DSPs ----

void PerfettoRecorder::interval(const DspInterval& interval) {
  Dsp& dsp = dsps_.at(interval.slot);
  const bool awake = interval.doing == SlotState::awake || interval.doing == SlotState::busy;
  if (!awake)
    sleep(dsp, interval.from);
  else if (!dsp.awake)
    dsp.awake = interval.from;
  // Also outside the window: a slice that extends into it is drawn whole.
  if (interval.doing == SlotState::awake)
    for (std::size_t i = 0; i < held_up_count; ++i) dsp.held_up[i] += interval.held_up[i];
  if (!within(interval.from, interval.to)) return;
  if (awake && trace_.depth(dsp.track) == 0) trace_.begin(dsp.track, *dsp.awake, "executive");
  if (interval.doing == SlotState::busy) {
    block(dsp, interval);
  } else if (interval.doing == SlotState::off) {
    trace_.begin(dsp.track, interval.from, "off");
    trace_.end(dsp.track, interval.to);
  }
}

void PerfettoRecorder::block(Dsp& dsp, const DspInterval& interval) {
  const TakenBlock& block = interval.block;
  std::vector<Trace::Note> notes = {{"job", block.job.number},
                                    {"generation", static_cast<std::int64_t>(block.generation)}};
  if (block.job.robot != 0) notes.push_back({"robot", static_cast<std::int64_t>(block.job.robot)});
  add_held_up(notes, interval.held_up);
  if (detail_ == PerfettoDetail::all) {
    for (std::size_t i = 0; i < interval.cycles.size(); ++i) {
      if (interval.cycles[i] != 0) notes.push_back({causes_.at(i), interval.cycles[i]});
    }
  }
  const std::string end = report::name(interval.end);
  if (interval.end != report::Run::End::done) notes.push_back({"end", end});
  trace_.begin(dsp.track, interval.from, kinds_.at(block.job.kind), notes);
  trace_.end(dsp.track, interval.to);
}

void PerfettoRecorder::sleep(Dsp& dsp, Time at) {
  dsp.awake.reset();
  const auto held_up = std::exchange(dsp.held_up, {});
  if (trace_.depth(dsp.track) == 0) return;
  std::vector<Trace::Note> notes;
  if (detail_ != PerfettoDetail::tasks) add_held_up(notes, held_up);  // a fifteenth of a long file
  trace_.end(dsp.track, at, notes);
}

void PerfettoRecorder::held_up(unsigned slot, machine::Window window, Time from, Time to) {
  intervals_.held_up(slot, window, from, to);
  Dsp& dsp = dsps_.at(slot);
  if (!dsp.waits || from >= to || !within(from, to)) return;
  trace_.begin(*dsp.waits, from, wait_names[window == machine::Window::a ? 0 : 1]);
  trace_.end(*dsp.waits, to);
}

void PerfettoRecorder::list(unsigned owner, Time at) {
  intervals_.list(owner, at);
  if (!list_owner_) return;
  if (owns_list_ && within(owns_list_->second, at)) {
    const unsigned held = owns_list_->first;
    trace_.begin(*list_owner_, owns_list_->second,
                 held == machine::host_owner ? std::string("host") : fmt::format("DSP {}", held - 1));
    trace_.end(*list_owner_, at);
  }
  owns_list_.reset();
  if (owner != Timeline::nobody) owns_list_ = {owner, at};
}

// ---- jobs ----

std::string PerfettoRecorder::robot(const report::JobName& job) const {
  return job.robot == 0 ? std::string() : fmt::format(" {}", job.robot - 1);
}

PerfettoLanes& PerfettoRecorder::jobs_of(const report::JobName& job) {
  const std::pair key{job.kind, job.robot};
  const auto found = jobs_.find(key);
  if (found != jobs_.end()) return found->second;
  return jobs_.try_emplace(key, trace_, kinds_.at(job.kind) + robot(job), jobs_group_).first->second;
}

void PerfettoRecorder::ended(const EndedJob& job) {
  if (job.skipped || !within(job.released, job.end)) return;
  const std::string outcome = report::name(job.outcome);
  std::vector<Trace::Note> notes = {{"job", job.job.number}};
  if (job.deadline) notes.push_back({"deadline_ps", job.deadline->count()});
  if (job.outcome != report::Outcome::on_time) notes.push_back({"outcome", outcome});
  std::optional<Inner> late;
  if (job.deadline && job.end > *job.deadline) late = Inner{"late", std::max(*job.deadline, job.released)};
  jobs_of(job.job).slice(std::min(job.released, job.end), job.end, kinds_.at(job.job.kind), notes,
                         late ? &*late : nullptr);
}

void PerfettoRecorder::missed(const MissedWaits& waits) {
  const MissedJob& job = waits.job;
  if (!window_.contains(job.end)) return;
  std::vector<Trace::Note> notes = {{"job", job.name.number}, {"robot", static_cast<std::int64_t>(job.name.robot)}};
  if (job.deadline) notes.push_back({"lateness_ps", (job.end - *job.deadline).count()});
  std::vector<std::string> names;
  names.reserve(report::wait_count);
  for (std::size_t i = 0; i < waits.waits.size(); ++i) {
    if (waits.waits[i] == 0) continue;
    names.push_back(report::name(static_cast<report::Wait>(i)) + "_ps");
    notes.push_back({names.back(), waits.waits[i]});
  }
  std::int64_t execution = 0;
  for (const std::int64_t ps : job.execution) execution += ps;
  if (execution != 0) notes.push_back({"execution_ps", execution});
  if (job.previous) notes.push_back({"previous", *job.previous});

  const std::string title = kinds_.at(job.name.kind) + robot(job.name);
  std::vector<Trace::Flow> flows;
  for (const report::BlockingJob& behind : waits.behind) {
    if (!window_.contains(behind.from)) continue;
    flows.push_back(++last_flow_);
    const Trace::Note there[] = {{"job", job.name.number},
                                 {"from_ps", behind.from.count()},
                                 {"to_ps", behind.to.count()},
                                 {"share_ps", behind.share}};
    trace_.instant(dsps_.at(behind.slot).track, inside(behind.claimed, behind.from, behind.to),
                   "in the way of " + title, there, std::span(flows).last(1));
  }
  trace_.instant(misses_, job.end, title + " " + report::name(job.outcome), notes, {}, flows);
}

// ---- host ----

void PerfettoRecorder::refreshed(const RefreshTimes& times, Time end, std::size_t blocks) {
  if (!within(times.began, end)) return;
  refreshes_->slice(times.began, end, "refresh");
  if (length_reported_ == blocks) return;
  trace_.count(list_length_, end, static_cast<std::int64_t>(blocks));
  length_reported_ = blocks;
}

void PerfettoRecorder::refreshing(const RefreshTimes& times, Time now) {
  const Trace::Note notes[] = {{"end", "running"}};
  if (within(times.began, now)) refreshes_->slice(times.began, now, "refresh", notes);
}

// ---- processes and events ----

PerfettoLanes& PerfettoRecorder::processes_of(const std::string& robot) {
  const auto found = processes_.find(robot);
  if (found != processes_.end()) return found->second;
  return processes_.try_emplace(robot, trace_, robot, processes_group_).first->second;
}

void PerfettoRecorder::process_runs(unsigned number, unsigned agv) {
  under_way_[{number, agv}] = {simulation_.time(), true};
}

// The event names the AGV also for a process of the crane, which is then at work for this AGV.
void PerfettoRecorder::process(const report::Event& event) {
  const auto [number, started, agv] = std::tuple(event.arguments[0], event.arguments[1], event.arguments[2]);
  const std::pair key{number, agv};
  if (started != 0) {
    under_way_[key] = {event.time, false};
    return;
  }
  const auto found = under_way_.find(key);
  if (found == under_way_.end() || event.time < found->second.since) return;  // it had ended before the snapshot
  const UnderWay run = found->second;
  under_way_.erase(found);
  if (!within(run.since, event.time)) return;
  const Process* row = simulation_.config().processes.find(number);
  const Robots robots = row == nullptr ? Robots::agv : row->robot;
  const bool of_agv = agv != 0 && robots == Robots::agv;
  std::vector<Trace::Note> notes;
  if (agv != 0 && !of_agv) notes.push_back({"agv", static_cast<std::int64_t>(agv) - 1});
  if (run.earlier) notes.push_back({"begun", "before the snapshot"});
  processes_of(of_agv                   ? fmt::format("agv {}", agv - 1)
               : robots == Robots::none ? "no robot"
                                        : "crane")
      .slice(run.since, event.time, fmt::format("{} {}", number, row == nullptr ? std::string("process") : row->name),
             notes);
}

void PerfettoRecorder::event(const report::Event& event) {
  switch (event.kind) {
    case EventKind::process: return process(event);
    case EventKind::requeue:
    case EventKind::fault:
    case EventKind::reset:
    case EventKind::fence:
    case EventKind::landed:
    case EventKind::locked:
    case EventKind::opened:
    case EventKind::delivered:
    case EventKind::starved:
    case EventKind::scripted:
    case EventKind::set:
    case EventKind::error:
    case EventKind::control: break;
    default: return;
  }
  if (!window_.contains(event.time)) return;
  const auto names = report::argument_names(event.kind);
  std::vector<Trace::Note> notes;
  for (std::size_t i = 0; i < names.size() && !names[i].empty(); ++i)
    notes.push_back({names[i], static_cast<std::int64_t>(event.arguments[i])});
  trace_.instant(events_, event.time, report::name(event.component) + " " + report::name(event.kind), notes);
}

void PerfettoRecorder::failed() {
  try {
    throw;
  } catch (const std::exception& error) {
    if (!problem_) problem_ = error.what();
  }
}

void PerfettoRecorder::finish() {
  if (problem_) throw std::runtime_error(*problem_);
  const Time now = simulation_.machine().time();
  intervals_.finish(now);
  for (Dsp& dsp : dsps_) sleep(dsp, now);
  simulation_.close_watch(*this);
  list(Timeline::nobody, now);
  while (!under_way_.empty()) {
    const auto [number, robot] = under_way_.begin()->first;
    process(
        {std::max(now, under_way_.begin()->second.since), report::host, EventKind::process, {number, 0, robot, 0, 0}});
  }
  buses_.finish();
}

}  // namespace cmrc
