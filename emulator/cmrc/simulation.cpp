#include "cmrc/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>

#include "bus_model/bus.hpp"
#include "c40/chip.hpp"
#include "c40_programs/image.hpp"
#include "cmrc/host.hpp"
#include "cmrc/ideal.hpp"
#include "cmrc/kernels.hpp"
#include "cmrc/ledger.hpp"
#include "cmrc/observer.hpp"
#include "cmrc/run_profile.hpp"
#include "cmrc/setup.hpp"
#include "cmrc/words.hpp"
#include "machine/board_file.hpp"
#include "machine/machine.hpp"
#include "plant/dock.hpp"
#include "toolchain/assembler.hpp"
#include "toolchain/coff.hpp"
#include "toolchain/source_map.hpp"

namespace cmrc {
namespace {

// Bus words are told when their burst has ended; nothing is told later than this after its time.
constexpr Time settling = std::chrono::milliseconds{1};
// DSPs that stand still are reset by the watchdog; when none has come back after so long, none is left.
constexpr Time patience = std::chrono::milliseconds{500};

std::vector<std::string> cause_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::tuple_size_v<c40::Causes>; ++i) names.emplace_back(c40::name(static_cast<c40::Cause>(i)));
  return names;
}

constexpr auto arbitration = static_cast<std::size_t>(c40::Cause::bus_arbitration);
constexpr auto transfer = static_cast<std::size_t>(c40::Cause::bus_transfer);

/// A job's causes tell the two windows apart: A's stand at the chip's places, B's behind.
std::vector<std::string> job_causes() {
  std::vector<std::string> names = cause_names();
  names[arbitration] = "bus_a_arbitration";
  names[transfer] = "bus_a_transfer";
  names.insert(names.end(), {"bus_b_arbitration", "bus_b_transfer"});
  return names;
}

