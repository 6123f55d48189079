#include "cmrc/run/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "bus_model/bus.hpp"
#include "c40/chip.hpp"
#include "cmrc/host/host.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/measures/run_profile.hpp"
#include "cmrc/measures/run_watchers.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/observer.hpp"
#include "cmrc/run/reference_run.hpp"
#include "cmrc/run/setup.hpp"
#include "cmrc/run/snapshot_origin.hpp"
#include "cmrc/tasks/words.hpp"
#include "io/stop.hpp"
#include "machine/board_file.hpp"
#include "machine/machine.hpp"
#include "plant/dock/dock.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

// Words on a bus are reported when their burst has ended; no report comes later than this after its time.
constexpr Time settling = std::chrono::milliseconds{1};
// The watchdog resets DSPs that are halted; if none works again after this time, none is left.
constexpr Time patience = std::chrono::milliseconds{500};
// The end of a run is checked at whole multiples of this, however the caller divides the run.
constexpr Time look_period = std::chrono::milliseconds{10};
// A stop is checked at this interval: a moment even for 16 DSPs with instruction traces.
constexpr Time ask_period = std::chrono::milliseconds{1};
static_assert(look_period % ask_period == Time{});

std::vector<std::string> cause_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::tuple_size_v<c40::Causes>; ++i)
    names.emplace_back(c40::name(static_cast<c40::Cause>(i)));
  return names;
}

constexpr auto arbitration = static_cast<std::size_t>(c40::Cause::bus_arbitration);
constexpr auto transfer = static_cast<std::size_t>(c40::Cause::bus_transfer);

/// A job's causes distinguish the two windows: A's are at the chip's places, B's come after them.
std::vector<std::string> job_causes() {
  std::vector<std::string> names = cause_names();
  names[arbitration] = "bus_a_arbitration";
  names[transfer] = "bus_a_transfer";
  names.insert(names.end(), {"bus_b_arbitration", "bus_b_transfer"});
  return names;
}

CauseTimes job_causes(const machine::Machine& machine, unsigned slot) {
  const machine::Spent spent = machine.spent(slot);
  CauseTimes all(spent.causes.begin(), spent.causes.end());
  all[arbitration] -= spent.window_b_arbitration;
  all[transfer] -= spent.window_b_transfer;
  all.insert(all.end(), {spent.window_b_arbitration, spent.window_b_transfer});
  return all;
}

Time duration_of(double seconds) { return Time{std::llround(seconds * 1e12)}; }

Time servo_period(const Config& config) {
  return duration_of(static_cast<double>(intervals(config).servo) / config.rates.refresh_frequency_hz);
}

}  // namespace

namespace {

std::vector<std::string> user_names(const Config& config) {
  std::vector<std::string> names;
  for (const UserTask& task : config.tasks) names.push_back(task.name);
  return names;
}

std::vector<std::optional<unsigned>> own_slots(const Config& config) {
  std::vector<std::optional<unsigned>> slots;
  for (const UserTask& task : config.tasks) slots.push_back(task.dsp);
  return slots;
}

LedgerConfig ledger_of(const Config& config, const machine::Config& machine) {
  LedgerConfig ledger;
  ledger.causes = job_causes();
  ledger.booked = cause_names();
  for (std::size_t i = 0; i < ledger.booked.size(); ++i) ledger.booked_as.push_back(i);
  ledger.booked_as.insert(ledger.booked_as.end(), {arbitration, transfer});
  ledger.servo_period = servo_period(config);
  ledger.user_tasks = user_names(config);
  ledger.user_slots = own_slots(config);
  ledger.chip_clock = machine::Clock(machine.chip_hz, machine.chip_hz_denominator);
  ledger.misses_kept = static_cast<std::size_t>(config.report.misses_max);
  ledger.samples_max = static_cast<std::size_t>(config.report.samples_max);
  return ledger;
}

}  // namespace

