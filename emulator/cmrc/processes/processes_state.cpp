// The state of the processes.
#include <optional>
#include <string>

#include "cmrc/processes/processes.hpp"
#include "state/visitor.hpp"

namespace cmrc {

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

}  // namespace cmrc