CauseTimes job_causes(const machine::Machine& machine, unsigned slot) {
  const c40::Causes& causes = machine.chip(slot).causes();
  const machine::SlotStatistics& bus = machine.statistics(slot);
  CauseTimes all(causes.begin(), causes.end());
  all[arbitration] -= bus.window_b_arbitration;
  all[transfer] -= bus.window_b_transfer;
  all.insert(all.end(), {bus.window_b_arbitration, bus.window_b_transfer});
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

std::string_view built_in_text(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

LedgerConfig ledger_of(const Config& config, const machine::Config& machine) {
  LedgerConfig ledger;
  ledger.causes = job_causes();
  ledger.booked = cause_names();
  for (std::size_t i = 0; i < ledger.booked.size(); ++i) ledger.booked_as.push_back(i);
  ledger.booked_as.insert(ledger.booked_as.end(), {arbitration, transfer});
  ledger.servo_period = servo_period(config);
  ledger.user_tasks = user_names(config);
  ledger.chip_clock = machine::Clock(machine.chip_hz, machine.chip_hz_denominator);
  ledger.misses_kept = static_cast<std::size_t>(config.report.misses_max);
  return ledger;
}

toolchain::Image assembled(const Config& config) {
  if (config.machine.programs.empty()) return toolchain::read_coff(c40_programs::built_in_image());
  const std::filesystem::path directory = config.machine.programs;
  const std::filesystem::path source = directory / "dsp.asm";
  if (!std::filesystem::is_regular_file(source)) {
    throw ConfigError(fmt::format("machine.programs: {} is not there; a directory with dsp.asm is expected", source.string()));
  }
  toolchain::Options options;
  options.include_dirs = {directory, directory / "include"};
  return toolchain::assemble_file(source, options);
}

}  // namespace

toolchain::Image dsp_image(const Config& config) {
  toolchain::Image image = assembled(config);
  place_kernels(image, config);
  return image;
}

class Simulation::Parts {
 public:
  explicit Parts(const Config& given)
      : config(as_run(given)), image(dsp_image(config)), words([this](std::string_view name) { return image.symbol(name); }),
        dock_config(dock_of(config)), dock(dock_config), machine_config(machine_of(config)), ledger(ledger_of(config, machine_config)),
        observer(words, ledger, log), host(config, words, crane_of(config, dock_config), fleet_of(config, dock_config), ledger, observer,
             [this](unsigned slot) { return machine.boot_stream(slot); }),
        machine(machine_config, image, &dock, &host), end(duration_of(config.run.duration_s)) {
    observer.weigh_errors(dock_config.crane);
    for (const AreaWord& word : initial_words(config, dock_config, words, dock)) machine.poke(word.offset, word.value);
    observer.set_causes([this](unsigned slot) { return job_causes(machine, slot); });
    observer.set_peek([this](machine::Offset offset) { return machine.peek(offset); });
    observer.watch_errors(words.cr_base + image.symbol("CR_PID") + image.symbol("PD_E") - image.symbol("PD_STATE"));
    observer.attach(dock);
    machine.set_observer(&observer);
    for (unsigned slot = 0; slot < machine.slots(); ++slot) {
      ledger.timeline().slot(slot, machine.booted(slot) ? SlotState::awake : SlotState::off, Time{0});
    }
    for (const TimedEvent& event : config.events) {
      if (event.action == "set") host.change(duration_of(event.at_s), event);
    }
  }

  void run_until(Time time) {
    machine.run_until(time);
    if (machine.time() > settling) log.settle(machine.time() - settling);
    bool alive = false;
    for (unsigned slot = 0; slot < machine.slots(); ++slot) alive = alive || (machine.booted(slot) && !machine.standing(slot));
    if (alive) last_alive = machine.time();
    if (machine.time() - last_alive >= patience) stop = report::StopReason::no_dsp_left;
    if (dock.faulted()) stop = report::StopReason::plant_fault;
  }

  void connect_traces() {
    for (const auto& [slot, sink] : traces) {
      if (profile) profile->trace(slot, sink);
      else machine.chip(slot).set_trace(sink);
    }
  }

  Config config;
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
  Time last_alive{};
  std::optional<report::StopReason> stop;
  std::chrono::steady_clock::duration elapsed{};
  std::map<unsigned, c40::TraceSink*> traces;
  std::optional<RunProfile> profile;
};

Simulation::Simulation(const Config& config) try : parts_(std::make_unique<Parts>(config)) {
} catch (const machine::BoardError& error) {
  throw ConfigError(fmt::format("machine.board: {}", error.what()));
}
Simulation::~Simulation() = default;

void Simulation::at(const TimedEvent& event) {
  Parts& p = *parts_;
  if (duration_of(event.at_s) < p.machine.time()) {
    refuse(event.origin, "events.at_s", fmt::format("{} s has passed", event.at_s),
           fmt::format("the run is at {:.9g} s", static_cast<double>(p.machine.time().count()) * 1e-12));
  }
  if (ended() || event.at_s >= p.config.run.duration_s) {
    refuse(event.origin, "events.at_s", fmt::format("{} s is not within the run", event.at_s), fmt::format("it ends at {} s", p.config.run.duration_s));
  }
  Config with = p.config;
  with.events.push_back(event);
  check_events(with);
  p.config.events.push_back(event);
  if (const auto scripted = scripted_event(event)) p.machine.script(*scripted);
  else p.host.change(duration_of(event.at_s), event);
}

void Simulation::listen(report::EventSink& sink) { parts_->log.listen(sink); }
void Simulation::trace(unsigned slot, c40::TraceSink& sink) {
  parts_->traces[slot] = &sink;
  parts_->connect_traces();
}

void Simulation::profile() {
  if (parts_->machine.time() != Time{}) throw std::logic_error("Simulation::profile: the run has begun; a profile is of a whole run");
  parts_->profile.emplace(parts_->machine);
  parts_->observer.set_profile(&*parts_->profile);
  parts_->connect_traces();
}

report::Profile Simulation::profile_report() const {
  if (!parts_->profile) throw std::logic_error("Simulation::profile_report: nothing was counted; Simulation::profile comes before the run");
  toolchain::Image image = parts_->image;
  if (parts_->config.machine.programs.empty()) toolchain::add_source_map(image, built_in_text(c40_programs::built_in_source_map()));
  toolchain::Image rom = toolchain::read_coff(c40_programs::built_in_boot_rom());
  toolchain::add_source_map(rom, built_in_text(c40_programs::built_in_boot_rom_source_map()));
  return parts_->profile->report(report().tasks, image, rom);
}

bool Simulation::ended() const {
  const auto& stop = parts_->stop;
  return parts_->machine.time() >= parts_->end || (stop && *stop != report::StopReason::interrupted);
}

void Simulation::run_until(report::Time time) {
  const auto began = std::chrono::steady_clock::now();
  parts_->run_until(std::min(time, parts_->end));
  parts_->elapsed += std::chrono::steady_clock::now() - began;
}

void Simulation::run(const std::function<bool(const Progress&)>& on_progress, report::Time slice) {
  parts_->stop.reset();
  while (!ended()) {
    run_until(parts_->machine.time() + slice);
    if (!on_progress) continue;
    const Progress progress{parts_->machine.time(), parts_->end, static_cast<unsigned>(parts_->dock.delivered()), parts_->ledger.misses()};
    if (!on_progress(progress) && !ended()) {
      parts_->stop = report::StopReason::interrupted;
      return;
    }
  }
  parts_->log.flush();
}

report::RunReport Simulation::report() const {
  const Parts& p = *parts_;
  return make_report({p.config, p.machine, p.dock, p.dock_config, p.host, p.ledger, p.observer, p.log, p.stop, p.elapsed, cause_names(),
                      [&p](unsigned slot) { return job_causes(p.machine, slot); }});
}

bool Simulation::strictly_good() const {
  const report::RunReport report = this->report();
  return report.stop_reason == report::StopReason::completed && report.misses() == 0;
}

int Simulation::exit_status() const {
  const auto& stop = parts_->stop;
  if (stop && *stop != report::StopReason::interrupted) return 1;
  if (!report().audit.violations.empty()) return 1;
  return parts_->config.run.strict && !strictly_good() ? 1 : 0;
}

const Config& Simulation::config() const { return parts_->config; }
const toolchain::Image& Simulation::image() const { return parts_->image; }
machine::Machine& Simulation::machine() { return parts_->machine; }
const machine::Machine& Simulation::machine() const { return parts_->machine; }
const plant::Dock& Simulation::dock() const { return parts_->dock; }

}  // namespace cmrc
