// The state of the controller, class by class: everything that lasts and affects later results. Not listed: what
// follows from the configuration alone, temporary values, observers and callbacks.
#include "cmrc/host/host.hpp"
#include "cmrc/measures/course.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/run/observer.hpp"
#include "state/visitor.hpp"

namespace cmrc {

// ---- the list, and the robots' work that is loaded into it ----

void TaskList::list_state(state::Visitor& list) {
  list("blocks", blocks_);
  list("order", order_);
  list("insertions", insertions_);
  list("size", size_);
  if (list.loads()) any_passed_ = true;
}

void PointChain::list_state(state::Visitor& list) {
  list("interval", interval_);
  list("cartesian", cartesian_);
  list("joint", joint_);
  list("consumed", consumed_);
  list("base", base_);
  list("base_count", base_count_);
  list("loaded_at", loaded_at_);
  list("planned_at", planned_at_);
  list("anchored", anchored_);
  list("drive_buffer", drive_buffer_);
  list("trajectory_out", trajectory_out_);
  list("inverse_out", inverse_out_);
  list("again", again_);
  list("ended", ended_);
  list("active", active_);
  list("begun_at", begun_at_);
  list("reported", reported_);
  list("begin_reported", begin_reported_);
  list("end_reported", end_reported_);
  list("abandoned", abandoned_);
}

void CraneSteps::list_state(state::Visitor& list) {
  list("chain", chain_);
  list("pid", pid_);
  list("interval", interval_);
  list("next_interval", next_interval_);
  list("speeds", speeds_);
  list("next_speeds", next_speeds_);
  list("consumed", consumed_);
  list("segment_start", segment_start_);
  list("since", since_);
  list("ramp_offset", ramp_offset_);
  list("ramp_end", ramp_end_);
  list("probes", probes_);
  list("hovering", hovering_);
  list("low", low_);
  list("unsteady", unsteady_);
  list("load", load_);
  list("hung", hung_);
  list("eased", eased_);
  list("freed", freed_);
  list("too_windy", too_windy_);
  list("servo_began", servo_began_);
  list("ramp_pending", ramp_pending_);
  list("ramp_reported", ramp_reported_);
  list("retrying", retrying_);
  list("phase", phase_);
  list("missed", missed_);
  list("again", again_);
  list("setting_down", setting_down_);
  list("leg", leg_);
  list("asked", asked_);
}

void Fleet::list_state(state::Visitor& list) { list("agvs", agvs_); }

void UserTasks::Row::list_state(state::Visitor& list) {
  list("next", next);
  list("out", out);
  list("stopped", stopped);
}

void UserTasks::list_state(state::Visitor& list) { list("rows", rows_); }

// ---- processes ----

void Consents::list_state(state::Visitor& list) { list("tokens", tokens_); }

void Release::list_state(state::Visitor& list) {
  list("seen", seen_);
  list("deadline", deadline_);
  list("out", out_);
  list("object", object_);
  list("stopped", stopped_);
}

void RangeField::list_state(state::Visitor& list) { list("last", last_); }

// A run points to its row of the table.
struct Processes::RunState {
  Run& run;
  const ProcessTable& table;

