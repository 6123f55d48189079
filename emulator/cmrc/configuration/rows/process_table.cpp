#include "cmrc/configuration/rows/process_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "cmrc/configuration/rows/process_rows.hpp"
#include "cmrc/tasks/job_kinds.hpp"

namespace cmrc {
namespace {

/// The place of a row that no file of the user has.
Origin built_in(std::string_view kind, unsigned number) {
  return {.name = fmt::format("built-in row of {} {} (emulator config --processes)", kind, number)};
}
bool is_built_in(const Origin& origin) { return origin.line == 0; }

/// Everything that check() asks of a table; an error names the row's place, and of a built-in row also the places of
/// the rows that were given, which it does not fit.
class Checker {
 public:
  Checker(const ProcessTable& table, std::span<const UserTask> tasks) : table_(table), tasks_(tasks) {}

  void check() const {
    for (const Subprocess& row : table_.subprocesses) subprocess(row);
    for (const Process& process : table_.processes) {
      numbers(process);
      steps(process);
      tokens(process);
    }
    accounts();
    all_start();
    for (const UserTask& own : tasks_) released(own);
  }

 private:
  void released(const UserTask& own) const {
    const std::string name = "user." + own.name;
    const auto in_steps = [&](const Process& process) {
      return std::any_of(process.steps.begin(), process.steps.end(),
                         [&](const Step& step) { return step.task == name; });
    };
    const bool used = std::any_of(table_.processes.begin(), table_.processes.end(), in_steps) ||
                      std::any_of(table_.subprocesses.begin(), table_.subprocesses.end(),
                                  [&](const Subprocess& row) { return row.crane == name || row.agv == name; });
    if (own.period_ms == 0 && !used) {
      refuse(own.origin, "tasks.period_ms", fmt::format("nothing releases \"{}\"", own.name),
             "a period above 0, or a row of [[processes]] or [[subprocesses]] that names it, is expected");
    }
  }

  void require(bool holds, const Process& process, std::string_view field, const std::string& what,
               std::string_view right) const {
    if (!holds)
      refuse(process.origin, fmt::format("processes.{}", field),
             fmt::format("process {}: {}{}", process.number, what, beside(process.origin)), right);
  }

  /// Of a built-in row.
  std::string beside(const Origin& origin) const {
    if (!is_built_in(origin)) return "";
    std::vector<std::string> given;
    const auto list = [&](std::string_view kind, const auto& rows) {
      for (const auto& row : rows)
        if (!is_built_in(row.origin)) given.push_back(fmt::format("{} {} at {}", kind, row.number, row.origin.text()));
    };
    list("sub-process", table_.subprocesses);
    list("process", table_.processes);
    return given.empty() ? "" : fmt::format(" (rows of yours: {})", fmt::join(given, ", "));
  }

  bool users(std::string_view task) const {
    return std::any_of(tasks_.begin(), tasks_.end(), [&](const UserTask& own) { return task == "user." + own.name; });
  }

