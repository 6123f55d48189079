#include "cli/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/program.hpp"
#include "isa/disassemble.hpp"

namespace cli {
namespace {

using c40::Cause;
using c40::Causes;
using c40::Profile;
using toolchain::Address;
using toolchain::Image;

std::string routine_name(const Image& image, Address address) {
  const std::string symbol = symbol_at(image, address);
  return symbol.empty() ? fmt::format("{:08X}h", address) : symbol;
}

/// The causes that occur, so that a table has no empty columns.
std::vector<Cause> occurring(const Causes& causes) {
  std::vector<Cause> out;
  for (std::size_t i = 0; i < c40::cause_count; ++i)
    if (causes[i] != 0) out.push_back(static_cast<Cause>(i));
  return out;
}

std::string columns(const Causes& causes, const std::vector<Cause>& shown) {
  std::string out;
  for (const Cause cause : shown) out += fmt::format(" {:>17}", causes[static_cast<std::size_t>(cause)]);
  return out;
}

std::string headings(const std::vector<Cause>& shown) {
  std::string out;
  for (const Cause cause : shown) out += fmt::format(" {:>17}", name(cause));
  return out;
}

c40::Cycles sum(const Causes& causes) {
  c40::Cycles total = 0;
  for (const c40::Cycles cycles : causes) total += cycles;
  return total;
}

/// The routine with the most cycles first.
std::vector<std::pair<Address, Profile::Routine>> by_cycles(const Profile& profile) {
  const auto routines = profile.routines();
  std::vector<std::pair<Address, Profile::Routine>> out(routines.begin(), routines.end());
  std::erase_if(out, [](const auto& routine) { return routine.second.own.instructions == 0; });
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.second.own.cycles > b.second.own.cycles; });
  return out;
}

struct Line {
  Address address;
  const toolchain::LineRecord* source;  ///< null: the image says nothing about it
  Profile::Entry entry;
};

/// Every source line with a word, and every executed word without one, by address.
std::vector<Line> lines_of(const Profile& profile, const Image& image) {
  std::map<Address, const toolchain::LineRecord*> known;
  for (const auto& line : image.lines)
    if (image.sections.empty() || line.section >= image.sections.size() || image.sections[line.section].loaded) known[line.address] = &line;
  std::map<Address, Line> out;
  for (const auto& [address, source] : known) out[address] = {address, source, {}};
  for (const auto& [address, entry] : profile.instructions()) {
    const auto found = out.find(address);
    if (found == out.end()) out[address] = {address, nullptr, entry};
    else found->second.entry.add(entry);
  }
  std::vector<Line> lines;
  for (auto& [address, line] : out) lines.push_back(line);
  return lines;
}

}  // namespace

void print_profile(const Profile& profile, const c40::Chip& chip, const Image& image) {
  const Causes total = chip.causes(), outside = profile.outside(total);
  const std::vector<Cause> shown = occurring(total);
  const auto all = static_cast<double>(std::max<c40::Cycles>(sum(total), 1));
  fmt::print("profile: routines, without what they call\n");
  fmt::print("{:>8} {:>12} {:>12} {:>6}{}  routine\n", "calls", "instructions", "cycles", "%", headings(shown));
  for (const auto& [address, routine] : by_cycles(profile))
    fmt::print("{:>8} {:>12} {:>12} {:>6.2f}{}  {}\n", routine.calls, routine.own.instructions, routine.own.cycles,
               100.0 * static_cast<double>(routine.own.cycles) / all, columns(routine.own.causes, shown), routine_name(image, address));
  if (sum(outside) != 0)
    fmt::print("{:>8} {:>12} {:>12} {:>6.2f}{}  (interrupt entries, idle)\n", "", "", sum(outside), 100.0 * static_cast<double>(sum(outside)) / all,
               columns(outside, shown));
  fmt::print("{:>8} {:>12} {:>12} {:>6.2f}{}  total\n", "", chip.instructions(), sum(total), 100.0, columns(total, shown));

  fmt::print("profile: source\n");
  const toolchain::LineRecord* before = nullptr;
  for (const Line& line : lines_of(profile, image)) {
    if (line.source != nullptr && (before == nullptr || before->file != line.source->file) && line.source->file < image.files.size())
      fmt::print("{}\n{:>12} {:>12}{}  line address\n", image.files[line.source->file], "instructions", "cycles", headings(shown));
    if (line.source != nullptr) before = line.source;
    const std::string text = line.source != nullptr ? line.source->text : isa::disassemble(chip.peek(line.address), line.address);
    const std::string number = line.source != nullptr ? fmt::format("{}", line.source->line) : "";
    if (line.entry.instructions == 0)
      fmt::print("{:>25}{:{}}  {:>4} {:08X} {}\n", "", "", 18 * shown.size(), number, line.address, text);
    else
      fmt::print("{:>12} {:>12}{}  {:>4} {:08X} {}\n", line.entry.instructions, line.entry.cycles, columns(line.entry.causes, shown), number,
                 line.address, text);
  }
}

nlohmann::ordered_json profile_json(const Profile& profile, const c40::Chip& chip, const Image& image) {
  using Json = nlohmann::ordered_json;
  const auto causes_of = [](const Causes& causes) {
    Json out = Json::object();
    for (std::size_t i = 0; i < c40::cause_count; ++i) out[std::string(name(static_cast<Cause>(i)))] = causes[i];
    return out;
  };
  Json root = {{"outside", causes_of(profile.outside(chip.causes()))}, {"routines", Json::array()}, {"lines", Json::array()}};
  for (const auto& [address, routine] : by_cycles(profile))
    root["routines"].push_back({{"name", routine_name(image, address)}, {"address", address}, {"calls", routine.calls},
                                {"instructions", routine.own.instructions}, {"cycles", routine.own.cycles}, {"causes", causes_of(routine.own.causes)}});
  for (const Line& line : lines_of(profile, image)) {
    if (line.entry.instructions == 0) continue;
    Json entry = {{"address", line.address}, {"instructions", line.entry.instructions}, {"cycles", line.entry.cycles},
                  {"causes", causes_of(line.entry.causes)}};
    if (line.source != nullptr) {
      if (line.source->file < image.files.size()) entry["file"] = image.files[line.source->file];
      entry["line"] = line.source->line;
      entry["text"] = line.source->text;
    }
    root["lines"].push_back(std::move(entry));
  }
  return root;
}

}  // namespace cli
