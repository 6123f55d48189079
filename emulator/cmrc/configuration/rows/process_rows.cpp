#include "cmrc/configuration/rows/process_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "isa/ascii.hpp"
#include "state/enumerators.hpp"

namespace cmrc {
namespace {

struct StepName {
  std::string_view word;
  Step::Kind kind;
  std::string_view argument;  // the argument after the word
};
constexpr std::array<StepName, 11> step_names = {{{"task", Step::Kind::task, "a task's name"},
                                                  {"leg", Step::Kind::leg, "1, 2 or 3"},
                                                  {"settle", Step::Kind::settle, ""},
                                                  {"lower", Step::Kind::lower, ""},
                                                  {"lock", Step::Kind::lock, ""},
                                                  {"open", Step::Kind::open, ""},
                                                  {"raise", Step::Kind::raise, ""},
                                                  {"align", Step::Kind::align, ""},
                                                  {"queue", Step::Kind::queue, ""},
                                                  {"hand_over", Step::Kind::hand_over, ""},
                                                  {"hold", Step::Kind::hold, "seconds"}}};

constexpr std::array<std::string_view, 3> robot_names = {"none", "crane", "agv"};
constexpr std::array<std::string_view, 5> account_names = {"none", "t_3", "t_4", "t_5", "t_6"};
constexpr std::array<std::string_view, 5> release_names = {"point", "tick", "interval", "event", "interval_and_event"};
// In the order of Robots, Account and Subprocess::Release.
static_assert(robot_names.size() == state::enumerator_count<Robots>() &&
              account_names.size() == state::enumerator_count<Account>() &&
              release_names.size() == state::enumerator_count<Subprocess::Release>());
static_assert(step_names.size() == state::enumerator_count<Step::Kind>());

template <std::size_t n>
std::string list_of(const std::array<std::string_view, n>& names) {
  return quoted_list({names.begin(), names.end()});
}

/// The fields of one row, by name.
class Row {
 public:
  Row(const toml::table& table, std::string kind, std::string file)
      : table_(table), kind_(std::move(kind)), file_(std::move(file)) {}

  Origin where() const { return place(table_); }
  /// To be called before a field is reported as missing: a misspelt field is then reported as it is written.
  void all_known(std::span<const std::string_view> known) const {
    for (const auto& [field, node] : table_)
      if (std::find(known.begin(), known.end(), field.str()) == known.end())
        refuse(place(node), key(field.str()), "no such field", one_expected(field.str(), {known.begin(), known.end()}));
  }
  std::string text(std::string_view field, std::optional<std::string> otherwise, std::string_view right) {
    const toml::node* node = take(field);
    if (node == nullptr && otherwise) return *otherwise;
    if (node == nullptr) refuse(where(), key(field), "is missing", right);
    if (!node->is_string()) refuse(place(*node), key(field), "is not a string", right);
    return node->as_string()->get();
  }
  template <std::size_t n>
  std::size_t choice(std::string_view field, const std::array<std::string_view, n>& names,
                     std::optional<std::string> otherwise) {
    const std::string right = list_of(names) + " is expected";
    const std::string word = text(field, std::move(otherwise), right);
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end())
      refuse(place(*table_.get(field)), key(field), fmt::format("\"{}\" is not known", word),
             one_expected(word, {names.begin(), names.end()}));
    return static_cast<std::size_t>(found - names.begin());
  }
  bool flag(std::string_view field) {
    const toml::node* node = take(field);
    if (node != nullptr && !node->is_boolean())
      refuse(place(*node), key(field), "is not a boolean", "true or false is expected");
    return node != nullptr && node->as_boolean()->get();
  }
  unsigned number(std::string_view field) {
    const toml::node* node = take(field);
    if (node == nullptr) refuse(where(), key(field), "is missing", right_number());
    return number_in(*node, field);
  }
  std::vector<unsigned> numbers(std::string_view field) {
    std::vector<unsigned> all;
    for_each(field, "a list of numbers is expected",
             [&](const toml::node& node) { all.push_back(number_in(node, field)); });
    return all;
  }
  std::vector<Consent> consents(std::string_view field) {
    constexpr std::string_view right = "a list of texts like \"4->7\" is expected";
    std::vector<Consent> all;
    for_each(field, right, [&](const toml::node& node) {
      const std::string text = node.value_or(std::string());
      const std::size_t arrow = text.find("->");
      const auto source = ascii::number<unsigned>(std::string_view(text).substr(0, arrow));
      const auto target =
          arrow == std::string::npos ? std::nullopt : ascii::number<unsigned>(std::string_view(text).substr(arrow + 2));
      if (!source || !target) refuse(place(node), key(field), fmt::format("\"{}\" names no consent", text), right);
      all.push_back({*source, *target});
    });
    return all;
  }
  std::vector<Step> steps(std::string_view field) {
    std::vector<Step> all;
    for_each(field, "a list of steps is expected",
             [&](const toml::node& node) { all.push_back(step_of(node, key(field))); });
    return all;
  }

