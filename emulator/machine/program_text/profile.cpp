#include "machine/program_text/profile.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "isa/disassemble.hpp"

namespace machine {
namespace {

using c40::Address;

report::ProfileCost cost_of(const c40::ProfileCounts::Entry& entry) {
  return {entry.instructions, entry.cycles, by_cause(entry.causes)};
}

void add(report::ProfileCost& to, const report::ProfileCost& cost) {
  to.instructions += cost.instructions;
  to.cycles += cost.cycles;
  for (std::size_t i = 0; i < to.causes.size(); ++i) to.causes[i] += cost.causes[i];
}

/// If several symbols have one value, the first in the alphabet.
std::map<Address, std::string> labels(const toolchain::Image& image) {
  std::map<Address, std::string> all;
  for (const auto& [name, value] : image.names()) all.try_emplace(value, name);
  return all;
}

std::vector<report::ProfileRoutine> routines_of(const c40::ProfileCounts& counts, const std::set<Address>& starts,
                                                const toolchain::Image& image) {
  const auto names = labels(image);
  std::vector<report::ProfileRoutine> all;
  for (const auto& [address, routine] : c40::routines(counts, starts)) {
    const auto name = names.find(address);
    all.push_back({name == names.end() ? fmt::format("{:08X}h", address) : name->second, address, routine.calls,
                   cost_of(routine.own)});
  }
  std::ranges::stable_sort(all, [](const auto& a, const auto& b) { return a.own.cycles > b.own.cycles; });
  return all;
}

/// Data: the line has a directive, with or without a label.
bool is_directive(std::string_view text) {
  const auto skip = [&text](std::string_view characters, bool these) {
    const std::size_t n = these ? text.find_first_not_of(characters) : text.find_first_of(characters);
    text.remove_prefix(std::min(n, text.size()));
  };
  constexpr std::string_view blanks = " \t";
  if (!text.empty() && blanks.find(text.front()) == std::string_view::npos) skip(blanks, false);
  skip(blanks, true);
  return text.starts_with('.');
}

std::vector<report::ProfileLine> lines_of(const c40::ProfileCounts& counts, const toolchain::Image& image,
                                          bool all_lines) {
  std::map<Address, report::ProfileLine> lines;
  const auto executed = counts.instructions();
  for (const toolchain::LineRecord& line : image.lines) {
    if (line.section < image.sections.size() && !image.sections[line.section].loaded) continue;
    if (!executed.contains(line.address) && (!all_lines || is_directive(line.text))) continue;
    const std::string file = line.file < image.files.size() ? image.files[line.file] : "";
    const std::string text = line.second.empty() ? line.text : line.text + "\n" + line.second;
    lines[line.address] = {line.address, file, line.line, text, cost_of({})};
  }
  for (const auto& [address, entry] : executed) {
    const auto [line, is_new] = lines.try_emplace(address);
    if (is_new) line->second = {address, "", 0, isa::disassemble(entry.word, address), {}};
    line->second.cost = cost_of(entry);
  }
  std::vector<report::ProfileLine> out;
  for (auto& [address, line] : lines) out.push_back(std::move(line));
  return out;
}

}  // namespace

report::CyclesByCause by_cause(const c40::Causes& causes) { return {causes.begin(), causes.end()}; }

report::Profile empty_profile() {
  report::Profile profile;
  for (std::size_t i = 0; i < c40::cause_count; ++i) profile.causes.emplace_back(c40::name(static_cast<c40::Cause>(i)));
  profile.total = cost_of({});
  return profile;
}

report::ProfileGroup profile_group(const c40::ProfileCounts& counts, const c40::Causes& outside,
                                   const std::set<Address>& starts, const toolchain::Image& image, bool all_lines) {
  report::ProfileGroup group;
  group.total = cost_of(counts.total());
  group.outside = by_cause(outside);
  for (std::size_t i = 0; i < outside.size(); ++i)
    group.total.cycles += outside[i], group.total.causes[i] += outside[i];
  group.routines = routines_of(counts, starts, image);
  group.lines = lines_of(counts, image, all_lines);
  return group;
}

void add_group(report::Profile& profile, report::ProfileGroup group) {
  add(profile.total, group.total);
  profile.groups.push_back(std::move(group));
}

}  // namespace machine
