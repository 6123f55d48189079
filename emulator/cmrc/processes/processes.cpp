#include "cmrc/processes/processes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "cmrc/tasks/importance.hpp"

namespace cmrc {
namespace {

Robot robot_of(const Process& process, std::optional<unsigned> agv) {
  return process.robot == Robots::agv ? agv.value() + 1 : 0;
}

/// The process lifts a container: it does not begin in too much wind.
bool lifts(const Process& process) {
  return std::ranges::any_of(process.steps, [](const Step& step) { return step.kind == Step::Kind::lock; });
}

constexpr std::string_view avoidance = "obstacle_avoidance";

/// Avoidance also for parked vehicles: between processes, in slots and at the hand-over.
ProcessTable with_parked_load(ProcessTable table) {
  for (Subprocess& row : table.subprocesses) {
    if (row.agv == avoidance) row.between_processes = true, row.on_legs = false;
  }
  return table;
}

const Step* step_of(const Process& process, std::size_t step) {
  return step < process.steps.size() ? &process.steps[step] : nullptr;
}

}  // namespace

Processes::Processes(const ProcessTable& table, std::span<const UserTask> tasks, const CraneJob& crane,
                     const FleetJob& fleet, const Words& words)
    : table_(fleet.parked ? with_parked_load(table) : table),
      tasks_(tasks.begin(), tasks.end()),
      words_(words),
      consents_(table_, fleet.agvs),
      crane_(crane, words),
      fleet_(fleet, words),
      agv_runs_(fleet.agvs),
      demands_(most_processes + 1, std::vector<unsigned>(std::max(fleet.agvs, 1U))),
      fields_(fleet.agvs) {
  for (const Process& process : table_.processes) {
    if (process.robot == Robots::none) free_runs_.emplace_back();
  }
  for (const unsigned number : {1U, 2U}) {
    if (!has(table_.find_subprocess(1)->must, number)) undemandable_ |= words_.must_subprocess << number;
  }
  for (const Subprocess& row : table_.subprocesses) {
    if (!row.by_interval() && !row.by_event()) continue;
    if (!row.crane.empty()) releases_.emplace_back(row, 0, 0, 1);
    for (unsigned agv = 0; agv < fleet.agvs && !row.agv.empty(); ++agv) {
      if (row.agv != avoidance || fleet.avoidance) releases_.emplace_back(row, agv + 1, agv, fleet.agvs);
    }
  }
}

void Processes::start(HostServices& services) {
  fleet_.start(services);
  for (const Process& process : table_.processes) {
    for (const unsigned source : process.initial) {
      // For the crane's process the AGV in the spot consents, for an AGV's process this AGV.
      const bool every = process.robot == Robots::agv && table_.find(source)->robot == Robots::agv;
      for (unsigned agv = 0; agv < (every ? fleet_.size() : 1); ++agv) consents_.give(source, process.number, agv);
    }
    if (process.loaded) demand(process.number, std::nullopt, services);
    const auto queue = std::find_if(process.steps.begin(), process.steps.end(),
                                    [](const Step& step) { return step.kind == Step::Kind::queue; });
    if (queue == process.steps.end()) continue;
    for (unsigned agv = 0; agv < fleet_.size(); ++agv) {
      const bool waits = agv > 0 && !fleet_.job().driving;  // the AGV in the spot is ready
      if (agv_runs_[agv].process != nullptr || !(waits || fleet_.job().driving)) continue;
      agv_runs_[agv] = {.process = &process,
                        .step = static_cast<std::size_t>(queue - process.steps.begin()),
                        .agv = agv,
                        .silent = waits};
      if (waits) continue;
      services.robot_begins(agv + 1, process.number);
      services.process(process.number, true, agv + 1);
      fleet_.send_round(agv, services);
    }
  }
  for (Release& release : releases_) release.rests(services.tick());
}

// ---- processes that may start ----

bool Processes::takes_agv(const Process& process) const {
  const auto sources = table_.sources(process.number);
  return process.robot == Robots::crane && std::any_of(sources.begin(), sources.end(), [this](unsigned n) {
           return table_.find(n)->robot == Robots::agv;
         });
}

bool Processes::may_start(const Process& process, unsigned agv) const {
  return demands(process, agv) != 0 || consents_.all(process.number, agv);
}

const Process* Processes::next_of(Robots robot, unsigned agv) const {
  const Process* chosen = nullptr;
  for (const Process& process : table_.processes) {
    if (process.robot != robot) continue;
    if (robot == Robots::crane && takes_agv(process)) {
      const auto there = agv_in_spot();
      if (!there || !may_start(process, *there)) continue;
    } else if (!may_start(process, agv)) {
      continue;
    }
    if (chosen == nullptr || has(process.replaces, chosen->number)) chosen = &process;
  }
  return chosen;
}

std::optional<unsigned> Processes::agv_in_spot() const {
  for (unsigned agv = 0; agv < fleet_.size(); ++agv) {
    const Run& run = agv_runs_[agv];
    if (run.process != nullptr || run.retired || !fleet_.queued(agv) || fleet_.slot(agv) != 0) continue;
    const bool called = std::any_of(table_.processes.begin(), table_.processes.end(), [&](const Process& process) {
      return process.robot == Robots::agv && demands(process, agv) != 0;
    });
    if (!called) return agv;
  }
  return std::nullopt;
}

void Processes::demand(unsigned target, std::optional<unsigned> agv, HostServices& services) {
  const Process& process = *table_.find(target);
  demands_[target][process.robot == Robots::agv ? agv.value() : 0] = 1;
  if (process.robot == Robots::none) start_free(services);  // else its robot starts it when it is free
}

void Processes::start_free(HostServices& services) {
  std::size_t n = 0;
  for (const Process& process : table_.processes) {
    if (process.robot != Robots::none) continue;
    Run& run = free_runs_[n++];
    if (run.process == nullptr && !run.retired && may_start(process, 0)) begin(run, process, std::nullopt, services);
  }
}

// ---- from step to step ----

void Processes::begin(Run& run, const Process& process, std::optional<unsigned> agv, HostServices& services) {
  const unsigned one = agv.value_or(0);
  demands_[process.number][process.robot == Robots::agv ? one : 0] = 0;
  consents_.consume(process.number, one);
  for (const Consent& consent : process.clears) consents_.clear(consent.source, consent.target, one);
  run = {.process = &process, .agv = agv};
  if (process.robot != Robots::none) services.robot_begins(robot_of(process, agv), process.number);
  services.process(process.number, true, agv ? *agv + 1 : 0);
  enter(run, services);
}

void Processes::enter(Run& run, HostServices& services) {
  const Step& step = run.process->steps[run.step];
  run.wants_task = step.kind == Step::Kind::task;
  if (run.process->robot == Robots::agv)
    fleet_.enter(*run.agv, step, services);
  else if (!run.wants_task)
    crane_.enter(step, run.agv, services);
}

void Processes::advance(Run& run, Word notify, HostServices& services) {
  ++run.step;
  if (step_of(*run.process, run.step) != nullptr) return enter(run, services);
  end(run, notify, services);
}

void Processes::end(Run& run, Word notify, HostServices& services) {
  const Process& process = *run.process;
  const auto agv = run.agv;
  const auto given = [&](Word bit, unsigned number) {
    return !process.notified_by_task || (notify & bit << number) != 0;
  };
  if (!run.silent) services.process(process.number, false, agv ? *agv + 1 : 0);
  if (process.robot != Robots::none)
    services.milestone(robot_of(process, agv), Milestone::Kind::process_ended, 0, services.tick());
  run = {.retired = process.final};
  for (const unsigned target : process.may) {
    if (given(words_.may_process, target)) consents_.give(process.number, target, agv.value_or(0));
  }
  for (const unsigned target : process.must) {
    if (given(words_.must_process, target)) demand(target, agv, services);
  }
}

void Processes::each_running(const std::function<void(unsigned number, Robot agv)>& tell) const {
  const auto one = [&](const Run& run) {
    if (run.process != nullptr && !run.silent) tell(run.process->number, run.agv ? *run.agv + 1 : 0);
  };
  std::ranges::for_each(free_runs_, one);
  one(crane_run_);
  std::ranges::for_each(agv_runs_, one);
}

Task Processes::user_block(const std::string& name, Robot robot) const {
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    if ("user." + tasks_[i].name != name) continue;
    const auto number = static_cast<Word>(i);
    return {.x = tasks_[i].x,
            .kind = words_.kind_user + number,
            .robot = robot,
            .area = words_.us_base + number * words_.us_words,
            .argument = static_cast<std::uint32_t>(tasks_[i].argument)};
  }
  throw std::logic_error("Processes: a task that check() should have refused: " + name);
}

