// The state of the host.
#include "cmrc/host/host.hpp"
#include "state/visitor.hpp"

namespace cmrc {

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
  servo_.list_state(list);
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
  list("resets", resets_);
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
  list("lengths", lengths_);
  if (!list.loads()) return;
  parameters_ = importance_parameters(config_);
  set_releases();
}

}  // namespace cmrc