class Simulation::Parts {
 public:
  Parts(const Config& given, std::shared_ptr<Course> recorded, std::shared_ptr<const Reference> ideal)
      : given_config(given),
        config(as_run(given)),
        given_reference(std::move(ideal)),
        image(dsp_image(config)),
        words([this](std::string_view name) { return image.symbol(name); }),
        dock_config(dock_of(config)),
        dock(dock_config),
        machine_config(machine_of(config)),
        ledger(ledger_of(config, machine_config)),
        observer(words, ledger, log, static_cast<std::size_t>(config.report.samples_max)),
        host(config, words, crane_of(config, dock_config), fleet_of(config, dock_config), ledger, observer,
             [this](unsigned slot) { return machine.boot_stream(slot); }),
        machine(machine_config, image, &dock, &host),
        end(duration_of(config.run.duration_s)),
        course(recorded
                   ? std::move(recorded)
                   : std::make_shared<Course>(measured() ? rows_of(config) : 0, static_cast<int>(config.dock.agvs))) {
    if (given_reference) require_fitting(*given_reference);
    host.set_course(course.get());
    observer.set_servoing([this] { return host.servoing(); });
    for (const AreaWord& word : initial_words(config, dock_config, words, dock)) machine.poke(word.offset, word.value);
    observer.set_causes([this](unsigned slot) { return job_causes(machine, slot); });
    observer.set_peek([this](machine::Offset offset) { return machine.peek(offset); });
    const Word pid_state = words.cr_base + image.symbol("CR_PID") - image.symbol("PD_STATE");
    observer.watch_errors(pid_state + image.symbol("PD_E"), pid_state + image.symbol("PD_STAGE"),
                          image.symbol("PD_SERVOING"));
    observer.attach(dock, course->recorded() ? course.get() : nullptr, config.dock.wind_limit_m_s);
    machine.set_observer(&observer);
    for (unsigned slot = 0; slot < machine.slots(); ++slot) {
      ledger.timeline().slot(slot, machine.booted(slot) ? SlotState::awake : SlotState::off, Time{0});
    }
    for (const TimedEvent& event : config.events) {
      if (event.action == "set") host.change(duration_of(event.at_s), event);
    }
  }

  void require_fitting(const Reference& reference) const {
    if (reference.key != reference_key(given_config))
      throw ConfigError(
          "reference: it is the ideal run of another configuration; only DSPs, their speed and failures may differ");
  }

  /// A future event goes into the machine's script or the host's.
  void expect(const TimedEvent& event) {
    if (const auto scripted = scripted_event(event))
      machine.script(*scripted);
    else
      host.change(duration_of(event.at_s), event);
  }

  /// The state of a run. The ideal run, and what was measured against it, is made again.
  void list_state(state::Visitor& list) {
    list("events", config.events);
    list("given events", given_config.events);
    list("dock", dock);  // before the machine, which needs the time of the dock's next event
    list("machine", machine);
    list("host", host);
    list("ledger", ledger);
    list("observer", observer);
    list("log", log);
    list("course", *course);
    list("last alive", last_alive);
    list("last driven", last_driven);
    list("enabled", enabled);
    list("account end", account_end);
    list("after end", after_end);
    list("stop", stop);
    list("stopped by", stopped_by);
  }

  Ledger::Report told() const {
    return ledger.tell(machine.time(), [this](unsigned slot) { return job_causes(machine, slot); });
  }

  /// The errors of the run are measured.
  bool measured() const { return config.report.reference == ReferenceKind::ideal; }

  /// Continues an interrupted run.
  void resume() {
    if (stop != report::StopReason::interrupted) return;
    stop = stopped_by;
    forget_reference();
  }

  void run_until(Time time) {
    while (now() < time && !over() && !io::stop_asked()) {
      if (account_end) {
        dock.advance_to(std::min(time, after_end));
      } else {
        machine.run_until(std::min(time, (now() / ask_period + 1) * ask_period));
        if (now() % look_period == Time{}) look();
      }
    }
    if (now() > settling) log.settle(now() - settling);
  }

  Time now() const { return account_end ? std::max(*account_end, dock.time()) : machine.time(); }
  void measure_anew() {
    told_all = false;
    ideal_run.reset();
    reference_problem.clear();
    errors.reset();
  }

  bool over() const { return now() >= end || (account_end && now() >= after_end); }

  /// Checks whether the job is finished, or no drive works any more: then the plant continues, braked, without the
  /// machine.
  void look() {
    bool alive = false;
    for (unsigned slot = 0; slot < machine.slots(); ++slot)
      alive = alive || (machine.booted(slot) && !machine.standing(slot));
    if (alive) last_alive = now();
    enabled = enabled || !dock.braked();
    if (!enabled || !dock.braked() || !host.servoing()) last_driven = now();
    const Time after = duration_of(config.run.after_stop_s);
    if (config.run.until == RunUntil::job_done && host.job_done())
      return stop_account(report::StopReason::job_done, Time{});
    if (dock.faulted()) return stop_account(report::StopReason::plant_fault, after);
    if (now() - last_alive >= patience) return stop_account(report::StopReason::no_dsp_left, after);
    if (now() - last_driven >= std::max(after, patience)) stop_account(report::StopReason::drives_stopped, Time{});
  }

  void stop_account(report::StopReason reason, Time after) {
    stop = stopped_by = reason;
    account_end = now();
    after_end = std::min(end, now() + after);
    if (reason != report::StopReason::job_done) dock.enable_drives(0, now());
  }

