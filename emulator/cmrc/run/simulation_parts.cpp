#include "cmrc/run/simulation_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/chip/chip.hpp"
#include "cmrc/configuration/dock/dock_job.hpp"
#include "cmrc/programs/straight_ways.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/job_causes.hpp"
#include "cmrc/run/setup.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "io/stop.hpp"
#include "report/events/event.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

// A stop is checked at this interval: a moment even for 16 DSPs with instruction traces.
constexpr Time ask_period = std::chrono::milliseconds{1};
static_assert(RunEnd::look_period % ask_period == Time{});

}  // namespace

Simulation::Parts::Parts(const Config& given, std::shared_ptr<Course> recorded,
                         std::shared_ptr<const Reference> reference)
    : given_config(given),
      config(as_run(given)),
      ideal(given_config, config, std::move(reference)),
      image(dsp_image(config)),
      words([this](std::string_view name) { return image.symbol(name); }),
      dock_config(dock_of(config, image, words)),
      dock(dock_config),
      machine_config(machine_of(config)),
      ledger(ledger_of(config, machine_config)),
      observer(words, ledger, log, static_cast<std::size_t>(config.report.samples_max)),
      host(config, words, crane_of(config, dock_config, dock), fleet_of(config, dock_config, words), ledger, observer,
           [this](unsigned slot) { return machine.boot_stream(slot); }),
      machine(machine_config, image, &dock, &host),
      run_end(config, machine, dock, host, observer.standstill()),
      course(recorded ? recorded
                      : std::make_shared<Course>(ideal.measured() ? rows_of(config) : 0,
                                                 static_cast<int>(config.dock.agvs))) {
  host.set_course(course.get());
  observer.set_servoing([this] { return host.servoing(); });
  for (const AreaWord& word : initial_words(config, dock_config, words, dock)) machine.poke(word.offset, word.value);
  // The ideal run of another run is known by its course and its jobs: nobody reads its events and causes.
  if (recorded)
    log.discard();
  else
    observer.set_causes([this](unsigned slot) { return job_causes(machine, slot); });
  observer.set_peek([this](machine::Offset offset) { return machine.peek(offset); });
  const Word pid_state = words.cr_base + image.symbol("CR_PID") - image.symbol("PD_STATE");
  observer.watch_errors(pid_state + image.symbol("PD_E"), pid_state + image.symbol("PD_STAGE"),
                        image.symbol("PD_SERVOING"));
  observer.attach(dock, course->recorded() ? course.get() : nullptr, config.dock.wind_limit_m_s);
  machine.set_observer(&observer);
  for (unsigned slot = 0; slot < machine.slots(); ++slot) {
    if (machine.plugged(slot)) observer.plugged_from_power_on(slot);
    if (machine.plugged(slot) && !machine.booted(slot)) observer.boots_from_power_on(slot);
    ledger.timeline().slot(slot, machine.booted(slot) ? SlotState::awake : SlotState::off, Time{0});
  }
  check_sets(config.events);
  for (const TimedEvent& event : config.events)
    if (event.action == "set") host.change(report::from_seconds(event.at_s), event);
}

void Simulation::Parts::check_sets(std::span<const TimedEvent> events) const {
  std::vector<const TimedEvent*> sets;
  for (const TimedEvent& event : events)
    if (event.action == "set") sets.push_back(&event);
  std::ranges::stable_sort(sets, {}, &TimedEvent::at_s);
  Config changed = config;
  for (const TimedEvent* set : sets) {
    changed = with_live(changed, set->key, set->value, set->origin);
    const bool limit = set->key.starts_with("control.") && set->key.find("speed_limit") != std::string::npos;
    if (!limit && set->key != "scheduling.work_mode" && set->key != "scheduling.slow_factor") continue;
    try {
      check_speeds(dock_config, changed, image);
    } catch (const std::invalid_argument& error) {
      refuse(set->origin, set->key, error.what(),
             limit ? "here a lower value is expected" : "here a crane as slow as before is expected");
    }
  }
}

void Simulation::Parts::expect(const TimedEvent& event) {
  if (const auto scripted = scripted_event(event))
    machine.script(*scripted);
  else
    host.change(report::from_seconds(event.at_s), event);
}

void Simulation::Parts::list_state(state::Visitor& list) {
  list("events", config.events);
  list("given events", given_config.events);
  list("dock", dock);  // before the machine, which needs the time of the dock's next event
  list("machine", machine);
  list("host", host);
  list("ledger", ledger);
  list("observer", observer);
  list("log", log);
  list("course", *course);
  run_end.list_state(list);
}

void Simulation::Parts::measure_again() {
  reported_all = false;
  ideal.measure_again();
}

void Simulation::Parts::run_until(Time time) {
  while (now() < time && !over() && !io::stop_asked()) {
    if (run_end.account_end()) {
      dock.advance_to(std::min(time, run_end.after_end()));
    } else {
      machine.run_until(std::min({time, (now() / ask_period + 1) * ask_period, run_end.limit()}));
      run_end.look();
    }
  }
  if (now() > settling) log.settle(now() - settling);
}

void Simulation::Parts::resume() {
  if (run_end.resume()) ideal.forget();
}

Ledger::Report Simulation::Parts::ledger_report() const {
  return ledger.tell(
      machine.time(), [this](unsigned slot) { return job_causes(machine, slot); },
      [this](Ledger& account) { host.count_rest(machine.time(), account); });
}

std::optional<report::Errors> Simulation::Parts::measure_errors(const JobsByRobot& jobs) {
  return ideal.errors({config, dock_config, *course, jobs, job_kinds(config.tasks), run_end.end()}, run_end);
}

void Simulation::Parts::connect_traces() {
  for (const auto& [slot, sink] : traces) {
    if (profile)
      profile->trace(slot, sink);
    else
      machine.chip(slot).set_trace(sink);
  }
}

void Simulation::Parts::require_more_to_come(const char* call) const {
  if (reported_all)
    throw std::logic_error(
        fmt::format("Simulation::{}: report_so_far has ended the run; Simulation::report leaves it as it is", call));
}

void Simulation::Parts::require_no_profile(const char* call) const {
  if (profile)
    throw std::logic_error(
        fmt::format("Simulation::{}: a run with a profile has no snapshots, because its counts would be lost; run it "
                    "without profile",
                    call));
}

}  // namespace cmrc