 private:
  Origin place(const toml::node& node) const {
    const auto& begin = node.source().begin;
    return {file_, static_cast<std::int64_t>(begin.line), static_cast<std::int64_t>(begin.column)};
  }
  std::string key(std::string_view field) const { return fmt::format("{}.{}", kind_, field); }
  const toml::node* take(std::string_view field) const { return table_.get(field); }
  static std::string right_number() { return fmt::format("an integer from 1 to {} is expected", most_processes); }
  unsigned number_in(const toml::node& node, std::string_view field) const {
    const auto value = node.is_integer() ? node.as_integer()->get() : 0;
    if (value < 1 || value > std::int64_t{most_processes})
      refuse(place(node), key(field), "is not a number of a row", right_number());
    return static_cast<unsigned>(value);
  }
  template <typename Use>
  void for_each(std::string_view field, std::string_view right, Use use) {
    const toml::node* node = take(field);
    if (node == nullptr) return;
    if (!node->is_array()) refuse(place(*node), key(field), "is not a list", right);
    for (const toml::node& element : *node->as_array()) use(element);
  }
  Step step_of(const toml::node& node, const std::string& key) const {
    const std::string text = node.value_or(std::string());
    const std::size_t space = text.find(' ');
    const std::string_view word = std::string_view(text).substr(0, space);
    const std::string_view argument =
        space == std::string::npos ? std::string_view() : std::string_view(text).substr(space + 1);
    const auto known =
        std::find_if(step_names.begin(), step_names.end(), [&](const StepName& name) { return name.word == word; });
    if (known == step_names.end()) {
      std::vector<std::string> words;
      for (const StepName& name : step_names) words.emplace_back(name.word);
      refuse(place(node), key, fmt::format("\"{}\" is not a step", text), one_expected(word, words));
    }
    Step step{.kind = known->kind, .task = std::string(argument)};
    bool fits = argument.empty() == known->argument.empty();
    if (step.kind == Step::Kind::leg) {
      step.leg = ascii::number<unsigned>(argument).value_or(0);
      fits = step.leg >= 1 && step.leg <= 3;
    } else if (step.kind == Step::Kind::hold) {
      step.seconds = ascii::number<double>(argument).value_or(-1);
      fits = step.seconds >= 0 && step.seconds <= 86400;
    }
    if (step.kind != Step::Kind::task) step.task.clear();
    if (!fits) {
      refuse(place(node), key, fmt::format("\"{}\" has the wrong argument for \"{}\"", text, word),
             known->argument.empty() ? "nothing is expected after it"
                                     : fmt::format("{} is expected after it", known->argument));
    }
    return step;
  }

  const toml::table& table_;
  std::string kind_, file_;
};

template <typename Use>
void for_each_row(const toml::node& node, const std::string& kind, const std::string& file, ConfigErrors& errors,
                  Use use) {
  const toml::array* rows = node.as_array();
  if (rows == nullptr || (!rows->empty() && !rows->is_homogeneous<toml::table>())) {
    const auto& begin = node.source().begin;
    refuse({file, static_cast<std::int64_t>(begin.line), static_cast<std::int64_t>(begin.column)}, kind,
           "is not a list of tables", fmt::format("[[{}]] begins each of them", kind));
  }
  std::vector<unsigned> seen;
  for (const toml::node& row : *rows) {
    Row fields(*row.as_table(), kind, file);
    errors.attempt(fields.where(), [&] {
      const auto read = use(fields);
      if (std::find(seen.begin(), seen.end(), read) != seen.end())
        refuse(fields.where(), kind + ".number", fmt::format("{} is given twice", read),
               "each row needs its own number");
      seen.push_back(read);
    });
  }
}

template <typename Row>
void lay(std::vector<Row>& rows, Row row) {
  const auto at = std::lower_bound(rows.begin(), rows.end(), row.number,
                                   [](const Row& a, unsigned number) { return a.number < number; });
  if (at != rows.end() && at->number == row.number)
    *at = std::move(row);
  else
    rows.insert(at, std::move(row));
}

std::string numbers_text(std::string_view field, const std::vector<unsigned>& numbers) {
  return numbers.empty() ? std::string() : fmt::format("{} = [{}]\n", field, fmt::join(numbers, ", "));
}

}  // namespace

