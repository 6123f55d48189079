// RunReport as JSON: docs/report.md is the schema. A change of a key's meaning raises schema_version.
#include "report/json/errors_json.hpp"
#include "report/json/json_values.hpp"
#include "report/json/measures_json.hpp"
#include "report/version.hpp"

namespace report {
namespace {

using Json = nlohmann::ordered_json;

Json optional_seconds(const std::optional<Time>& time) { return time ? Json(seconds(*time)) : Json(nullptr); }

Json shares(const std::vector<Share>& list) {
  Json object = Json::object();
  for (const Share& share : list) object[share.name] = share.amount;
  return object;
}

Json histogram(const Log2Histogram& bins) {
  std::size_t used = bins.size();
  while (used > 0 && bins[used - 1] == 0) --used;
  Json list = Json::array();
  for (std::size_t bin = 0; bin < used; ++bin) list.push_back(bins[bin]);
  return list;
}

/// null without samples: 0 would look like a measurement.
template <class Value>
Json measured(std::uint64_t samples, Value value) {
  return samples > 0 ? Json(value) : Json(nullptr);
}

Json summary(const Summary& of) {
  return {{"count", of.count},
          {"best", measured(of.count, of.best)},
          {"mean", measured(of.count, of.mean)},
          {"p50", measured(of.count, of.p50)},
          {"p99", measured(of.count, of.p99)},
          {"p99_9", measured(of.count, of.p99_9)},
          {"worst", measured(of.count, of.worst)},
          {"percentiles", of.exact_percentiles ? "exact" : "within 0.1 %"},
          {"log2_histogram", histogram(of.histogram)}};
}

Json why_late(const WhyLate& of) {
  Json all = {{"jobs", of.chains},
              {"jobs_with_deadline", of.with_deadline},
              {"lateness_ps", of.lateness},
              {"usual_ps", of.usual ? Json(*of.usual) : Json(nullptr)},
              {"parts_ps", shares(of.parts)},
              {"behind_ps", shares(of.behind)}};
  for (const DropCause& cause : drop_causes)
    all["dropped_" + name(cause.wait)] = of.dropped[static_cast<std::size_t>(cause.wait)];
  return all;
}

Json jitter(const Jitter& of) {
  return {{"count", of.count},
          {"peak_to_peak", measured(of.count, of.peak_to_peak)},
          {"worst", measured(of.count, of.worst)},
          {"rms", measured(of.count, of.rms)}};
}

Json task(const TaskReport& of) {
  return {{"released", of.released},
          {"on_time", of.on_time},
          {"late", of.late},
          {"unfinished", of.unfinished},
          {"never_started", of.never_started},
          {"lost", of.lost},
          {"dropped", of.dropped},
          {"misses", of.misses},
          {"longest_miss_streak", of.longest_miss_streak},
          {"response_ps", summary(of.response)},
          {"waiting_ps", summary(of.waiting)},
          {"execution_ps", summary(of.execution)},
          {"lateness_ps", summary(of.lateness)},
          {"start_jitter_ps", jitter(of.start_jitter)},
          {"execution_causes_ps", shares(of.execution_causes)},
          {"execution_cycles", shares(of.execution_cycles)},
          {"why_late", why_late(of.why_late)}};
}

Json optional_ps(const std::optional<Time>& time) { return time ? Json(time->count()) : Json(nullptr); }

Json miss(const MissReport& of, const std::vector<TaskReport>& kinds) {
  Json behind = Json::array();
  for (const BlockingJob& block : of.behind)
    behind.push_back({{"kind", kinds.at(block.job.kind).kind},
                      {"robot", block.job.robot},
                      {"number", block.job.number},
                      {"dsp", block.slot},
                      {"claimed_ps", block.claimed.count()},
                      {"from_ps", block.from.count()},
                      {"to_ps", block.to.count()},
                      {"share_ps", block.share},
                      {"overtook", block.overtook}});
  Json runs = Json::array();
  for (const Run& run : of.runs)
    runs.push_back({{"dsp", run.slot},
                    {"claimed_ps", run.claimed.count()},
                    {"ended_ps", run.ended.count()},
                    {"end", name(run.end)}});
  return {{"kind", of.kind},
          {"robot", of.job.robot},
          {"number", of.job.number},
          {"outcome", of.outcome},
          {"release_ps", of.released.count()},
          {"deadline_ps", optional_ps(of.deadline)},
          {"end_ps", of.end.count()},
          {"lateness_ps", or_null(of.lateness)},
          {"usual_ps", or_null(of.usual)},
          {"unavoidable_ps", optional_ps(of.unavoidable)},
          {"parts_ps", shares(of.parts)},
          {"behind", std::move(behind)},
          {"runs", std::move(runs)},
          {"previous", or_null(of.previous)}};
}

Json dsp(const DspReport& of) {
  Json boots = Json::array();
  for (const BootReport& boot : of.boots)
    boots.push_back({{"reset_at_s", seconds(boot.reset)},
                     {"boot_s", boot.booted ? Json(seconds(*boot.booted - boot.reset)) : Json(nullptr)}});
  return {{"slot", of.slot},
          {"state", of.state},
          {"clock_hz", of.clock_hz},
          {"clock_ppm", of.clock_ppm},
          {"cycles", of.cycles},
          {"instructions", of.instructions},
          {"causes", shares(of.causes)},
          {"claims", of.claims},
          {"tasks_ps", shares(of.tasks)},
          {"faults", of.faults},
          {"resets", of.resets},
          {"dropped_writes", of.dropped_writes},
          {"boots", boots},
          {"link_words", {{"in", of.link_words_in}, {"out", of.link_words_out}, {"lost", of.link_words_lost}}}};
}

Json link(const LinkReport& of) {
  Json directions = Json::array();
  for (const LinkReport::Direction& way : of.directions)
    directions.push_back({{"from", way.from},
                          {"to", way.to},
                          {"sent", way.sent},
                          {"arrived", way.arrived},
                          {"lost", way.lost},
                          {"discarded", way.discarded}});
  return {{"joined", of.joined}, {"is_cut", of.is_cut}, {"directions", std::move(directions)}};
}

Json bus(const BusReport& of) {
  const std::int64_t busy = of.data + of.wait + of.turnaround;
  Json object = {
      {"clock_hz", of.clock_hz},
      {"clock_ppm", of.clock_ppm},
      {"clocks", of.clocks},
      {"utilisation", of.clocks > 0 ? Json(static_cast<double>(busy) / static_cast<double>(of.clocks)) : Json(nullptr)},
      {"clocks_by_use",
       {{"data", of.data},
        {"wait", of.wait},
        {"turnaround", of.turnaround},
        {"idle_requested", of.idle_requested},
        {"idle", of.idle}}},
      {"masters", Json::object()},
      {"targets", Json::object()}};
  for (const MasterReport& master : of.masters)
    object["masters"][master.name] = {{"transactions", master.transactions},
                                      {"words_read", master.words_read},
                                      {"words_written", master.words_written},
                                      {"wait_clocks", summary(master.wait)},
                                      {"retries", master.retries},
                                      {"disconnects", master.disconnects}};
  for (const TargetReport& target : of.targets)
    object["targets"][target.name] = {{"words_read", target.words_read}, {"words_written", target.words_written}};
  return object;
}

Json cycle(const CycleReport& of) {
  return {{"number", of.number},
          {"agv", of.agv ? Json(*of.agv) : Json()},
          {"t_3_s", optional_seconds(of.t3)},
          {"t_4_s", optional_seconds(of.t4)},
          {"t_5_s", optional_seconds(of.t5)},
          {"t_6_s", optional_seconds(of.t6)},
          {"t_w_s", optional_seconds(of.t_w)},
          {"t_v_s", optional_seconds(of.t_v)},
          {"t_wait_s", optional_seconds(of.t_wait)},
          {"T_g_s", optional_seconds(of.T_g)},
          {"T_a_s", optional_seconds(of.T_a)},
          {"agv_interval_refreshes", of.agv_interval ? Json(*of.agv_interval) : Json()},
          {"landings_missed", of.landings_missed},
          {"delivered_s", optional_seconds(of.delivered)}};
}

Json failure(const FailureReport& of) {
  return {{"time_s", seconds(of.time)},
          {"dsp", of.dsp ? Json(*of.dsp) : Json(nullptr)},
          {"kind", of.kind},
          {"message", of.message}};
}

Json timed_events(const std::vector<TimedEventReport>& list) {
  Json array = Json::array();
  for (const TimedEventReport& of : list) array.push_back({{"time_s", seconds(of.time)}, {"what", of.what}});
  return array;
}

Json host_work(const HostReport& of) {
  return {{"refreshes", of.refreshes},
          {"skipped_refreshes", of.skipped_refreshes},
          {"semaphore_hold_ps", summary(of.semaphore_hold)},
          {"refresh_duration_ps", summary(of.refresh_duration)},
          {"list_length", summary(of.list_length)},
          {"doorbells", of.doorbells},
          {"recomputed", of.recomputed},
          {"semaphores_freed", of.semaphores_freed}};
}

Json wind(const WindReport& of) {
  const double watched = seconds(of.watched);
  return {{"limit_m_s", of.limit_m_s},
          {"above_s", seconds(of.above)},
          {"above_share", watched > 0 ? Json(seconds(of.above) / watched) : Json(nullptr)},
          {"waited_s", seconds(of.waited)},
          {"waits", of.waits}};
}

Json settings(const std::vector<Setting>& list) {
  Json object = Json::object();
  for (const Setting& setting : list)
    std::visit([&](const auto& value) { object[setting.key] = value; }, setting.value);
  return object;
}

Json by_kind(const std::vector<TaskReport>& tasks) {
  Json object = Json::object();
  for (const TaskReport& of : tasks) object[of.kind] = task(of);
  return object;
}

}  // namespace

std::string tasks_to_json(const std::vector<TaskReport>& tasks) { return by_kind(tasks).dump(); }

std::string to_json(const RunReport& report) {
  Json root = {{"schema_version", schema_version},
               {"emulator_version", emulator_version},
               {"stop_reason", name(report.stop_reason)},
               {"simulated_s", seconds(report.simulated)},
               {"simulated_ps", report.simulated.count()},
               {"account_end_s", seconds(report.account_end)},
               {"elapsed_s", report.elapsed_s},
               {"hash", report.hash},
               {"events", report.events},
               {"configuration", settings(report.configuration)},
               {"configuration_toml", report.configuration_toml},
               {"tasks", by_kind(report.tasks)},
               {"misses", Json::array()},
               {"misses_left_out", report.misses_left_out},
               {"dsps", Json::array()},
               {"links", Json::array()},
               {"nets", Json::array()},
               {"buses", Json::object()},
               {"cycles", Json::array()},
               {"cycles_completed", report.cycles_completed},
               {"containers_delivered", report.containers_delivered},
               {"host", host_work(report.host)},
               {"wind", wind(report.wind)},
               {"timed_events", timed_events(report.timed_events)},
               {"timed_events_to_come", report.timed_events_to_come},
               {"audit", {{"checks", report.audit.checks}, {"violations", report.audit.violations}}},
               {"braked", report.braked},
               {"failures", Json::array()}};
  for (const MissReport& of : report.missed) root["misses"].push_back(miss(of, report.tasks));
  add_measures(report, root);
  root["boot_words"] = report.boot_words;
  for (const DspReport& of : report.dsps) root["dsps"].push_back(dsp(of));
  for (const LinkReport& of : report.links) root["links"].push_back(link(of));
  for (const NetReport& of : report.nets)
    root["nets"].push_back(
        {{"name", of.name}, {"pins", of.pins}, {"edges", of.edges}, {"missed", of.missed}, {"level", of.high ? 1 : 0}});
  for (const BusReport& of : report.buses) root["buses"][of.name] = bus(of);
  for (const CycleReport& of : report.cycles) root["cycles"].push_back(cycle(of));
  for (const FailureReport& of : report.failures) root["failures"].push_back(failure(of));
  root["errors_handled"] = errors_json(report.errors_handled);
  // Messages may quote a user's file. Bytes that are not UTF-8 are replaced instead of causing an exception.
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace report
