#include "cmrc/run/make_report.hpp"

#include <algorithm>
#include <cmath>

#include "bus_model/bus.hpp"
#include "c40/chip/chip.hpp"
#include "cmrc/measures/error_log.hpp"
#include "cmrc/measures/measures.hpp"
#include "machine/dsps/slot_links.hpp"
#include "machine/networks/net.hpp"
#include "machine/system/machine_config.hpp"
#include "plant/numerics/math.hpp"
#include "report/events/event.hpp"

namespace cmrc {
namespace {

report::Summary summary_of(const pci::Histogram& histogram) {
  report::Summary summary;
  summary.count = histogram.count();
  if (histogram.count() != 0)
    summary.mean = static_cast<double>(histogram.sum()) / static_cast<double>(histogram.count());
  summary.p50 = histogram.percentile(0.5);
  summary.p99 = histogram.percentile(0.99);
  summary.p99_9 = histogram.percentile(0.999);
  summary.best = histogram.min();
  summary.worst = histogram.max();
  summary.exact_percentiles = histogram.max() < static_cast<pci::Clocks>(pci::Histogram::exact);
  const auto octaves = histogram.octaves();
  for (std::size_t i = 0; i < octaves.size(); ++i) summary.histogram[i + 1] = octaves[i];
  summary.histogram[0] = histogram.zeros();  // the lowest octave contains 0 and 1
  summary.histogram[1] -= histogram.zeros();
  return summary;
}

report::BusReport bus_report(const machine::Machine& machine, machine::BusId id, double hertz) {
  const pci::Bus& bus = machine.bus(id);
  report::BusReport report;
  report.name = bus.config().name;
  report.clock_hz = hertz;
  report.clock_ppm = machine::skew_of_bus(machine.config(), static_cast<unsigned>(id)).ppm;
  const pci::BusStatistics statistics = machine.bus_statistics(id);
  report.clocks = statistics.total();
  report.data = statistics.data;
  report.wait = statistics.address + statistics.wait;
  report.turnaround = statistics.turnaround;
  report.idle_requested = statistics.idle_requested;
  report.idle = statistics.idle;
  for (unsigned i = 0; i < bus.masters(); ++i) {
    const pci::MasterStatistics& master = bus.master_statistics(i);
    report.masters.push_back({bus.master_name(i), master.transactions, master.words_read, master.words_written,
                              summary_of(master.wait), master.retries, master.disconnects});
  }
  for (unsigned i = 0; i < bus.targets(); ++i) {
    const pci::TargetStatistics& target = bus.target_statistics(i);
    auto same = std::ranges::find(report.targets, bus.target_name(i), &report::TargetReport::name);
    if (same == report.targets.end()) same = report.targets.insert(same, {bus.target_name(i), 0, 0});
    same->words_read += target.words_read;
    same->words_written += target.words_written;
  }
  return report;
}

report::DspReport dsp_report(const ReportInputs& e, unsigned slot) {
  const c40::Chip& chip = e.machine.chip(slot);
  report::DspReport report;
  report.slot = slot;
  report.state = !e.machine.plugged(slot)   ? "unplugged"
                 : e.machine.standing(slot) ? "halted"
                 : !e.machine.booted(slot)  ? "waiting for its program"
                 : chip.idle()              ? "idle"
                                            : "running";
  if (e.machine.standing(slot)) {
    for (const machine::ChipFault& fault : e.machine.faults()) {
      if (fault.slot == slot) report.state = "halted: " + fault.message;
    }
  }
  report.clock_hz = e.machine.chip_clock().hertz();
  report.clock_ppm = machine::skew_of_chip(e.machine.config(), slot).ppm;
  const machine::Spent spent = e.machine.spent(slot);
  report.cycles = spent.cycles;
  report.instructions = chip.instructions();
  for (std::size_t i = 0; i < e.causes.size(); ++i) report.causes.push_back({e.causes[i], spent.causes[i]});
  report.claims = e.ledger.claims(slot);
  report.tasks = e.ledger.occupied(slot, e.machine.time());
  report.faults = e.observer.faults(slot);
  report.resets = e.observer.resets(slot);
  const machine::SlotStatistics& counted = e.machine.statistics(slot);
  report.dropped_writes = counted.dropped_writes;
  report.boots = e.observer.boots(slot);
  report.link_words_in = counted.words_to_dsp;
  report.link_words_out = counted.words_from_dsp;
  report.link_words_lost = counted.words_lost;
  return report;
}

report::LinkReport link_report(const machine::SlotWire& wire) {
  report::LinkReport report;
  report.joined = wire.joined();
  report.is_cut = wire.link().is_cut();
  for (const int side : {0, 1}) {
    const machine::SlotPort &from = side == 0 ? wire.ends().a : wire.ends().b,
                            &to = side == 0 ? wire.ends().b : wire.ends().a;
    const machine::SlotLinkTraffic of = wire.traffic(side);
    report.directions[static_cast<std::size_t>(side)] = {
        machine::to_text(from), machine::to_text(to), of.sent, of.arrived, of.lost, of.discarded};
  }
  return report;
}

report::OwnMeasure own(std::string name, std::string unit, const SquareSum& of) {
  if (of.count == 0) return {std::move(name), std::move(unit), std::nullopt, std::nullopt};
  return {std::move(name), std::move(unit), std::sqrt(of.squares / static_cast<double>(of.count)), of.peak};
}

/// The load from the instant at which the last drive has stopped.
report::AfterStop after_stop(const ReportInputs& e, Time from) {
  report::AfterStop after;
  after.from = from;
  after.to = e.dock.time();
  const plant::Signal* first = nullptr;
  for (const plant::Signal& row : e.dock.signals()) {
    if (row.time < from) continue;
    if (first == nullptr) first = &row;
    const double sway = plant::hypot(row.alpha, row.beta);
    double moved = 0;
    for (std::size_t i = 0; i < 3; ++i)
      moved += (row.payload[i] - first->payload[i]) * (row.payload[i] - first->payload[i]);
    after.moved_m = std::max(after.moved_m, std::sqrt(moved));
    after.sway_peak_rad = std::max(after.sway_peak_rad, sway);
    if (after.to - row.time <= std::chrono::seconds{2}) after.sway_end_rad = std::max(after.sway_end_rad, sway);
  }
  return after;
}

void add_plant(const ReportInputs& e, report::RunReport& report) {
  const plant::CraneKind machine = e.layout.crane.machine;
  const auto names = plant::joint_names(machine);
  const auto channels = plant::drive_channels(machine);
  for (std::size_t channel = 0; channel < channels.size(); ++channel) {
    const auto joint = static_cast<std::size_t>(channels[channel]);
    if (machine == plant::CraneKind::gantry && joint == static_cast<std::size_t>(plant::Joint::slew)) continue;
    report.pid_error.push_back(own(names[joint].name, names[joint].unit, e.observer.pid_error()[channel]));
    report.drives.push_back(
        {names[joint].name, static_cast<double>(e.observer.saturated_latches()[joint]) * plant::latch_seconds});
  }
  const MotionWatch& motion = e.observer.motion();
  report.sway = {own("alpha", "rad", motion.sway()[0]), own("beta", "rad", motion.sway()[1])};
  for (std::size_t i = 0; i < motion.agvs().size(); ++i)
    report.agvs.push_back(own("agv " + std::to_string(i) + " lateral", "m", motion.agvs()[i]));
}

std::string hash_of(const ReportInputs& e) {
  std::vector<std::uint64_t> state;
  e.machine.append_state(state);
  for (const std::uint64_t word : e.dock.state_hash()) state.push_back(word);
  return e.log.hash_with(std::as_bytes(std::span(state)));
}

}  // namespace

report::RunReport make_report(ReportInputs e) {
  report::RunReport report;
  const Time now = e.machine.time();
  report.stop_reason = e.stop;
  report.simulated = std::max(now, e.account_end ? e.dock.time() : now);
  report.account_end = now;
  report.elapsed_s = std::chrono::duration<double>(e.elapsed).count();
  report.hash = hash_of(e);
  report.events = e.log.count();
  for (const Key& key : keys()) {
    report::Setting setting{key.name, {}};
    std::visit([&](const auto& value) { setting.value = value; }, key.read(e.config));
    report.configuration.push_back(std::move(setting));
  }
  report.configuration_toml = to_toml(e.config);
  if (e.config.machine.boot == BootPolicy::link) report.boot_words = e.machine.boot_stream(0).size();
  for (unsigned slot = 0; slot < e.machine.slots(); ++slot) report.dsps.push_back(dsp_report(e, slot));
  report.tasks = std::move(e.account.tasks);
  report.missed = std::move(e.account.misses);
  report.misses_left_out = e.account.misses_left_out;
  report.audit = std::move(e.account.audit);
  const machine::Config& clocks = e.machine.config();
  const double hertz = static_cast<double>(clocks.pci_hz_numerator) / static_cast<double>(clocks.pci_hz_denominator);
  for (std::size_t i = 0; i < e.machine.links(); ++i) report.links.push_back(link_report(e.machine.link(i)));
  for (std::size_t i = 0; i < e.machine.nets(); ++i) {
    const machine::Net& net = e.machine.net(i);
    report.nets.push_back({net.description().name, to_text(net.description()), net.edges(), net.missed(), net.level()});
  }
  for (unsigned i = 0; i < e.machine.buses(); ++i)
    report.buses.push_back(bus_report(e.machine, static_cast<machine::BusId>(i), hertz));
  report.cycles = e.host.cycles().cycles();
  std::size_t delivered = 0;
  for (const plant::Event& event : e.dock.events()) {
    if (event.kind == plant::EventKind::delivered && delivered < report.cycles.size())
      report.cycles[delivered++].delivered = event.time;
  }
  report.cycles_completed = e.host.cycles().completed();
  report.containers_delivered = static_cast<unsigned>(e.dock.delivered());
  add_plant(e, report);
  report.reference = e.config.report.reference == ReferenceKind::ideal ? "ideal" : "none";
  report.errors = std::move(e.errors);
  report.reference_problem = std::move(e.reference_problem);
  for (const auto& [robot, count] : e.course.starved_intervals(now))
    report.starved.push_back({robot == 0 ? "crane" : "agv " + std::to_string(robot - 1), count});
  if (e.account_end) report.after_stop = after_stop(e, *e.account_end);
  if (e.host.job_done() && report.containers_delivered > 0 && e.host.first_refresh()) {
    for (const report::CycleReport& cycle : report.cycles)
      if (cycle.delivered)
        report.makespan = std::max(report.makespan.value_or(Time{}), *cycle.delivered - *e.host.first_refresh());
  }
  report.control_cost = {report.errors ? std::optional(report.errors->error_m2s) : std::nullopt,
                         e.observer.drive_effort(), e.config.report.control_cost_rho_m2};
  report.host = e.host.report(now);
  report.wind = {.limit_m_s = e.config.dock.wind_limit_m_s,
                 .watched = e.observer.wind().watched(),
                 .above = e.observer.wind().above()};
  e.host.add_wind(report.wind);
  report.host.semaphore_hold = e.observer.semaphore_hold().summary();
  report.host.refresh_duration = e.observer.refresh_duration(e.host.refresh_under_way(), now).summary();
  for (const TimedEvent& event : e.config.events) {
    const Time at = report::from_seconds(event.at_s);
    if (at < now)
      report.timed_events.push_back({at, describe(event)});
    else
      ++report.timed_events_to_come;
  }
  std::ranges::stable_sort(report.timed_events, {}, &report::TimedEventReport::time);
  for (std::string& fault : e.machine.audit()) report.audit.violations.push_back(std::move(fault));
  report.errors_handled = handled_errors(e.host.errors().entries(), e.config, e.dock, report.simulated, e.kind_name);
  report.braked = e.dock.braked();
  report.failures = e.observer.failures();
  for (const std::string& violation : report.audit.violations)
    report.failures.push_back({now, std::nullopt, "audit", violation});
  return report;
}

}  // namespace cmrc