void read_processes(const toml::node& rows, const std::string& name, ProcessTable& table, ConfigErrors& errors) {
  for_each_row(rows, "processes", name, errors, [&](auto& fields) {
    static constexpr std::array<std::string_view, 2> notifiers = {"host", "task"};
    static constexpr std::string_view known[] = {"number", "name",     "robot",  "account", "subprocesses",
                                                 "steps",  "notify",   "must",   "may",     "initial",
                                                 "clears", "replaces", "loaded", "final"};
    fields.all_known(known);
    Process process;
    process.number = fields.number("number");
    process.name = fields.text("name", std::nullopt, "a name for the report is expected");
    process.robot = static_cast<Robots>(fields.choice("robot", robot_names, std::nullopt));
    process.account = static_cast<Account>(fields.choice("account", account_names, "none"));
    process.subprocesses = fields.numbers("subprocesses");
    process.steps = fields.steps("steps");
    process.notified_by_task = fields.choice("notify", notifiers, "host") == 1;
    process.must = fields.numbers("must");
    process.may = fields.numbers("may");
    process.initial = fields.numbers("initial");
    process.clears = fields.consents("clears");
    process.replaces = fields.numbers("replaces");
    process.loaded = fields.flag("loaded");
    process.final = fields.flag("final");
    process.origin = fields.where();
    const unsigned number = process.number;
    lay(table.processes, std::move(process));
    return number;
  });
}

void read_subprocesses(const toml::node& rows, const std::string& name, ProcessTable& table, ConfigErrors& errors) {
  for_each_row(rows, "subprocesses", name, errors, [&](auto& fields) {
    static constexpr std::string_view known[] = {
        "number", "name", "crane", "agv", "release", "must", "between_processes", "on_legs"};
    fields.all_known(known);
    Subprocess row;
    row.number = fields.number("number");
    row.name = fields.text("name", std::nullopt, "a name is expected");
    row.crane = fields.text("crane", "", "the name of a task is expected");
    row.agv = fields.text("agv", "", "the name of a task is expected");
    row.release = static_cast<Subprocess::Release>(fields.choice("release", release_names, std::nullopt));
    row.must = fields.numbers("must");
    row.between_processes = fields.flag("between_processes");
    row.on_legs = fields.flag("on_legs");
    row.origin = fields.where();
    const unsigned number = row.number;
    lay(table.subprocesses, std::move(row));
    return number;
  });
}

std::string to_text(const Step& step) {
  const auto known =
      std::find_if(step_names.begin(), step_names.end(), [&](const StepName& name) { return name.kind == step.kind; });
  switch (step.kind) {
    case Step::Kind::task: return fmt::format("{} {}", known->word, step.task);
    case Step::Kind::leg: return fmt::format("{} {}", known->word, step.leg);
    case Step::Kind::hold: return fmt::format("{} {}", known->word, step.seconds);
    default: return std::string(known->word);
  }
}

std::string to_toml(const ProcessTable& table) {
  std::string text;
  const auto named = [&](std::string_view kind, unsigned number, const std::string& name) {
    text += fmt::format("\n[[{}]]\nnumber = {}\nname = {}\n", kind, number, show(Value{name}));
  };
  const auto flag = [&](std::string_view field, bool set) { text += set ? fmt::format("{} = true\n", field) : ""; };
  for (const Subprocess& row : table.subprocesses) {
    named("subprocesses", row.number, row.name);
    if (!row.crane.empty()) text += fmt::format("crane = {}\n", show(Value{row.crane}));
    if (!row.agv.empty()) text += fmt::format("agv = {}\n", show(Value{row.agv}));
    text += fmt::format("release = \"{}\"\n", release_names.at(static_cast<std::size_t>(row.release)));
    text += numbers_text("must", row.must);
    flag("between_processes", row.between_processes);
    flag("on_legs", row.on_legs);
  }
  for (const Process& row : table.processes) {
    named("processes", row.number, row.name);
    std::vector<std::string> steps, clears;
    for (const Step& step : row.steps) steps.push_back(show(Value{to_text(step)}));
    for (const Consent& consent : row.clears)
      clears.push_back(fmt::format("\"{}->{}\"", consent.source, consent.target));
    text += fmt::format("robot = \"{}\"\n", robot_names.at(static_cast<std::size_t>(row.robot)));
    if (row.account != Account::none)
      text += fmt::format("account = \"{}\"\n", account_names.at(static_cast<std::size_t>(row.account)));
    text += numbers_text("subprocesses", row.subprocesses);
    text += fmt::format("steps = [{}]\n", fmt::join(steps, ", "));
    if (row.notified_by_task) text += "notify = \"task\"\n";
    text += numbers_text("must", row.must) + numbers_text("may", row.may) + numbers_text("initial", row.initial);
    if (!clears.empty()) text += fmt::format("clears = [{}]\n", fmt::join(clears, ", "));
    text += numbers_text("replaces", row.replaces);
    flag("loaded", row.loaded);
    flag("final", row.final);
  }
  return text;
}

}  // namespace cmrc