Task Processes::task_of(const Run& run, const HostServices& services) const {
  const std::string& name = run.process->steps[run.step].task;
  const Robot robot = run.process->robot == Robots::agv ? *run.agv + 1 : 0;
  const auto* row = std::ranges::find(kind_rows, name, &KindRow::name);
  Task task = row != kind_rows.end() ? cmrc::task_of(row->kind, words_, robot) : user_block(name, robot);
  task.tick = static_cast<std::uint32_t>(services.tick());
  task.process = run.process->number;
  return task;
}

void Processes::load_task(Run& run, HostServices& services) {
  if (!run.wants_task || run.stopped) return;
  run.wants_task = false;
  services.load(task_of(run, services), std::nullopt);
}

// ---- a refresh ----

void Processes::refresh(HostServices& services) {
  start_free(services);
  for (Run& run : free_runs_) load_task(run, services);
  load_task(crane_run_, services);
  move_crane(services);
  crane_.refresh(services);
  release(0, services);
  for (unsigned agv = 0; agv < fleet_.size(); ++agv) {
    move_agv(agv, services);
    fleet_.refresh(agv, services);
    release(agv + 1, services);
  }
  start_crane(services);  // an AGV may just have consented
}

void Processes::move_crane(HostServices& services) {
  Run& run = crane_run_;
  if (run.stopped || run.retired || crane_held_) return;
  if (run.process != nullptr) {
    const Step& step = run.process->steps[run.step];
    const bool done = step.kind != Step::Kind::task && crane_.done(step, services);
    if (crane_sets_down_ && (done || step.kind != Step::Kind::lower)) crane_down_ = true;
    if (crane_down_) return;
    if (done)
      advance(run, 0, services);
    else if (crane_.gave_up())
      run.stopped = true;
  }
  start_crane(services);
}

