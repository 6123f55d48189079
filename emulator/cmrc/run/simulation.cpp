#include "cmrc/run/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "bus_model/bus.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/job_causes.hpp"
#include "cmrc/run/make_report.hpp"
#include "cmrc/run/reference_run.hpp"
#include "cmrc/run/simulation_parts.hpp"
#include "io/stop.hpp"
#include "machine/boards/board_file.hpp"
#include "report/events/event.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

std::unique_ptr<Simulation::Parts> parts_of(const Config& config, std::shared_ptr<Course> course,
                                            std::shared_ptr<const Reference> reference) try {
  return std::make_unique<Simulation::Parts>(config, std::move(course), std::move(reference));
} catch (const machine::BoardError& error) {
  throw ConfigError(fmt::format("machine.board: {}", error.what()));
}

}  // namespace

Simulation::Simulation(const Config& config) : parts_(parts_of(config, nullptr, nullptr)) {}
Simulation::Simulation(const Config& config, std::shared_ptr<Course> course)
    : parts_(parts_of(config, std::move(course), nullptr)) {}
Simulation::Simulation(const Config& config, std::shared_ptr<const Reference> reference)
    : parts_(parts_of(config, nullptr, std::move(reference))) {}
Simulation::~Simulation() = default;

void Simulation::at(const TimedEvent& event) {
  Parts& p = *parts_;
  if (report::from_seconds(event.at_s) < p.now()) {
    refuse(event.origin, "events.at_s", fmt::format("{} s has passed", event.at_s),
           fmt::format("the run is at {:.9g} s", report::seconds(p.now())));
  }
  if (ended() || event.at_s >= p.config.run.duration_s) {
    refuse(event.origin, "events.at_s", fmt::format("{} s is not within the run", event.at_s),
           fmt::format("it ends at {} s", p.config.run.duration_s));
  }
  Config with = p.given_config;
  with.events.push_back(event);
  check_events(with);
  p.check_sets(with.events);
  p.given_config.events.push_back(event);
  p.ideal.forget();
  if (!happens(event, p.config)) return;
  p.config.events.push_back(event);
  p.expect(event);
}

void Simulation::listen(report::EventSink& sink) { parts_->log.listen(sink); }
void Simulation::tap(report::EventSink* sink) { parts_->log.tap(sink); }
void Simulation::watch(RunWatcher& watcher) {
  Parts& p = *parts_;
  p.ledger.introduce(watcher,
                     [&p](std::size_t block) { return p.machine.peek(p.words.block(block) + p.words.generation); });
  p.host.processes().each_running([&](unsigned number, unsigned agv) { watcher.process_runs(number, agv); });
  p.watchers.add(watcher);
  p.observer.watch(&p.watchers);
  p.machine.watch_buses([&p](machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) {
    p.watchers.on_bus(bus, attempt, clock);
  });
}

std::vector<std::string> Simulation::causes() { return job_causes(); }

void Simulation::close_watch(RunWatcher& watcher) {
  Parts& p = *parts_;
  const Time now = p.machine.time();
  p.ledger.close(
      now, [&p](unsigned slot) { return job_causes(p.machine, slot); },
      [&](Ledger& account) { p.host.count_rest(now, account); }, watcher);
  p.observer.close_refreshes(p.host.refresh_under_way().has_value(), now, watcher);
  p.machine.each_attempt_under_way([&](machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) {
    watcher.still_on_bus(bus, attempt, clock);
  });
}

void Simulation::trace(unsigned slot, c40::TraceSink& sink) {
  parts_->traces[slot] = &sink;
  parts_->connect_traces();
}

void Simulation::profile() {
  if (parts_->machine.time() != Time{})
    throw std::logic_error("Simulation::profile: the run has begun; a profile is of a whole run");
  parts_->profile.emplace(parts_->machine);
  parts_->observer.set_profile(&*parts_->profile);
  parts_->connect_traces();
}

report::Profile Simulation::profile_report() const {
  if (!parts_->profile)
    throw std::logic_error("Simulation::profile_report: nothing was counted; Simulation::profile comes before the run");
  return parts_->profile->report(report().tasks, parts_->image, boot_rom_image());
}

bool Simulation::ended() const { return parts_->over(); }
Time Simulation::time() const { return parts_->now(); }

void Simulation::run_until(report::Time time) {
  parts_->require_more_to_come("run_until");
  const auto began = std::chrono::steady_clock::now();
  parts_->resume();
  parts_->run_until(std::min(time, parts_->run_end.end()));
  parts_->elapsed += std::chrono::steady_clock::now() - began;
}

void Simulation::run(const std::function<bool(const Progress&)>& on_progress, report::Time slice, report::Time until) {
  parts_->require_more_to_come("run");
  parts_->resume();
  if (!ended()) parts_->ideal.begin();
  while (!ended() && parts_->now() < until) {
    run_until(std::min(parts_->now() + slice, until));
    bool go_on = !io::stop_asked();
    if (go_on && on_progress)
      go_on = on_progress({parts_->now(), parts_->run_end.end(), static_cast<unsigned>(parts_->dock.delivered()),
                           parts_->ledger.misses()});
    if (!go_on && !ended()) {
      parts_->run_end.interrupt();
      return;
    }
  }
  if (ended()) parts_->log.flush();
}

