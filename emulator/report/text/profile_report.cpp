#include "report/text/profile_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

namespace report {
namespace {

using Json = nlohmann::ordered_json;

/// The causes with cycles, so that a table has no empty columns.
std::vector<std::size_t> occurring(const CyclesByCause& causes) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < causes.size(); ++i)
    if (causes[i] != 0) shown.push_back(i);
  return shown;
}

/// A table's columns after the counts: one per cause, as wide as its name.
class Columns {
 public:
  Columns(const Profile& profile, const CyclesByCause& occur) : names_(profile.causes), shown_(occurring(occur)) {}
  std::string headings() const {
    std::string out;
    for (const std::size_t i : shown_) out += fmt::format(" {:>{}}", names_[i], width(i));
    return out;
  }
  std::string of(const CyclesByCause& causes) const {
    std::string out;
    for (const std::size_t i : shown_)
      out += fmt::format(" {:>{}}", causes[i] == 0 ? "-" : fmt::format("{}", causes[i]), width(i));
    return out;
  }
  std::string blank() const {
    std::size_t all = 0;
    for (const std::size_t i : shown_) all += width(i) + 1;
    return std::string(all, ' ');
  }

 private:
  std::size_t width(std::size_t cause) const { return std::max<std::size_t>(names_[cause].size(), 11); }

  const std::vector<std::string>& names_;
  std::vector<std::size_t> shown_;
};