  void list_state(state::Visitor& list) {
    std::optional<unsigned> number;
    if (run.process != nullptr) number = run.process->number;
    list("process", number);
    if (list.loads()) run.process = number ? table.find(*number) : nullptr;
    if (list.loads() && number && run.process == nullptr)
      throw state::StateError("process " + std::to_string(*number) + " has no row in the table");
    list("step", run.step);
    list("agv", run.agv);
    list("wants_task", run.wants_task);
    list("silent", run.silent);
    list("stopped", run.stopped);
    list("retired", run.retired);
  }
};

// The watch on the field, and whether releases are staggered, come from the configuration; the host sets them.
void Processes::list_state(state::Visitor& list) {
  const auto run = [&](Run& one) {
    RunState state{one, table_};
    list("run", state);
  };
  list("consents", consents_);
  list("crane", crane_);
  list("fleet", fleet_);
  for (Run& one : free_runs_) run(one);
  run(crane_run_);
  for (Run& one : agv_runs_) run(one);
  list("start_waits", start_waits_);
  list("crane_held", crane_held_);
  list("crane_sets_down", crane_sets_down_);
  list("crane_down", crane_down_);
  list("demands", demands_);
  list("releases", releases_);
  list("fields", fields_);
  list("read_until", read_until_);
}

void ContainerCycles::list_state(state::Visitor& list) {
  list("cycles", cycles_);
  list("agvs", agvs_);
  list("started", started_);
  list("grabbed", grabbed_);
  list("closed", closed_);
  list("completed", completed_);
}

// ---- errors, parameters, boards ----

void PathClock::list_state(state::Visitor& list) {
  list("used", used_);
  list("begin", begin_);
  list("ticks", ticks_);
  list("from", from_);
  list("to", to_);
  list("change", change_);
  list("base", base_);
}

void Errors::list_state(state::Visitor& list) {
  list("entries", entries_);
  list("path", path_);
  list("wanted", wanted_);
  list("drives", drives_);
  list("drives_changed", drives_changed_);
  list("known", known_);
  list("sensor", sensor_);
  list("sway_after", sway_after_);
  list("late_after", late_after_);
  list("servo_stopped", servo_stopped_);
  list("timeouts", timeouts_);
  list("go_on_at", go_on_at_);
}

void ControlBlock::list_state(state::Visitor& list) {
  list("now", now_);
  list("wanted", wanted_);
  list("generation", generation_);
  list("rests", rests_);
  list("seen", seen_);
  if (list.loads()) compare();
}

void Liveness::list_state(state::Visitor& list) {
  list("slots", slots_);
  if (!list.loads()) return;
  known_ = slots_.size();
  while (known_ > 0 && slots_[known_ - 1].state == State::unknown) --known_;
}

void BootLoader::list_state(state::Visitor& list) {
  list("requested", requested_);
  list("asked", asked_);
  list("boots", boots_);
  list("ended", ended_);
}

// ---- the host ----

void Host::Servo::list_state(state::Visitor& list) {
  list("next", next);
  list("out", out);
  list("block", block);
  list("last_t", last_t);
  list("stopped", stopped);
  list("waits", waits);
}

void Host::list_state(state::Visitor& list) {
  // The keys that may change during a run.
  for (const Key& key : keys()) {
    if (!key.live) continue;
    Value value = key.read(config_);
    list(key.name, value);
    if (list.loads()) key.assign(config_, value);
  }
  list("changes", changes_);
  list("list", list_);
  list("processes", processes_);
  list("user_tasks", user_tasks_);
  list("errors", errors_);
  list("control", control_);
  list("cycles", cycles_);
  list("torque", torque_);
  list("pid", pid_);
  list("servoing_from", servoing_from_);
  list("first_refresh", first_refresh_);
  list("step", step_);
  list("wake_at", wake_at_);
  list("refresh_at", refresh_at_);
  list("now", now_);
  list("tick", tick_);
  list("elapsed", elapsed_);
  list("grown", grown_);
  list("linked", linked_);
  list("own_linked", own_linked_);
  list("passed", passed_);
  list("flags", flags_);
  list("fields", fields_);
  list("signs", signs_);
  list("done", done_);
  list("hung", hung_);
  list("pointer_in_doubt", pointer_in_doubt_);
  list("refused_since", refused_since_);
  list("refused", refused_);
  list("held_for", held_for_);
  list("dither", dither_);
  list("eligible", eligible_);
  list("fence", fence_);
  list("renewed", renewed_);
  list("suspect", suspect_);
  list("holder", holder_);
  list("liveness", liveness_);
  list("boots", boots_);
  list("pid_ended", pid_ended_);
  list("pid_runs", pid_runs_);
  list("drops", drops_);
  list("longest", longest_);
  list("gaps", gaps_);
  list("counts", counts_);
  list("wind_waited", wind_.waited);
  list("wind_waits", wind_.waits);
  list("wind_waits_now", wind_.waits_now);
  list("durations", durations_);
  list("lengths", lengths_);
  if (!list.loads()) return;
  parameters_ = importance_parameters(config_);
  set_releases();
}

// ---- jobs ----

void BlockAudit::list_state(state::Visitor& list) {
  list("blocks", blocks_);
  list("checks", checks_);
  list("violations", violations_);
}

void Timeline::list_state(state::Visitor& list) {
  list("slots", slots_);
  list("holders", holders_);
}

void WhyLate::list_state(state::Visitor& list) {
  list("usual", usual_);
  list("chains", chains_);
  list("sums", sums_);
  list("left_out", left_out_);
}

void EventTimes::list_state(state::Visitor& list) {
  list("count", count_);
  list("last", last_);
  list("bin", bin_);
  list("kept", kept_);
  list("bins", bins_);
}

void Ledger::list_state(state::Visitor& list) {
  list("account", account_);
  list("audit", audit_);
  list("timeline", timeline_);
  list("why", why_);
  list("open", open_);
  list("slots", slots_);
  list("released", released_);
  list("jobs", jobs_);
  list("refresh", refresh_);
  list("offered", offered_);
  list("misses", misses_);
}

// ---- measurements ----

void Course::list_state(state::Visitor& list) {
  list_all_but_rows(list);
  list.table("rows", rows_.first(size_), rows_.width());
}

void Course::list_all_but_rows(state::Visitor& list) {
  list("size", size_);
  if (size_ > rows_.room())
    throw state::StateError("a course of " + std::to_string(size_) + " rows, with room for " +
                            std::to_string(rows_.room()));
  list("every", every_);
  list("points_every", points_every_);
  list("processes_every", processes_every_);
  list("milestones_room", milestones_room_);
  list("legs", legs_);
  list("places", places_);
  list("milestones", milestones_);
  list("servo", servo_);
}

void Instability::list_state(state::Visitor& list) { list("joints", joints_); }

void WindWatch::list_state(state::Visitor& list) {
  list("next", next_);
  list("samples_above", samples_above_);
  list("samples", samples_);
}

void Standstill::list_state(state::Visitor& list) {
  list("stopped", stopped_);
  list("driven", driven_);
  list("braked", braked_);
}

void RunObserver::list_state(state::Visitor& list) {
  list("snapshots", snapshots_);
  list("blocks", blocks_);
  list("failures", failures_);
  list("refused", refused_);
  list("faults", faults_);
  list("resets", resets_);
  list("boots", boots_);
  list("hold", hold_);
  list("held_since", held_since_);
  list("pid_error", pid_error_);
  list("saturated", saturated_);
  list("errors_hold", errors_hold_);
  list("instability", instability_);
  list("standstill", standstill_);
  list("effort", effort_);
  list("effort_until", effort_until_);
  list("wind", wind_);
}

}  // namespace cmrc