std::uint64_t Simulation::misses() const { return parts_->ledger.misses(); }

Snapshot Simulation::snapshot() {
  Parts& p = *parts_;
  p.require_no_profile("snapshot");
  p.require_more_to_come("snapshot");
  if (p.now() > settling) p.log.deliver(p.now() - settling);
  constexpr std::size_t all_else = 8 << 20;  // most of a long run's state is its course
  return {p.now(), p.snapshot_key, p.files(), state::save_with_tables(p, p.course->bytes() + all_else)};
}

void Simulation::restore(const Snapshot& snapshot) {
  Parts& p = *parts_;
  p.require_no_profile("restore");
  const std::string& there = snapshot.configuration();
  const std::string& here = p.snapshot_key;
  if (there != here && without_paths(there) != without_paths(here))
    throw SnapshotError(fmt::format("the snapshot is of another configuration: {}",
                                    first_other_line(without_paths(there), without_paths(here))));
  if (snapshot.files() != p.files())  // the same files may have other names
    throw SnapshotError(fmt::format(
        "the snapshot is of another program, layout or board: {}",
        there == here ? "the files that the configuration names have changed since" : first_other_line(there, here)));
  try {
    state::load_or_leave(p, snapshot.state());
  } catch (const state::StateError& error) {
    throw SnapshotError(fmt::format("the snapshot is of another version of the emulator: {}", error.what()));
  }
  p.measure_again();
}

void Simulation::list_state(state::Visitor& list) {
  parts_->list_state(list);
  if (list.loads()) parts_->measure_again();
}

std::optional<std::string> Simulation::difference(const Simulation& other) const {
  return state::difference(*parts_, *other.parts_);
}

std::unique_ptr<Simulation> Simulation::fork() {
  const Snapshot now = snapshot();
  const Parts& p = *parts_;
  const bool same_ideal = p.ideal.given() && p.ideal.given()->key == reference_key(p.original_config);
  auto other = std::make_unique<Simulation>(p.original_config, same_ideal ? p.ideal.given() : nullptr);
  other->restore(now);
  return other;
}

std::unique_ptr<Simulation> Simulation::fork_into(const Config& whole, std::shared_ptr<const Reference> reference) {
  const Parts& p = *parts_;
  const std::string own = key_of(p.given_config), asked = key_of(beginning_of(whole, p.now()));
  if (own != asked)
    throw ConfigError(fmt::format("fork: the requested run begins differently: {}", first_other_line(asked, own)));
  if (ended()) throw ConfigError(fmt::format("fork: the run has ended at {} s", report::seconds(p.now())));
  std::unique_ptr<Simulation> made = fork();
  Parts& other = *made->parts_;
  other.ideal.forget();
  other.given_config.events = whole.events;
  other.config.events = as_run(whole).events;
  for (const TimedEvent& event : other.config.events)
    if (report::from_seconds(event.at_s) >= p.now()) other.expect(event);
  if (reference) other.ideal.give(std::move(reference));
  return made;
}

report::RunReport Simulation::report() const {
  Parts& p = *parts_;
  Ledger::Report ledger = p.ledger_report();
  auto errors = p.measure_errors(ledger.jobs);
  return make_report(
      {p.config, p.machine, p.dock, p.dock_config, p.host, p.ledger, p.observer, p.log,
       p.run_end.stop().value_or(p.over() ? report::StopReason::completed : report::StopReason::under_way), p.elapsed,
       cause_names(), std::move(ledger), *p.course, std::move(errors), p.ideal.problem(), p.run_end.account_end(),
       [&p](Word kind) { return p.ledger.name(job_kind(kind, p.words)); }});
}

report::RunReport Simulation::report_so_far() {
  parts_->reported_all = !ended();
  parts_->log.flush();
  try {
    return report();
  } catch (const io::Stopped&) {
    parts_->run_end.interrupt();
    return report();
  }
}

bool Simulation::interrupted() const { return parts_->run_end.interrupted(); }

std::shared_ptr<const Reference> Simulation::reference() const { return parts_->ideal.reference(parts_->run_end); }
const Course& Simulation::course() const { return *parts_->course; }
std::vector<report::TaskReport> Simulation::tasks() const { return parts_->ledger_report().tasks; }
JobsByRobot Simulation::jobs() const { return parts_->ledger_report().jobs; }

bool Simulation::strictly_good() const {
  const report::RunReport report = this->report();
  const bool whole =
      report.stop_reason == report::StopReason::completed || report.stop_reason == report::StopReason::job_done;
  return whole && report.judged() && report.misses() == 0 && report.errors_handled.empty();
}

int Simulation::exit_status() const {
  const auto stop = parts_->run_end.stop();
  if (stop && *stop != report::StopReason::interrupted && *stop != report::StopReason::job_done) return 1;
  if (!report().audit.violations.empty() || parts_->host.errors().standing()) return 1;
  return parts_->config.run.strict && !strictly_good() ? 1 : 0;
}

const Config& Simulation::config() const { return parts_->config; }
const toolchain::Image& Simulation::image() const { return parts_->image; }
machine::Machine& Simulation::machine() { return parts_->machine; }
const machine::Machine& Simulation::machine() const { return parts_->machine; }
const plant::Dock& Simulation::dock() const { return parts_->dock; }

}  // namespace cmrc
