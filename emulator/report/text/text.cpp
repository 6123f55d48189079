// RunReport for a terminal, at most 100 columns wide.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <span>

#include "report/text/measures_text.hpp"
#include "report/text/text_table.hpp"

namespace report {
namespace {

std::string heading(std::string_view title) { return fmt::format("\n{}\n", title); }

std::string count(std::uint64_t value) { return value == 0 ? "-" : fmt::format("{}", value); }

std::string in_seconds(const std::optional<Time>& time) { return time ? fmt::format("{:.2f}", seconds(*time)) : "-"; }

std::string title(const RunReport& report) {
  const double simulated = static_cast<double>(report.simulated.count()) / 1e12;
  const std::string reason = report.stop_reason == StopReason::completed || report.stop_reason == StopReason::job_done
                                 ? ""
                             : report.stop_reason == StopReason::under_way
                                 ? " The run is not over."
                                 : fmt::format(" The run ended early: {}.", name(report.stop_reason));
  const bool stands = std::ranges::any_of(report.errors_handled, &HandledError::stands);
  const std::string waits =
      stands ? " A robot waits with an error that the operator has not cleared (Errors, below)." : "";
  return fmt::format("{} DSP{}, {:.3f} s simulated in {:.2f} s ({:.1f} x real time).{}{}\n", report.dsps.size(),
                     report.dsps.size() == 1 ? "" : "s", simulated, report.elapsed_s,
                     report.elapsed_s > 0 ? simulated / report.elapsed_s : 0.0, reason, waits);
}

std::string outcomes(const RunReport& report) {
  TextTable table({"jobs", "released", "on time", "late", "unfinished", "not started", "lost", "dropped", "MISSED"});
  for (const TaskReport& task : report.tasks)
    if (task.released > 0)
      table.add({task.kind, count(task.released), count(task.on_time), count(task.late), count(task.unfinished),
                 count(task.never_started), count(task.lost), count(task.dropped), count(task.misses)});
  return table.empty() ? "" : heading("Deadlines") + table.render();
}

std::string times(const RunReport& report) {
  TextTable table({"release to end", "mean", "p50", "p99", "p99.9", "worst", "execution", "jitter"});
  for (const TaskReport& task : report.tasks) {
    if (task.response.count == 0) continue;
    const Summary& response = task.response;
    const auto time = [](std::int64_t ps) { return duration(static_cast<double>(ps)); };
    table.add({task.kind, duration(response.mean), time(response.p50), time(response.p99), time(response.p99_9),
               time(response.worst), duration(task.execution.mean),
               task.start_jitter.count > 0 ? time(task.start_jitter.peak_to_peak) : "-"});
  }
  if (table.empty()) return "";
  return heading("Response times (execution: mean from claim to end; jitter: of the start, peak to peak)") +
         table.render();
}

/// The meaning of a chain's part, for a reader who has not read docs/report.md.
std::string explained(std::string_view part) {
  static constexpr std::pair<std::string_view, std::string_view> words[] = {
      {"host_late", "the host's refresh began late"},
      {"not_due", "in the list, not yet due"},
      {"host_refresh", "the host's refresh"},
      {"host_lock", "the host waited for the list"},
      {"doorbell", "waking up a DSP"},
      {"claim", "claiming: instructions"},
      {"claim_bus_a", "claiming: bus A"},
      {"claim_bus_b", "claiming: bus B"},
      {"lock", "another master held the list"},
      {"behind_list", "behind blocks with earlier places in the list"},
      {"blocked", "every DSP ran a block claimed earlier"},
      {"no_dsp", "no DSP was there"},
      {"own_dsp_out", "the only DSP that may run it was out"},
      {"lost_run", "runs lost when their DSP failed"},
      {"watchdog", "until the watchdog noticed"},
      {"execution.execute", "ran longer: more instructions"},
      {"execution.slow_clock", "ran longer: slowed DSP"}};
  for (const auto& [name, meaning] : words)
    if (name == part) return std::string(meaning);
  constexpr std::string_view execution = "execution.";
  if (!part.starts_with(execution)) return std::string(part);
  std::string cause(part.substr(execution.size()));
  std::ranges::replace(cause, '_', ' ');
  return "ran longer: " + cause;
}

/// " (obstacle_avoidance 97 %)": the kinds of the blocks in the way.
std::string in_the_way(std::vector<Share> behind) {
  if (behind.empty()) return "";
  std::ranges::stable_sort(behind, std::greater{}, &Share::amount);
  double whole = 0;
  for (const Share& part : behind) whole += static_cast<double>(part.amount);
  const auto share = [&](const Share& part) {
    return fmt::format("{} {} %", part.name, percent(static_cast<double>(part.amount), whole));
  };
  return fmt::format("    in the way: {}{}\n", share(behind[0]), behind.size() > 1 ? ", " + share(behind[1]) : "");
}

/// The parts of a kind's chains on average, the largest first until they make up nine tenths, and their sum.
std::string chain(const WhyLate& why) {
  if (why.chains == 0) return "";
  std::vector<Share> longer;
  double whole = 0, shorter = 0;
  for (const Share& part : why.parts) {
    if (part.name == "slack") continue;
    if (part.amount > 0)
      longer.push_back(part), whole += static_cast<double>(part.amount);
    else
      shorter += static_cast<double>(part.amount);
  }
  std::ranges::stable_sort(longer, std::greater{}, &Share::amount);
  const auto mean = [&](double ps) { return duration(ps / static_cast<double>(why.chains)); };
  std::string text;
  double listed = 0;
  for (const Share& part : longer) {
    if (listed >= 0.9 * whole) break;
    listed += static_cast<double>(part.amount);
    text += fmt::format("    {:>10}  {}\n", mean(static_cast<double>(part.amount)), explained(part.name));
  }
  if (whole - listed >= 0.5) text += fmt::format("    {:>10}  all else\n", mean(whole - listed));
  if (shorter < 0) text += fmt::format("  - {:>10}  ran shorter, or not to the end\n", mean(-shorter));
  for (const Share& part : why.parts)
    if (part.name == "slack" && part.amount < 0)
      text += fmt::format("  - {:>10}  slack\n", mean(static_cast<double>(-part.amount)));
    else if (part.name == "slack")
      text += fmt::format("    {:>10}  too little time from the start\n", mean(static_cast<double>(part.amount)));
  return text + in_the_way(why.behind);
}

std::string reasons(const RunReport& report) {
  std::string text;
  for (const TaskReport& task : report.tasks) {
    if (task.misses == 0) continue;
    text += fmt::format("  {}: {} of {} missed ({} %), at most {} in a row", task.kind, task.misses, task.released,
                        percent(static_cast<double>(task.misses), static_cast<double>(task.released)),
                        task.longest_miss_streak);
    if (task.lateness.count > 0)
      text += fmt::format("; late by {} on average, {} at worst", duration(task.lateness.mean),
                          duration(static_cast<double>(task.lateness.worst)));
    text += ".\n";
    const WhyLate& why = task.why_late;
    for (const DropCause& cause : drop_causes)
      if (const std::uint64_t dropped = why.dropped[static_cast<std::size_t>(cause.wait)]; dropped > 0)
        text += fmt::format("    {} dropped: {}\n", dropped, cause.text);
    if (why.chains > 0)
      text += fmt::format("    on average over {}, beyond a usual run{}:\n",
                          why.chains == 1 ? "one job" : fmt::format("{} jobs", why.chains),
                          why.usual ? " of " + duration(static_cast<double>(*why.usual)) : "");
    text += chain(why);
  }
  if (!report.judged()) return heading("No job was finished, and none was missed.");
  return text.empty() ? heading("No deadline was missed.") : heading("Why deadlines were missed") + text;
}

/// All boots at power-on together; each later boot by itself.
std::string boots(const RunReport& report) {
  std::string later;
  std::optional<Time> shortest, longest;
  if (report.boot_words == 0) return "";
  for (const DspReport& dsp : report.dsps)
    for (const BootReport& boot : dsp.boots) {
      const bool power_on = boot.reset == Time{};
      if (power_on && boot.booted) {
        shortest = std::min(shortest.value_or(*boot.booted), *boot.booted);
        longest = std::max(longest.value_or(*boot.booted), *boot.booted);
      } else {
        later += fmt::format("  dsp {} {}: {}\n", dsp.slot,
                             power_on ? "at power-on" : fmt::format("reset at {:.6f} s", seconds(boot.reset)),
                             boot.booted ? fmt::format("its program ran after {:.3f} ms",
                                                       static_cast<double>((*boot.booted - boot.reset).count()) * 1e-9)
                                         : "its program has not run yet");
      }
    }
  if (!longest) return later;
  return fmt::format("  booted over their links at power-on: {} words each, programs ran from {:.3f} to {:.3f} ms\n",
                     report.boot_words, static_cast<double>(shortest->count()) * 1e-9,
                     static_cast<double>(longest->count()) * 1e-9) +
         later;
}

/// Columns are DSPs, eight at a time; rows are the causes that occur on any DSP.
std::string dsps(const RunReport& report) {
  constexpr std::size_t per_table = 8;
  std::string text;
  for (std::size_t first = 0; first < report.dsps.size(); first += per_table) {
    const auto group = std::span(report.dsps).subspan(first, std::min(per_table, report.dsps.size() - first));
    std::vector<std::string> header{"% of cycles"}, cycles{"Mcycles"}, instructions{"Minstructions"}, claims{"blocks"};
    for (const DspReport& dsp : group) {
      header.push_back(fmt::format("dsp {}", dsp.slot));
      cycles.push_back(fmt::format("{:.1f}", static_cast<double>(dsp.cycles) * 1e-6));
      instructions.push_back(fmt::format("{:.2f}", static_cast<double>(dsp.instructions) * 1e-6));
      claims.push_back(count(dsp.claims));
    }
    TextTable table(std::move(header));
    for (std::size_t cause = 0; cause < group.front().causes.size(); ++cause) {
      std::vector<std::string> row{group.front().causes[cause].name};
      bool any = false;
      for (const DspReport& dsp : group) {
        const std::int64_t amount = cause < dsp.causes.size() ? dsp.causes[cause].amount : 0;
        any = any || amount != 0;
        row.push_back(percent(static_cast<double>(amount), static_cast<double>(dsp.cycles)));
      }
      if (any) table.add(std::move(row));
    }
    table.add(std::move(cycles));
    table.add(std::move(instructions));
    table.add(std::move(claims));
    text += table.render();
    for (const DspReport& dsp : group)
      if (dsp.state != "running" && dsp.state != "idle") text += fmt::format("  dsp {} is {}\n", dsp.slot, dsp.state);
  }
  return text.empty() ? "" : heading("DSPs") + text + boots(report);
}

/// The masters' waits as histograms, and how often targets stopped them.
std::string waits(const BusReport& bus) {
  static constexpr const char* names[] = {"0", "1", "2-3", "4-7", "8-15", "16-31", "32-63", "64-127", ">127"};
  constexpr std::size_t last = std::size(names) - 1;
  std::size_t used = 0;
  bool stopped = false;
  for (const MasterReport& master : bus.masters) {
    for (std::size_t bin = 0; bin < master.wait.histogram.size(); ++bin)
      if (master.wait.histogram[bin] != 0) used = std::max(used, std::min(bin, last));
    stopped = stopped || master.retries + master.disconnects > 0;
  }
  std::vector<std::string> header{"% by wait"};
  for (std::size_t bin = 0; bin <= used; ++bin) header.push_back(names[bin]);
  if (stopped) header.insert(header.end(), {"retries", "disconnects"});
  TextTable table(std::move(header));
  for (const MasterReport& master : bus.masters) {
    if (master.transactions == 0) continue;
    std::vector<std::string> row{master.name};
    for (std::size_t bin = 0; bin <= used; ++bin) {
      std::uint64_t entries = master.wait.histogram[bin];
      if (bin == last)
        for (std::size_t more = last + 1; more < master.wait.histogram.size(); ++more)
          entries += master.wait.histogram[more];
      row.push_back(percent(static_cast<double>(entries), static_cast<double>(master.wait.count)));
    }
    if (stopped) row.insert(row.end(), {count(master.retries), count(master.disconnects)});
    table.add(std::move(row));
  }
  return table.empty() ? "" : table.render();
}

std::string links(const RunReport& report) {
  if (report.links.empty()) return "";
  TextTable table({"link, in words", "sent", "arrived", "lost", "discarded", "joined", "at the end"});
  for (const LinkReport& link : report.links)
    for (const LinkReport::Direction& way : link.directions)
      table.add({way.from + " to " + way.to, count(way.sent), count(way.arrived), count(way.lost), count(way.discarded),
                 count(link.joined), link.is_cut ? "cut" : "joined"});
  return heading("Links between DSPs") + table.render();
}

std::string nets(const RunReport& report) {
  if (report.nets.empty()) return "";
  TextTable table({"net", "pins", "edges", "missed by receivers", "at the end"});
  for (const NetReport& net : report.nets)
    table.add({net.name, net.pins, count(net.edges), count(net.missed), net.high ? "high" : "low"});
  return heading("Nets between pins of DSPs") + table.render();
}

std::string buses(const RunReport& report) {
  std::string text;
  for (const BusReport& bus : report.buses) {
    const auto share = [&](std::int64_t clocks) {
      return percent(static_cast<double>(clocks), static_cast<double>(bus.clocks));
    };
    text += heading(fmt::format("Bus {}: {} % data, {} % wait, {} % turnaround, {} % idle though requested, {} % idle",
                                bus.name, share(bus.data), share(bus.wait), share(bus.turnaround),
                                share(bus.idle_requested), share(bus.idle)));
    TextTable table({"waits in clocks", "transfers", "read", "written", "mean", "p50", "p99", "p99.9", "worst"});
    for (const MasterReport& master : bus.masters)
      if (master.transactions > 0)
        table.add({master.name, count(master.transactions), count(master.words_read), count(master.words_written),
                   fmt::format("{:.2f}", master.wait.mean), fmt::format("{}", master.wait.p50),
                   fmt::format("{}", master.wait.p99), fmt::format("{}", master.wait.p99_9),
                   fmt::format("{}", master.wait.worst)});
    if (!table.empty()) text += table.render() + waits(bus);
  }
  return text;
}

std::string cycles(const RunReport& report) {
  const std::string makespan = report.makespan ? fmt::format("; the job took {} s", in_seconds(report.makespan)) : "";
  std::string text =
      heading(fmt::format("Work cycles: {} completed, {} container{} delivered{}", report.cycles_completed,
                          report.containers_delivered, report.containers_delivered == 1 ? "" : "s", makespan));
  TextTable table(
      {"s", "AGV", "t_3", "t_4", "t_5", "t_6", "t_v", "t_w", "t_wait", "T_g", "T_a", "N^_a", "delivered at"});
  for (const CycleReport& cycle : report.cycles)
    table.add({fmt::format("cycle {}", cycle.number), cycle.agv ? fmt::format("{}", *cycle.agv) : "-",
               in_seconds(cycle.t3), in_seconds(cycle.t4), in_seconds(cycle.t5), in_seconds(cycle.t6),
               in_seconds(cycle.t_v), in_seconds(cycle.t_w), in_seconds(cycle.t_wait), in_seconds(cycle.T_g),
               in_seconds(cycle.T_a), cycle.agv_interval ? fmt::format("{}", *cycle.agv_interval) : "-",
               in_seconds(cycle.delivered)});
  if (table.empty()) return text;
  const bool open = std::ranges::any_of(report.cycles, [](const CycleReport& cycle) { return cycle.t6 && !cycle.T_a; });
  return text + table.render() + (open ? "  t_w, t_wait and T_a: when the AGV has been loaded again\n" : "");
}

std::string host_work(const RunReport& report) {
  const HostReport& host = report.host;
  if (host.refreshes == 0) return "";
  return heading(fmt::format("Host: {} refreshes, {} skipped; {} doorbells; {} blocks recomputed", host.refreshes,
                             host.skipped_refreshes, host.doorbells, host.recomputed)) +
         fmt::format("  list held for {} on average, {} at worst\n  refresh takes {} on average, {} at worst\n",
                     duration(host.semaphore_hold.mean), duration(static_cast<double>(host.semaphore_hold.worst)),
                     duration(host.refresh_duration.mean), duration(static_cast<double>(host.refresh_duration.worst))) +
         fmt::format("  blocks in the list: {:.1f} on average, {} at most\n", host.list_length.mean,
                     host.list_length.worst);
}

std::string wind(const RunReport& report) {
  const WindReport& wind = report.wind;
  if (wind.above == Time{}) return "";
  const double share = seconds(wind.above) / seconds(wind.watched);
  return heading(fmt::format("Wind above {:g} m/s for {:.1f} s, {:.1f} % of the time", wind.limit_m_s,
                             seconds(wind.above), share * 100)) +
         fmt::format("  lifts waited for less wind: {:.1f} s, {} time{}\n", seconds(wind.waited), wind.waits,
                     wind.waits == 1 ? "" : "s");
}

std::string timed_events(const RunReport& report) {
  if (report.timed_events.empty() && report.timed_events_to_come == 0) return "";
  std::string text = heading("Scripted events");
  for (const TimedEventReport& event : report.timed_events)
    text += fmt::format("  {:.6f} s  {}\n", seconds(event.time), event.what);
  if (report.timed_events_to_come > 0)
    text += fmt::format("  {} more were due after the end\n", report.timed_events_to_come);
  return text;
}

std::string failures(const RunReport& report) {
  constexpr std::size_t shown = 10;
  if (report.failures.empty()) return "";
  std::string text = heading(fmt::format("Failures: {}", report.failures.size()));
  for (std::size_t i = 0; i < std::min(shown, report.failures.size()); ++i) {
    const FailureReport& failure = report.failures[i];
    text += fmt::format("  {:.6f} s  {}{}: {}\n", seconds(failure.time),
                        failure.dsp ? fmt::format("dsp {}, ", *failure.dsp) : "", failure.kind, failure.message);
  }
  if (report.failures.size() > shown)
    text += fmt::format("  and {} more (--report has all)\n", report.failures.size() - shown);
  return text;
}

}  // namespace

std::string to_text(const RunReport& report) {
  return title(report) + headline(report) + outcomes(report) + times(report) + reasons(report) + dsps(report) +
         links(report) + nets(report) + buses(report) + cycles(report) + errors_section(report) +
         after_stop_section(report) + host_work(report) + wind(report) + timed_events(report) +
         errors_text(report.errors_handled) + failures(report) +
         fmt::format("\ntask blocks: {} state changes checked, {} violations{}\n", report.audit.checks,
                     report.audit.violations.size(), report.braked ? "; every crane drive is braked" : "") +
         fmt::format("hash {} over {} events\n", report.hash, report.events);
}

}  // namespace report
