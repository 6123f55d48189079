#include "cmrc/configuration/rows/user_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "cmrc/tasks/job_kinds.hpp"
#include "io/nearest.hpp"
#include "machine/system/bus_topology.hpp"

namespace cmrc {
namespace {

/// x is a kind of the paper's table.
bool is_taken(std::uint32_t x) { return std::ranges::find(kind_rows, x, &KindRow::x) != kind_rows.end(); }

/// "3, 4, 9, 10, 14 to 20 or one from 23 on"
std::string free_kinds() {
  const std::uint32_t last = std::ranges::max(kind_rows, {}, &KindRow::x).x;
  std::string text;
  for (std::uint32_t x = 1; x < last; ++x) {
    if (is_taken(x)) continue;
    const std::uint32_t first = x;
    while (!is_taken(x + 1)) ++x;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", first);
    if (x == first + 1) text += fmt::format(", {}", x);
    if (x > first + 1) text += fmt::format(" to {}", x);
  }
  return fmt::format("{} or one from {} on", text, last + 1);
}

constexpr std::size_t most_parameters = 32;

/// Takes fields by name, and reports those left over.
class TaskFields {
 public:
  TaskFields(const std::map<std::string, Field>& fields, const Origin& where) : fields_(fields), where_(where) {}

  const Field* find(const std::string& name) {
    const auto found = fields_.find(name);
    if (found == fields_.end()) return nullptr;
    ++taken_;
    return &found->second;
  }
  std::string text(const std::string& name, std::string_view right) {
    const Field* field = find(name);
    if (field == nullptr) refuse(where_, "tasks." + name, "is missing", right);
    const auto* word = std::get_if<std::string>(&field->value);
    if (word == nullptr || word->empty())
      refuse(field->origin, "tasks." + name, fmt::format("{} is {}", show(field->value), noun(field->value)), right);
    return *word;
  }
  double number(const std::string& name, std::optional<double> otherwise, double least, double most) {
    const std::string right = fmt::format("a number from {} to {} is expected", least, most);
    const Field* field = find(name);
    if (field == nullptr) {
      if (!otherwise) refuse(where_, "tasks." + name, "is missing", right);
      return *otherwise;
    }
    double value = 0;
    if (const auto* real = std::get_if<double>(&field->value))
      value = *real;
    else if (const auto* integer = std::get_if<std::int64_t>(&field->value))
      value = static_cast<double>(*integer);
    else
      refuse(field->origin, "tasks." + name, fmt::format("{} is {}", show(field->value), noun(field->value)), right);
    if (!(value >= least && value <= most))
      refuse(field->origin, "tasks." + name, fmt::format("{} is out of range", show(field->value)), right);
    return value;
  }
  std::int64_t integer(const std::string& name, std::optional<std::int64_t> otherwise, std::int64_t least,
                       std::int64_t most) {
    std::optional<double> fallback;
    if (otherwise) fallback = static_cast<double>(*otherwise);
    const double value = number(name, fallback, static_cast<double>(least), static_cast<double>(most));
    if (value != std::floor(value))
      refuse(fields_.at(name).origin, "tasks." + name, fmt::format("{} is not an integer", value),
             "an integer is expected");
    return static_cast<std::int64_t>(value);
  }
  /// To be called before a field is reported as missing: a misspelt field is then reported as it is written.
  void all_known(std::span<const std::string_view> known) const {
    for (const auto& [name, field] : fields_) {
      if (name.starts_with("parameter_") || std::find(known.begin(), known.end(), name) != known.end()) continue;
      refuse(field.origin, "tasks." + name, "no such field",
             quoted_list({known.begin(), known.end()}) + " or \"parameter_0\", \"parameter_1\", ... is expected" +
                 io::did_you_mean(name, known));
    }
  }
  /// The fields of the first `parameters` parameters have been taken.
  void nothing_left(std::size_t parameters) const {
    if (taken_ == fields_.size()) return;
    constexpr std::string_view prefix = "parameter_";
    std::vector<std::string> numbered;
    for (std::size_t i = 0; i < most_parameters; ++i) numbered.push_back(fmt::format("{}{}", prefix, i));
    for (const auto& [name, field] : fields_) {
      if (!name.starts_with(prefix)) continue;
      const auto known = std::ranges::find(numbered, name);
      if (known == numbered.end())
        refuse(field.origin, "tasks." + name, "no such parameter",
               fmt::format("at most {} are expected, {} to {}", most_parameters, numbered.front(), numbered.back()));
      if (static_cast<std::size_t>(known - numbered.begin()) < parameters) continue;
      refuse(field.origin, "tasks." + name, fmt::format("is given without {}", numbered[parameters]),
             "parameter_0, parameter_1, ... without a gap are expected");
    }
  }