  void subprocess(const Subprocess& row) const {
    const auto refuse_row = [&](std::string_view field, const std::string& what, std::string_view right) {
      refuse(row.origin, fmt::format("subprocesses.{}", field),
             fmt::format("sub-process {}: {}{}", row.number, what, beside(row.origin)), right);
    };
    if (const Subprocess* own = built_in_processes().find_subprocess(row.number); own != nullptr && row.number <= 4) {
      // The host's own sub-processes: nothing else of their release can be configured.
      const bool demands = row.must == own->must || row.number == 1;  // for sub-process 1 the row decides
      if (row.crane != own->crane || row.agv != own->agv || row.release != own->release || !demands ||
          (row.release == Subprocess::Release::point && row.between_processes) || row.on_legs) {
        refuse_row("number", "only the name, of 1 `must`, and of 3 and 4 between_processes, can be changed",
                   "sub-processes of your own have numbers from 6 on");
      }
      for (const unsigned number : row.must) {
        if (!has(own->must, number))
          refuse_row("must", fmt::format("its task cannot demand {}", number), "1 and 2 are expected");
      }
      return;
    }
    if (!row.by_interval() && !row.by_event()) {
      refuse_row("release", "cannot be changed for sub-processes 1 to 4",
                 "\"interval\", \"event\" or \"interval_and_event\" is expected");
    }
    if (row.by_event() && !row.crane.empty()) {
      refuse_row("release", "the crane has no range sensor, so no object enters its field",
                 "release = \"interval\", or `agv` alone, is expected");
    }
    if (row.on_legs && row.between_processes) {
      refuse_row("on_legs", "between processes no leg is under way",
                 "on_legs or between_processes is expected, not both");
    }
    if (row.crane.empty() && row.agv.empty()) refuse_row("crane", "no task of any robot", "`crane` or `agv` names one");
    if (!row.must.empty()) refuse_row("must", "only sub-process 1 loads others", "no `must` is expected");
    if (!row.crane.empty() && !users(row.crane))
      refuse_row("crane", fmt::format("\"{}\" is not a task for the crane", row.crane),
                 "\"user.NAME\" of a row of [[tasks]] is expected");
    if (!row.agv.empty() && row.agv != "obstacle_avoidance" && !users(row.agv)) {
      refuse_row("agv", fmt::format("\"{}\" is not a task for an AGV", row.agv),
                 "\"obstacle_avoidance\" or \"user.NAME\" of a row of [[tasks]] is expected");
    }
  }

  void numbers(const Process& process) const {
    for (const auto& [field, list] :
         {std::pair{"must", &process.must}, std::pair{"may", &process.may}, std::pair{"initial", &process.initial},
          std::pair{"replaces", &process.replaces}}) {
      for (const unsigned number : *list) {
        require(table_.find(number) != nullptr, process, field, fmt::format("there is no process {}", number),
                "the number of a row is expected");
      }
    }
    for (const unsigned number : process.subprocesses) {
      require(table_.find_subprocess(number) != nullptr, process, "subprocesses",
              fmt::format("there is no sub-process {}", number), "the number of a row of [[subprocesses]] is expected");
    }
  }

  void steps(const Process& process) const {
    using Kind = Step::Kind;
    static const std::set<Kind> of_crane = {Kind::task, Kind::leg,   Kind::settle, Kind::lower, Kind::lock,
                                            Kind::open, Kind::raise, Kind::align,  Kind::hold};
    static const std::set<Kind> of_agv = {Kind::task, Kind::leg, Kind::queue, Kind::hand_over, Kind::hold};
    static const std::set<Kind> servo = {Kind::leg,  Kind::align, Kind::settle, Kind::lower,
                                         Kind::lock, Kind::open,  Kind::raise};
    static const std::set<Kind> points = {Kind::leg, Kind::align, Kind::queue};
    require(!process.steps.empty(), process, "steps", "no step", "at least one is expected");
    for (const Step& step : process.steps) {
      const std::string text = to_text(step);
      const bool fits = process.robot == Robots::none
                            ? step.kind == Kind::task
                            : (process.robot == Robots::crane ? of_crane : of_agv).contains(step.kind);
      require(fits, process, "steps", fmt::format("\"{}\" is not for its robot", text),
              "docs/processes.md lists the steps of each robot");
      const auto needs = [&](const std::set<Kind>& kinds, unsigned a, unsigned b) {
        require(!kinds.contains(step.kind) || (has(process.subprocesses, a) && has(process.subprocesses, b)), process,
                "subprocesses", fmt::format("\"{}\" needs sub-processes {} and {}", text, a, b),
                "both are expected in the list");
      };
      needs(points, 1, 2);
      const Subprocess& planning = *table_.find_subprocess(1);
      for (const unsigned number : {1U, 2U}) {
        if (!points.contains(step.kind) || has(planning.must, number)) continue;
        refuse(planning.origin, "subprocesses.must",
               fmt::format("without {} \"{}\" of process {} would never end{}", number, text, process.number,
                           beside(planning.origin)),
               "must = [1, 2] is expected");
      }
      if (process.robot == Robots::crane) needs(servo, 3, 4);
      require(step.kind != Kind::align || has_agv(process), process, "steps", "\"align\" without an AGV",
              "a process to which an AGV's consents is expected: it has the one in the loading spot");
      require(process.robot != Robots::agv || step.kind != Kind::leg || step.leg != 2, process, "steps",
              "leg 2 of an AGV is its way to the queue", "\"queue\" is expected in its place");
      if (step.kind == Kind::task) task(process, step.task);
    }
  }