void Processes::start_crane(HostServices& services) {
  start_waits_ = false;
  if (crane_run_.process != nullptr || crane_run_.stopped || crane_run_.retired) return;
  const Process* next = next_of(Robots::crane, 0);
  start_waits_ = next != nullptr && crane_.too_windy() && lifts(*next);
  if (next != nullptr && !start_waits_)
    begin(crane_run_, *next, takes_agv(*next) ? agv_in_spot() : std::nullopt, services);
}

bool Processes::waits_for_wind() const {
  const Process* process = crane_run_.process;
  if (crane_run_.stopped || crane_held_) return false;
  if (process == nullptr) return start_waits_;
  return process->steps[crane_run_.step].kind == Step::Kind::lower && crane_.waits_for_wind();
}

void Processes::move_agv(unsigned agv, HostServices& services) {
  Run& run = agv_runs_[agv];
  if (run.stopped || run.retired) return;
  const auto start_next = [&] {
    if (const Process* next = next_of(Robots::agv, agv)) begin(run, *next, agv, services);
  };
  if (run.process == nullptr) return start_next();
  const Step& step = run.process->steps[run.step];
  if (step.kind == Step::Kind::task) return load_task(run, services);
  if (step.kind == Step::Kind::queue && !fleet_.moving_up(agv)) {
    const Process* next = next_of(Robots::agv, agv);
    if (next != nullptr && has(next->replaces, run.process->number)) return begin(run, *next, agv, services);
  }
  if (!fleet_.done(agv, step, services)) return;
  advance(run, 0, services);
  // A process that demands itself starts again at once.
  const bool called = std::any_of(table_.processes.begin(), table_.processes.end(), [&](const Process& process) {
    return process.robot == Robots::agv && demands(process, agv) != 0;
  });
  if (run.process == nullptr && !run.retired && called) start_next();
}

// ---- sub-processes ----

bool Processes::releases(unsigned number, Robot robot) const {
  const Run& run = run_of_robot(robot);
  if (run.retired) return false;
  return run.process != nullptr ? has(run.process->subprocesses, number)
                                : table_.find_subprocess(number)->between_processes;
}

bool Processes::job_done() const {
  return crane_run_.retired &&
         std::all_of(agv_runs_.begin(), agv_runs_.end(), [](const Run& run) { return run.retired; });
}

bool Processes::runs(const Release& release, std::int64_t tick) const {
  const Robot robot = release.robot();
  if (release.stopped() || !releases(release.row().number, robot)) return false;
  return !release.row().on_legs || (robot == 0 ? crane_.on_leg(tick) : fleet_.on_leg(robot - 1, tick));
}

Task Processes::block_of(const Release& release, std::int64_t tick) const {
  const Robot robot = release.robot();
  const std::string& name = robot == 0 ? release.row().crane : release.row().agv;
  Task task;
  if (name == avoidance) {
    task = cmrc::task_of(JobKind::obstacle_avoidance, words_, robot);
    task.argument = static_cast<std::uint32_t>(fleet_.job().avoidance_cycles);
  } else {
    task = user_block(name, robot);
  }
  task.y = robot == 0 ? robot_class::crane : robot_class::agv;
  task.robot = robot;
  task.tick = static_cast<std::uint32_t>(tick);
  task.subprocess = release.row().number;
  return task;
}

void Processes::release(Robot robot, HostServices& services) {
  for (Release& release : releases_) {
    if (release.robot() != robot) continue;
    if (!runs(release, services.tick())) {
      release.rests(services.tick());
      continue;
    }
    const std::int64_t period = interval(robot);
    const Release::Due due = release.due(services.tick(), period, staggered_);
    for (const std::int64_t nominal : due.dropped)
      services.drop(block_of(release, services.tick()), nominal, nominal + period);
    if (!due.load) continue;
    release.loaded(services.tick() + period);
    services.load(block_of(release, services.tick()), services.tick() + period);
  }
}

