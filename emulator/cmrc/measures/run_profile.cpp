#include "cmrc/measures/run_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "machine/program_text/profile.hpp"

namespace cmrc {
namespace {

using c40::Cause;
using c40::Causes;
using c40::ProfileCounts;

void accumulate(Causes& to, const Causes& causes, int sign = 1) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += sign * causes[i];
}

/// Removes one cause from `from`.
Causes take(Causes& from, Cause cause) {
  Causes out{};
  std::swap(out[static_cast<std::size_t>(cause)], from[static_cast<std::size_t>(cause)]);
  return out;
}

/// The code between jobs that claims, and the code that waits. An image may lack these labels: then all counts as the
/// executive.
struct Executive {
  explicit Executive(const toolchain::Image& image) {
    const auto find = [&image](std::string_view name) -> c40::Address {
      const auto symbol = image.symbols.find(name);
      return symbol == image.symbols.end() ? 0 : symbol->second;
    };
    claim = find("exec_claim");
    idle = find("exec_idle");
    starts = {image.entry, find("exec_next"), claim, idle};
    starts.erase(0);
  }
  /// The executive, claim, idle: by the routine that contains the address; and the boot ROM.
  std::array<ProfileCounts, 4> split(const ProfileCounts& counts, const std::set<c40::Address>& all_starts) const {
    std::array<ProfileCounts, 4> parts;
    const auto part = [&](c40::Address address) -> ProfileCounts& {
      if (address < c40::rom_words) return parts[3];
      const auto after = all_starts.upper_bound(address);
      const c40::Address start = after == all_starts.begin() ? 0 : *std::prev(after);
      return parts[start == 0 ? 0 : start == claim ? 1 : start == idle ? 2 : 0];
    };
    for (const auto& [address, entry] : counts.instructions()) part(address).add(address, entry);
    for (const auto& [address, times] : counts.calls()) part(address).called(address, times);
    return parts;
  }
  c40::Address claim = 0, idle = 0;
  std::set<c40::Address> starts;
};

void require_equal(const report::TaskReport& task, const Causes& counted) {
  for (std::size_t i = 0; i < counted.size(); ++i)
    if (const report::Share& reported = task.execution_cycles.at(i); reported.amount != counted[i])
      throw std::logic_error(fmt::format("profile: {} cycles of {} were {}, and the report has {}", counted[i],
                                         task.kind, reported.name, reported.amount));
}

}  // namespace

RunProfile::RunProfile(machine::Machine& machine) : machine_(machine) {
  for (unsigned slot = 0; slot < machine.slots(); ++slot) {
    slots_.push_back(std::make_unique<Slot>(Slot{.stream = c40::Profile(executive_), .job = nullptr}));
    machine.chip(slot).set_trace(&slots_.back()->stream);
  }
}

// A run's counts are separate from its kind's, because it may never finish. Their memory is reused.
std::unique_ptr<RunProfile::Span> RunProfile::fresh() {
  if (spare_.empty()) return std::make_unique<Span>();
  auto span = std::move(spare_.back());
  spare_.pop_back();
  return span;
}

void RunProfile::add(Span& to, std::unique_ptr<Span> span) {
  to.counts.add(span->counts);
  accumulate(to.outside, span->outside);
  span->counts.clear();
  span->outside = {};
  span->job.reset();
  spare_.push_back(std::move(span));
}

void RunProfile::book(Kind& kind, std::unique_ptr<Span> span) {
  ++kind.jobs;
  add(kind.sum, std::move(span));
}

std::unique_ptr<RunProfile::Span> RunProfile::end_job(unsigned number) {
  Slot& slot = *slots_.at(number);
  slot.stream.count_into(executive_);
  if (slot.job == nullptr) return nullptr;
  slot.job->outside = outside_of_job(number);
  return std::move(slot.job);
}

c40::Causes RunProfile::outside_of_job(unsigned number) const {
  const Slot& slot = *slots_.at(number);
  Causes outside = machine_.spent(number).causes;
  accumulate(outside, slot.at_start, -1);
  accumulate(outside, slot.job->counts.total().causes, -1);
  return outside;
}

void RunProfile::taken(unsigned number, Time issued) {
  if (auto left = end_job(number)) book(unfinished_, std::move(left));
  Slot& slot = *slots_.at(number);
  slot.job = fresh();
  slot.job->taken = issued;
  slot.at_start = machine_.spent(number).causes;
  slot.stream.count_into(slot.job->counts);
}

void RunProfile::done(unsigned slot, machine::Offset offset, Time issued) {
  if (auto span = end_job(slot)) slots_[slot]->ended.push_back({offset, issued, std::move(span)});
}

void RunProfile::claimed(unsigned number, Time issued, const std::optional<report::JobName>& job) {
  Slot& slot = *slots_.at(number);
  if (slot.job != nullptr && slot.job->taken == issued) slot.job->job = job;
  for (Ended& ended : slot.ended)
    if (ended.span->taken == issued) ended.span->job = job;
}