  void task(const Process& process, const std::string& name) const {
    const auto fits = [&](const KindRow& row) {
      return row.step == StepOf::both || (row.step == StepOf::crane && process.robot == Robots::crane) ||
             (row.step == StepOf::agv && process.robot == Robots::agv);
    };
    std::vector<std::string_view> known;
    for (const KindRow& row : kind_rows)
      if (fits(row)) known.push_back(row.name);
    require(std::ranges::find(known, name) != known.end() || users(name), process, "steps",
            fmt::format("\"{}\" is not a possible task", name),
            fmt::format("{} or user.NAME of a row of [[tasks]] is expected", fmt::join(known, ", ")));
  }

  void tokens(const Process& process) const {
    for (const unsigned source : process.initial) {
      require(has(table_.find(source)->may, process.number), process, "initial",
              fmt::format("process {} never consents to it", source),
              fmt::format("{} in `may` of process {}, or not here", process.number, source));
    }
    for (const Consent& consent : process.clears) {
      const Process* source = table_.find(consent.source);
      require(source != nullptr && has(source->may, consent.target), process, "clears",
              fmt::format("there is no consent {}->{}", consent.source, consent.target),
              "one that `may` of its source lists is expected");
    }
    require(process.replaces.empty() || process.robot == Robots::agv, process, "replaces",
            "only an AGV's process replaces another", "robot = \"agv\", or no `replaces`");
    if (process.notified_by_task) {
      require(process.steps.back().kind == Step::Kind::task, process, "notify", "its last step is not a task",
              "\"host\" is expected");
      for (const unsigned number : process.must)
        require(number <= 8, process, "must", fmt::format("TB_NOTIFY has no bit for process {}", number),
                "a number up to 8 is expected");
      for (const unsigned number : process.may)
        require(number <= 8, process, "may", fmt::format("TB_NOTIFY has no bit for process {}", number),
                "a number up to 8 is expected");
    }
    for (const unsigned number : process.must) {
      require(table_.find(number)->robot != Robots::agv || has_agv(process), process, "must",
              fmt::format("no AGV is named for process {}", number),
              "an AGV's process is demanded by one that has an AGV: an AGV's own, or one of the crane to which an "
              "AGV's consents");
    }
    require(!process.loaded || process.robot == Robots::none, process, "loaded",
            "a robot's process begins by consent or demand", "robot = \"none\", or initial consents");
  }

  // t_3 and t_4 belong to the crane, t_5 and t_6 to an AGV, and each is the time of one process.
  void accounts() const {
    std::map<Account, unsigned> by;
    for (const Process& process : table_.processes) {
      if (process.account == Account::none) continue;
      const auto number = static_cast<unsigned>(process.account) + 2;
      const bool of_crane = process.account == Account::t_3 || process.account == Account::t_4;
      require(process.robot == (of_crane ? Robots::crane : Robots::agv), process, "account",
              fmt::format("t_{} does not belong to its robot", number),
              of_crane ? "a process of the crane is expected" : "a process of an AGV is expected");
      require(process.account != Account::t_4 || has_agv(process), process, "account",
              "t_4 without an AGV that is loaded", "a process of the crane to which an AGV's consents is expected");
      const auto [first, alone] = by.emplace(process.account, process.number);
      require(alone, process, "account", fmt::format("t_{} is already the time of process {}", number, first->second),
              "each of t_3 to t_6 in one row");
    }
  }