  /// The ideal run, after the end of this run.
  std::shared_ptr<const Reference> reference() {
    const bool interrupted = stop == report::StopReason::interrupted;
    if (!measured() || config.run.ideal || (!over() && !interrupted)) return nullptr;
    if (!ideal_run && !given_reference && reference_problem.empty())
      ideal_run = std::make_unique<ReferenceRun>(given_config);
    if (!given_reference && reference_problem.empty()) {
      try {
        given_reference = interrupted ? ideal_run->cut_short(now()) : ideal_run->wait();
      } catch (const io::Stopped&) {
        throw;
      } catch (const std::runtime_error& error) {
        reference_problem = error.what();
      }
    }
    ideal_run.reset();
    return given_reference;
  }

  /// Starts the ideal run at the same time as this one.
  void begin_reference() {
    if (!measured() || config.run.ideal || given_reference || ideal_run) return;
    ideal_run = std::make_unique<ReferenceRun>(given_config);
  }

  /// Results against another course of events, or a part of it, are measured again.
  void forget_reference() {
    ideal_run.reset();
    given_reference.reset();
    reference_problem.clear();
    errors.reset();
  }

  std::optional<report::Errors> measure_errors(const JobsByRobot& jobs) {
    if (errors) return errors;
    const auto ideal = reference();
    if (!ideal && !(config.run.ideal && measured())) return std::nullopt;
    const bool interrupted = stop == report::StopReason::interrupted;
    const Course& meant = ideal ? ideal->course : *course;
    const JobsByRobot& demanded = ideal ? ideal->jobs : jobs;
    Time to = interrupted || config.run.ideal ? now() : end;
    if (interrupted)
      to = std::min(to, meant.end() + meant.step());  // the last row is valid until the next one would come
    if (stop == report::StopReason::job_done && meant.size() > 0) to = std::min(end, std::max(now(), meant.end()));
    std::vector<std::string> kinds = job_kinds();
    for (const UserTask& task : config.tasks) kinds.push_back("user." + task.name);
    report::Errors made = measure({config, dock_config, *course, jobs, std::move(kinds), to}, meant, demanded);
    if (ideal) made.reference_elapsed_s = ideal->elapsed_s;
    if (over() && !interrupted) errors = made;
    return made;
  }

  std::string files() const { return digest_of_files(given_config, image); }

  void require_more_to_come(const char* call) const {
    if (told_all)
      throw std::logic_error(
          fmt::format("Simulation::{}: report_so_far has ended the run; Simulation::report leaves it as it is", call));
  }

  /// The run has a profile: this function is not possible.
  void require_no_profile(const char* call) const {
    if (profile)
      throw std::logic_error(
          fmt::format("Simulation::{}: a run with a profile has no snapshots, because its counts would be lost; run it "
                      "without profile",
                      call));
  }

  void connect_traces() {
    for (const auto& [slot, sink] : traces) {
      if (profile)
        profile->trace(slot, sink);
      else
        machine.chip(slot).set_trace(sink);
    }
  }

  Config given_config;
  Config original_config = given_config;  // before Simulation::at has added events
  std::string snapshot_key = key_of(given_config);
  Config config;
  std::shared_ptr<const Reference> given_reference;
  std::unique_ptr<ReferenceRun> ideal_run;
  std::string reference_problem;  // why there is no ideal run
  std::optional<report::Errors> errors;
  toolchain::Image image;
  Words words;
  plant::DockConfig dock_config;
  plant::Dock dock;
  machine::Config machine_config;
  Ledger ledger;
  report::EventLog log;
  RunObserver observer;
  Host host;
  machine::Machine machine;
  Time end;
  std::shared_ptr<Course> course;
  Time last_alive{}, last_driven{};
  bool enabled = false;             // the drives were on at some time
  std::optional<Time> account_end;  // from this time on the plant continues without the machine
  Time after_end{};
  std::optional<report::StopReason> stop;
  std::optional<report::StopReason> stopped_by;  // the end of the account; an interruption is not kept here
  std::chrono::steady_clock::duration elapsed{};
  std::map<unsigned, c40::TraceSink*> traces;
  std::optional<RunProfile> profile;
  RunWatchers watchers;
  bool told_all = false;  // the order of events is settled further than is certain
};

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
  if (duration_of(event.at_s) < p.now()) {
    refuse(event.origin, "events.at_s", fmt::format("{} s has passed", event.at_s),
           fmt::format("the run is at {:.9g} s", report::seconds(p.now())));
  }
  if (ended() || event.at_s >= p.config.run.duration_s) {
    refuse(event.origin, "events.at_s", fmt::format("{} s is not within the run", event.at_s),
           fmt::format("it ends at {} s", p.config.run.duration_s));
  }
  Config with = p.config;
  with.events.push_back(event);
  check_events(with);
  p.config.events.push_back(event);
  p.given_config.events.push_back(event);
  p.forget_reference();
  p.expect(event);
}