// A job in parts is one job, of its kind only when it is finished: as in the report.
void RunProfile::landed(unsigned number, machine::Offset offset, Time issued, const Result& result) {
  auto& ended = slots_.at(number)->ended;
  const auto it = std::ranges::find_if(ended, [&](const Ended& e) { return e.offset == offset && e.issued == issued; });
  if (it == ended.end()) return;
  std::unique_ptr<Span> span = std::move(it->span);
  ended.erase(it);
  if (!result.job) return book(unfinished_, std::move(span));
  const auto before = std::ranges::find(continued_, *result.job, &Continued::job);
  if (before != continued_.end()) add(*before->parts, std::move(span));
  if (result.part) {
    if (before == continued_.end()) continued_.push_back({*result.job, std::move(span)});
    return;
  }
  if (before != continued_.end()) {
    span = std::move(before->parts);
    continued_.erase(before);
  }
  if (kinds_.size() <= result.job->kind) kinds_.resize(result.job->kind + 1);
  book(kinds_[result.job->kind], std::move(span));
}

void RunProfile::reset(unsigned number) {
  if (auto left = end_job(number)) book(unfinished_, std::move(left));
  for (Ended& ended : slots_[number]->ended) book(unfinished_, std::move(ended.span));
  slots_[number]->ended.clear();
}

report::Profile RunProfile::report(const std::vector<report::TaskReport>& tasks, const toolchain::Image& image,
                                   const toolchain::Image& rom) const {
  const Executive executive(image);
  std::set<c40::Address> starts = executive.starts;
  const auto learn = [&starts](const ProfileCounts& counts) {
    for (const auto& [address, calls] : counts.calls()) starts.insert(address);
  };
  for (const Kind& kind : kinds_) learn(kind.sum.counts);
  const Kind unfinished = unfinished_now();
  learn(unfinished.sum.counts);
  learn(executive_);

  report::Profile profile = machine::empty_profile();
  Causes rest{};  // cycles outside all instructions that no group has yet
  for (unsigned slot = 0; slot < machine_.slots(); ++slot) accumulate(rest, machine_.spent(slot).causes);
  accumulate(rest, executive_.total().causes, -1);
  const auto add_group = [&](std::string name, std::uint64_t jobs, const ProfileCounts& counts, const Causes& outside) {
    report::ProfileGroup group = machine::profile_group(counts, outside, starts, name == "boot" ? rom : image, false);
    group.name = std::move(name);
    group.jobs = jobs;
    if (group.total.cycles != 0 || jobs != 0) machine::add_group(profile, std::move(group));
  };

  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    const auto& [jobs, sum] = kinds_[i];
    Causes all = sum.counts.total().causes;
    accumulate(all, sum.outside);
    accumulate(rest, all, -1);
    require_equal(tasks.at(i), all);
    add_group(tasks[i].kind, jobs, sum.counts, sum.outside);
  }
  accumulate(rest, unfinished.sum.counts.total().causes, -1);
  Causes standing = take(rest, Cause::halted), idle = take(rest, Cause::idle), of_unfinished = unfinished.sum.outside;
  take(of_unfinished, Cause::halted);
  take(of_unfinished, Cause::idle);
  accumulate(rest, of_unfinished, -1);
  add_group("not finished", unfinished.jobs, unfinished.sum.counts, of_unfinished);
  const auto parts = executive.split(executive_, starts);
  for (const auto& [label, address] : rom.symbols) starts.insert(address);
  add_group("boot", 0, parts[3], {});
  add_group("executive", 0, parts[0], rest);
  add_group("claim", 0, parts[1], {});
  add_group("idle", 0, parts[2], idle);
  add_group("halted", 0, {}, standing);
  return profile;
}

// Includes the finished parts of jobs that continue, the block that each DSP runs, and ends whose write has not landed.
RunProfile::Kind RunProfile::unfinished_now() const {
  Kind all;
  const auto include = [&all](std::uint64_t jobs, const ProfileCounts& counts, const Causes& outside) {
    all.jobs += jobs;
    all.sum.counts.add(counts);
    accumulate(all.sum.outside, outside);
  };
  const auto include_run = [&](const Span& span, const Causes& outside) {
    const bool counted = span.job && std::ranges::find(continued_, *span.job, &Continued::job) != continued_.end();
    include(counted ? 0 : 1, span.counts, outside);
  };
  include(unfinished_.jobs, unfinished_.sum.counts, unfinished_.sum.outside);
  for (const Continued& job : continued_) include(1, job.parts->counts, job.parts->outside);
  for (unsigned number = 0; number < slots_.size(); ++number) {
    const Slot& slot = *slots_[number];
    for (const Ended& ended : slot.ended) include_run(*ended.span, ended.span->outside);
    if (slot.job != nullptr) include_run(*slot.job, outside_of_job(number));
  }
  return all;
}

}  // namespace cmrc