  bool has_agv(const Process& process) const {
    if (process.robot == Robots::agv) return true;
    const auto sources = table_.sources(process.number);
    return process.robot == Robots::crane && std::any_of(sources.begin(), sources.end(), [&](unsigned n) {
             return table_.find(n)->robot == Robots::agv;
           });
  }

  /// A process can start if it is loaded, if one that can start demands it, or if each process that must consent has
  /// consented or can start.
  void all_start() const {
    std::set<unsigned> can;
    const auto starts = [&](const Process& process) {
      const auto sources = table_.sources(process.number);
      const auto demanded = [&](const Process& other) {
        return can.contains(other.number) && has(other.must, process.number);
      };
      const auto consents = [&](unsigned source) { return has(process.initial, source) || can.contains(source); };
      return process.loaded || std::any_of(table_.processes.begin(), table_.processes.end(), demanded) ||
             (!sources.empty() && std::all_of(sources.begin(), sources.end(), consents));
    };
    for (bool grown = true; grown;) {
      grown = false;
      for (const Process& process : table_.processes) {
        if (!can.contains(process.number) && starts(process)) grown = can.insert(process.number).second;
      }
    }
    for (const Process& process : table_.processes) {
      std::vector<unsigned> missing;
      for (const unsigned source : table_.sources(process.number)) {
        if (!has(process.initial, source) && !can.contains(source)) missing.push_back(source);
      }
      require(can.contains(process.number), process, "number",
              missing.empty()
                  ? std::string("can never start: no process demands or consents to it")
                  : fmt::format(
                        "can never start: it waits for process {}, which waits for others in a circle or never starts",
                        fmt::join(missing, ", ")),
              "a `must`, a `may`, an `initial` consent or `loaded` is expected");
    }
  }

  const ProcessTable& table_;
  std::span<const UserTask> tasks_;
};

}  // namespace

const Process* ProcessTable::find(unsigned number) const {
  const auto found = std::find_if(processes.begin(), processes.end(),
                                  [number](const Process& process) { return process.number == number; });
  return found == processes.end() ? nullptr : &*found;
}

const Subprocess* ProcessTable::find_subprocess(unsigned number) const {
  const auto found = std::find_if(subprocesses.begin(), subprocesses.end(),
                                  [number](const Subprocess& row) { return row.number == number; });
  return found == subprocesses.end() ? nullptr : &*found;
}

const Subprocess& ProcessTable::subprocess_of(std::string_view task) const {
  const auto found = std::find_if(subprocesses.begin(), subprocesses.end(),
                                  [task](const Subprocess& row) { return row.crane == task || row.agv == task; });
  if (found == subprocesses.end())
    throw std::logic_error(fmt::format("ProcessTable: no sub-process has the task {}", task));
  return *found;
}

std::vector<unsigned> ProcessTable::sources(unsigned target) const {
  std::vector<unsigned> all;
  for (const Process& process : processes) {
    if (has(process.may, target)) all.push_back(process.number);
  }
  return all;
}

const ProcessTable& built_in_processes() {
  static const ProcessTable table = [] {
    const toml::table rows = toml::parse(built_in_processes_text(), std::string_view("processes.toml"));
    ProcessTable read;
    ConfigErrors errors;
    read_subprocesses(*rows.get("subprocesses"), "processes.toml", read, errors);
    read_processes(*rows.get("processes"), "processes.toml", read, errors);
    errors.finish();
    for (Process& row : read.processes) row.origin = built_in("process", row.number);
    for (Subprocess& row : read.subprocesses) row.origin = built_in("sub-process", row.number);
    return read;
  }();
  return table;
}

void check(const ProcessTable& table, std::span<const UserTask> tasks) { Checker(table, tasks).check(); }

}  // namespace cmrc