void Processes::each_passed(std::int64_t tick, const std::function<bool(const Task&)>& in_the_way,
                            const Passed& passed) const {
  for (const Release& release : releases_) {
    if (!runs(release, tick)) continue;
    const std::int64_t period = interval(release.robot());
    for (const std::int64_t nominal : release.passed(tick, period, staggered_))
      passed(block_of(release, tick), nominal, nominal + period, true);
    const Task task = block_of(release, tick);
    if (const auto last = release.last_passed(tick, period, staggered_, in_the_way(task)))
      passed(task, last->nominal, last->nominal + period, last->dropped);
  }
}

std::vector<unsigned> Processes::sensors_to_read(std::int64_t tick) {
  std::vector<unsigned> agvs;
  const std::int64_t before = std::exchange(read_until_, tick);
  for (unsigned agv = 0; agv < fleet_.size(); ++agv) {
    const bool watched = std::ranges::any_of(releases_, [&](const Release& release) {
      return release.robot() == agv + 1 && release.row().by_event() && runs(release, tick);
    });
    const std::int64_t phase = agv * watch_.every / fleet_.size();
    if (!watched)
      fields_[agv].forget();
    else if (congruent_before(tick, phase, watch_.every) > before)
      agvs.push_back(agv);
  }
  return agvs;
}

void Processes::seen(unsigned agv, Word millimetres) {
  if (!fields_.at(agv).entered(millimetres, watch_)) return;
  for (Release& release : releases_) {
    if (release.robot() == agv + 1) release.object_entered();
  }
}

// ---- finished blocks ----

Processes::Run& Processes::run_of(const Task& task) {
  const Process& process = *table_.find(task.process);
  if (process.robot == Robots::crane) return crane_run_;
  if (process.robot == Robots::agv) return agv_runs_.at(task.robot - 1);
  return *std::find_if(free_runs_.begin(), free_runs_.end(), [&](const Run& run) { return run.process == &process; });
}

Release* Processes::release_of(const Task& task) {
  return &*std::ranges::find_if(releases_, [&](const Release& release) {
    return release.row().number == task.subprocess && release.robot() == task.robot;
  });
}

void Processes::finished(const Task& task, Word result, Word notify, HostServices& services) {
  if (task.process != 0) return advance(run_of(task), notify, services);
  if (task.subprocess == 0) {
    const Word demands = notify & ~undemandable_;
    return task.robot == 0 ? crane_.finished(task, result, demands, services)
                           : fleet_.finished(task, result, demands, services);
  }
  release_of(task)->ended();
}

void Processes::dropped(const Task& task) {
  if (task.process != 0) {
    run_of(task).wants_task = true;
  } else if (task.subprocess == 0) {
    task.robot == 0 ? crane_.dropped(task) : fleet_.dropped(task);
  } else {
    release_of(task)->ended();
  }
}

std::string Processes::abandoned(const Task& task) {
  if (task.subprocess != 0) {
    release_of(task)->stop();
    return fmt::format("sub-process {} ({})", task.subprocess, table_.find_subprocess(task.subprocess)->name);
  }
  Run& run = task.process != 0 ? run_of(task) : task.robot == 0 ? crane_run_ : agv_runs_.at(task.robot - 1);
  run.stopped = true;
  if (task.process == 0) task.robot == 0 ? crane_.abandon() : fleet_.abandon(task.robot - 1);
  return run.process == nullptr ? std::string("the robot's motion")
                                : fmt::format("process {} ({})", run.process->number, run.process->name);
}

// ---- errors ----

void Processes::resume(const Task& task) {
  if (task.subprocess != 0) {
    release_of(task)->resume();
    release_of(task)->ended();
    return;
  }
  Run& run = task.process != 0 ? run_of(task) : task.robot == 0 ? crane_run_ : agv_runs_.at(task.robot - 1);
  run.stopped = false;
  if (task.process == 0) task.robot == 0 ? crane_.resume() : fleet_.resume(task.robot - 1);
  dropped(task);  // the block's work is requested again
}

bool Processes::crane_lowers() const {
  const Run& run = crane_run_;
  return run.process != nullptr && !run.stopped && run.process->steps[run.step].kind == Step::Kind::lower &&
         crane_.lowering();
}

void Processes::set_crane_down(bool asked) {
  crane_.set_down(asked);
  crane_sets_down_ = asked;
  if (!asked) crane_down_ = false;
  if (!asked && crane_.gave_up()) landing_again();
}

void Processes::landing_again() {
  crane_.landing_again();
  crane_run_.stopped = false;
}

}  // namespace cmrc