void Simulation::listen(report::EventSink& sink) { parts_->log.listen(sink); }
void Simulation::tap(report::EventSink* sink) { parts_->log.tap(sink); }
void Simulation::watch(RunWatcher& watcher) {
  Parts& p = *parts_;
  p.ledger.introduce(watcher,
                     [&p](std::size_t block) { return p.machine.peek(p.words.block(block) + p.words.generation); });
  p.watchers.add(watcher);
  p.observer.watch(&p.watchers);
  p.machine.watch_buses([&p](machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) {
    p.watchers.on_bus(bus, attempt, clock);
  });
}

std::vector<std::string> Simulation::causes() { return job_causes(); }

void Simulation::close_watch() {
  Parts& p = *parts_;
  p.ledger.close(p.machine.time(), [&p](unsigned slot) { return job_causes(p.machine, slot); }, p.watchers);
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
  parts_->run_until(std::min(time, parts_->end));
  parts_->elapsed += std::chrono::steady_clock::now() - began;
}

void Simulation::run(const std::function<bool(const Progress&)>& on_progress, report::Time slice, report::Time until) {
  parts_->require_more_to_come("run");
  parts_->resume();
  if (!ended()) parts_->begin_reference();
  while (!ended() && parts_->now() < until) {
    run_until(std::min(parts_->now() + slice, until));
    bool go_on = !io::stop_asked();
    if (go_on && on_progress)
      go_on = on_progress(
          {parts_->now(), parts_->end, static_cast<unsigned>(parts_->dock.delivered()), parts_->ledger.misses()});
    if (!go_on && !ended()) {
      parts_->stop = report::StopReason::interrupted;
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
  if (snapshot.configuration() != p.snapshot_key)
    throw SnapshotError(fmt::format("the snapshot is of another configuration: {}",
                                    first_other_line(snapshot.configuration(), p.snapshot_key)));
  if (snapshot.files() != p.files())
    throw SnapshotError(
        "the snapshot is of another program, layout or board: the files that the configuration names have changed "
        "since");
  try {
    state::load_or_leave(p, snapshot.state());
  } catch (const state::StateError& error) {
    throw SnapshotError(fmt::format("the snapshot is of another version of the emulator: {}", error.what()));
  }
  p.measure_anew();
}

void Simulation::list_state(state::Visitor& list) {
  parts_->list_state(list);
  if (list.loads()) parts_->measure_anew();
}

std::optional<std::string> Simulation::difference(const Simulation& other) const {
  return state::difference(*parts_, *other.parts_);
}

std::unique_ptr<Simulation> Simulation::fork() {
  const Snapshot now = snapshot();
  const Parts& p = *parts_;
  const bool same_ideal = p.given_reference && p.given_reference->key == reference_key(p.original_config);
  auto other = std::make_unique<Simulation>(p.original_config, same_ideal ? p.given_reference : nullptr);
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
  other.forget_reference();
  other.given_config.events = whole.events;
  other.config.events = as_run(whole).events;
  for (const TimedEvent& event : other.config.events)
    if (duration_of(event.at_s) >= p.now()) other.expect(event);
  if (reference) other.require_fitting(*reference);
  other.given_reference = std::move(reference);
  return made;
}

report::RunReport Simulation::report() const {
  Parts& p = *parts_;
  Ledger::Report told = p.told();
  auto errors = p.measure_errors(told.jobs);
  return make_report({p.config, p.machine, p.dock, p.dock_config, p.host, p.ledger, p.observer, p.log,
                      p.stop     ? *p.stop
                      : p.over() ? report::StopReason::completed
                                 : report::StopReason::under_way,
                      p.elapsed, cause_names(), std::move(told), *p.course, std::move(errors), p.reference_problem,
                      p.account_end, [&p](Word kind) { return p.ledger.name(job_kind(kind, p.words)); }});
}

report::RunReport Simulation::report_so_far() {
  parts_->told_all = !ended();
  parts_->log.flush();
  try {
    return report();
  } catch (const io::Stopped&) {
    parts_->stop = report::StopReason::interrupted;
    return report();
  }
}

bool Simulation::interrupted() const { return parts_->stop == report::StopReason::interrupted; }

std::shared_ptr<const Reference> Simulation::reference() const { return parts_->reference(); }
const Course& Simulation::course() const { return *parts_->course; }
std::vector<report::TaskReport> Simulation::tasks() const { return parts_->told().tasks; }
JobsByRobot Simulation::jobs() const { return parts_->told().jobs; }

bool Simulation::strictly_good() const {
  const report::RunReport report = this->report();
  const bool whole =
      report.stop_reason == report::StopReason::completed || report.stop_reason == report::StopReason::job_done;
  return whole && report.misses() == 0 && report.errors_handled.empty();
}

int Simulation::exit_status() const {
  const auto& stop = parts_->stop;
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