 private:
  const std::map<std::string, Field>& fields_;
  const Origin& where_;
  std::size_t taken_ = 0;
};

}  // namespace

UserTask user_task(const std::map<std::string, Field>& given, const Origin& where) {
  static constexpr std::string_view known[] = {
      "name",        "program",      "kind",     "importance", "importance_waiting", "due_refreshes", "period_ms",
      "deadline_ms", "heartbeat_ms", "argument", "dsp"};
  TaskFields fields(given, where);
  fields.all_known(known);
  UserTask task;
  task.origin = where;
  task.name = fields.text("name", "a name for the report is expected");
  task.program = fields.text("program", "the label of a program is expected");
  task.x = static_cast<std::uint32_t>(fields.integer("kind", std::nullopt, 1, 0xFFFF));
  if (is_taken(task.x))
    refuse(given.at("kind").origin, "tasks.kind", fmt::format("{} is a kind of the paper", task.x),
           free_kinds() + " is expected");
  task.importance = static_cast<std::uint32_t>(fields.integer("importance", std::nullopt, 1, 0xFFFF));
  task.importance_waiting =
      static_cast<std::uint32_t>(fields.integer("importance_waiting", task.importance, 0, 0xFFFF));
  task.due_refreshes = fields.integer("due_refreshes", 0, 0, 0xFFFF);
  task.period_ms = fields.number("period_ms", 0, 0, 1e6);
  if (task.period_ms != 0 && task.period_ms < 0.01)
    refuse(given.at("period_ms").origin, "tasks.period_ms", fmt::format("{} is out of range", task.period_ms),
           "a number from 0.01 to 1e6, or 0, is expected");
  task.period_origin = given.contains("period_ms") ? given.at("period_ms").origin : where;
  task.deadline_ms = fields.number("deadline_ms", 0, 0, 1e6);
  task.heartbeat_ms = fields.number("heartbeat_ms", 0, 0, 1e6);
  task.argument = fields.integer("argument", 0, -2147483648LL, 4294967295LL);
  if (given.contains("dsp")) {
    task.dsp = static_cast<unsigned>(fields.integer("dsp", std::nullopt, 0, machine::most_slots - 1));
    task.dsp_origin = given.at("dsp").origin;
  }
  for (std::size_t i = 0; i < most_parameters; ++i) {
    const Field* field = fields.find(fmt::format("parameter_{}", i));
    if (field == nullptr) break;
    if (!std::holds_alternative<double>(field->value) && !std::holds_alternative<std::int64_t>(field->value)) {
      refuse(field->origin, fmt::format("tasks.parameter_{}", i),
             fmt::format("{} is {}", show(field->value), noun(field->value)), "an integer or a number is expected");
    }
    task.parameters.push_back(field->value);
  }
  fields.nothing_left(task.parameters.size());
  return task;
}

void check_user_tasks(std::span<const UserTask> tasks) {
  if (tasks.size() > most_user_tasks) {
    refuse(tasks[most_user_tasks].origin, "tasks", fmt::format("{} tasks", tasks.size()),
           fmt::format("at most {} are expected", most_user_tasks));
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (tasks[i].name == tasks[j].name)
        refuse(tasks[i].origin, "tasks.name", fmt::format("\"{}\" is given twice", tasks[i].name),
               "each task needs its own name");
      if (tasks[i].x == tasks[j].x)
        refuse(tasks[i].origin, "tasks.kind", fmt::format("{} is given twice", tasks[i].x),
               "each task needs its own kind");
    }
  }
}

bool own_blocks(std::span<const UserTask> tasks) {
  return std::ranges::any_of(tasks, [](const UserTask& task) { return task.dsp.has_value(); });
}

std::string to_toml(const UserTask& task) {
  std::string text = fmt::format(
      "name = {}\nprogram = {}\nkind = {}\nimportance = {:#x}\nimportance_waiting = {:#x}\ndue_refreshes = "
      "{}\nperiod_ms = {}\ndeadline_ms = {}\nheartbeat_ms = {}\nargument = {}\n",
      show(Value{task.name}), show(Value{task.program}), task.x, task.importance, task.importance_waiting,
      task.due_refreshes, show(Value{task.period_ms}), show(Value{task.deadline_ms}), show(Value{task.heartbeat_ms}),
      task.argument);
  if (task.dsp) text += fmt::format("dsp = {}\n", *task.dsp);
  for (std::size_t i = 0; i < task.parameters.size(); ++i)
    text += fmt::format("parameter_{} = {}\n", i, show(task.parameters[i]));
  return text;
}

std::int64_t period_refreshes(const UserTask& task, double refresh_frequency) {
  return std::llround(task.period_ms * 1e-3 * refresh_frequency);
}

void check_period(const UserTask& task, double refresh_frequency) {
  constexpr double as_good_as_whole = 1e-5;  // refreshes: periods like 0.333333 ms are written with few digits
  const double asked = task.period_ms * 1e-3 * refresh_frequency;
  const auto whole = static_cast<double>(period_refreshes(task, refresh_frequency));
  if (task.period_ms == 0 || (whole >= 1 && std::fabs(asked - whole) <= as_good_as_whole)) return;
  const auto ms = [&](double refreshes) { return show(Value{refreshes * 1e3 / refresh_frequency}); };
  const double below = std::floor(asked);
  refuse(task.period_origin, "tasks.period_ms",
         fmt::format("{} ms of \"{}\" are {:g} refreshes: a task is released at a refresh, every {} ms",
                     show(Value{task.period_ms}), task.name, asked, ms(1)),
         below < 1
             ? fmt::format("{} is the shortest period, or more rates.refresh_frequency_hz is expected", ms(1))
             : fmt::format("{} or {} is expected, or another rates.refresh_frequency_hz", ms(below), ms(below + 1)));
}

std::uint32_t importance(const UserTask& task, std::int64_t t) {
  return t >= task.due_refreshes ? task.importance : task.importance_waiting;
}

std::vector<std::string> job_kinds(std::span<const UserTask> tasks) {
  std::vector<std::string> all = job_kinds();
  for (const UserTask& task : tasks) all.push_back("user." + task.name);
  return all;
}

}  // namespace cmrc