double share(std::int64_t part, std::int64_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

std::int64_t sum(const CyclesByCause& causes) {
  std::int64_t all = 0;
  for (const std::int64_t cycles : causes) all += cycles;
  return all;
}

std::string routine_table(const Profile& profile, const ProfileGroup& group) {
  const Columns columns(profile, group.total.causes);
  std::string out =
      fmt::format("{:>8} {:>12} {:>12} {:>6}{}  routine\n", "calls", "instructions", "cycles", "%", columns.headings());
  const auto row = [&](const std::string& calls, const std::string& instructions, std::int64_t cycles,
                       const CyclesByCause& causes, const std::string& name) {
    fmt::format_to(std::back_inserter(out), "{:>8} {:>12} {:>12} {:>6.2f}{}  {}\n", calls, instructions, cycles,
                   share(cycles, group.total.cycles), columns.of(causes), name);
  };
  for (const ProfileRoutine& routine : group.routines)
    row(fmt::format("{}", routine.calls), fmt::format("{}", routine.own.instructions), routine.own.cycles,
        routine.own.causes, routine.name);
  if (sum(group.outside) != 0) row("", "", sum(group.outside), group.outside, "(interrupt entries, idle, halted)");
  row("", fmt::format("{}", group.total.instructions), group.total.cycles, group.total.causes, "total");
  return out;
}

std::string annotated_source(const Profile& profile, const ProfileGroup& group) {
  const Columns columns(profile, group.total.causes);
  const std::string headings =
      fmt::format("{:>12} {:>12}{}  line address\n", "instructions", "cycles", columns.headings());
  std::string out;
  const ProfileLine* before = nullptr;
  for (const ProfileLine& line : group.lines) {
    if (before == nullptr || before->file != line.file)
      out += (line.file.empty() ? "(no source)" : line.file) + "\n" + headings;
    before = &line;
    const bool executed = line.cost.instructions != 0;
    const std::string counts = executed ? fmt::format("{:>12} {:>12}{}", line.cost.instructions, line.cost.cycles,
                                                      columns.of(line.cost.causes))
                                        : fmt::format("{:>25}{}", "", columns.blank());
    const auto end = line.text.find('\n');
    fmt::format_to(std::back_inserter(out), "{}  {:>4} {:08X} {}\n", counts,
                   line.file.empty() ? "" : fmt::format("{}", line.line), line.address, line.text.substr(0, end));
    if (end != std::string::npos)
      fmt::format_to(std::back_inserter(out), "{:>25}{}  {:>13} {}\n", "", columns.blank(), "",
                     line.text.substr(end + 1));
  }
  return out;
}

std::string overview(const Profile& profile) {
  const Columns columns(profile, profile.total.causes);
  std::size_t widest = 5;
  for (const ProfileGroup& group : profile.groups) widest = std::max(widest, group.name.size());
  std::string out = fmt::format("{:<{}} {:>8} {:>12} {:>12} {:>6}{}\n", "", widest, "jobs", "instructions", "cycles",
                                "%", columns.headings());
  const auto row = [&](const std::string& name, const std::string& jobs, const ProfileCost& cost) {
    fmt::format_to(std::back_inserter(out), "{:<{}} {:>8} {:>12} {:>12} {:>6.2f}{}\n", name, widest, jobs,
                   cost.instructions, cost.cycles, share(cost.cycles, profile.total.cycles), columns.of(cost.causes));
  };
  for (const ProfileGroup& group : profile.groups)
    row(group.name, group.jobs == 0 ? "" : fmt::format("{}", group.jobs), group.total);
  row("total", "", profile.total);
  return out;
}

std::string mean(const ProfileGroup& group) {
  if (group.jobs == 0) return "";
  return fmt::format(", {} jobs, {:.1f} cycles on average", group.jobs,
                     static_cast<double>(group.total.cycles) / static_cast<double>(group.jobs));
}

Json causes_json(const Profile& profile, const CyclesByCause& causes) {
  Json out = Json::object();
  for (std::size_t i = 0; i < profile.causes.size(); ++i) out[profile.causes[i]] = causes[i];
  return out;
}

void put_cost(Json& into, const Profile& profile, const ProfileCost& cost) {
  into["instructions"] = cost.instructions;
  into["cycles"] = cost.cycles;
  into["causes"] = causes_json(profile, cost.causes);
}

Json group_json(const Profile& profile, const ProfileGroup& group) {
  Json root = Json::object();
  if (!group.name.empty()) root = {{"name", group.name}, {"jobs", group.jobs}};
  put_cost(root, profile, group.total);
  root["outside"] = causes_json(profile, group.outside);
  root["routines"] = Json::array();
  for (const ProfileRoutine& routine : group.routines) {
    Json& entry = root["routines"].emplace_back(
        Json{{"name", routine.name}, {"address", routine.address}, {"calls", routine.calls}});
    put_cost(entry, profile, routine.own);
  }
  root["lines"] = Json::array();
  for (const ProfileLine& line : group.lines) {
    if (line.cost.instructions == 0) continue;
    Json& entry = root["lines"].emplace_back(Json{{"address", line.address}});
    if (!line.file.empty()) entry["file"] = line.file, entry["line"] = line.line;
    entry["text"] = line.text;
    put_cost(entry, profile, line.cost);
  }
  return root;
}

std::string dumped(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string to_text(const Profile& profile, const ProfileGroup& group) {
  return "profile: routines, without what they call\n" + routine_table(profile, group) + "profile: source\n" +
         annotated_source(profile, group);
}

std::string to_json(const Profile& profile, const ProfileGroup& group) { return dumped(group_json(profile, group)); }

std::string to_text(const Profile& profile) {
  std::string out = "\nprofile: cycles of all DSPs by what they were spent on\n" + overview(profile);
  for (const ProfileGroup& group : profile.groups) {
    if (group.total.instructions == 0) continue;
    out += fmt::format("\nprofile: {}{}; routines, without what they call\n", group.name, mean(group)) +
           routine_table(profile, group);
    out += fmt::format("\nprofile: {}, source\n", group.name) + annotated_source(profile, group);
  }
  return out;
}

std::string to_json(const Profile& profile) {
  Json root = Json::object();
  put_cost(root, profile, profile.total);
  root["groups"] = Json::array();
  for (const ProfileGroup& group : profile.groups) root["groups"].push_back(group_json(profile, group));
  return dumped(root);
}

}  // namespace report
