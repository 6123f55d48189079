#include "cmrc/run/dock_debuggee.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "c40/chip/chip.hpp"
#include "cmrc/configuration/config.hpp"
#include "cmrc/tasks/job_kinds.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/debug/error.hpp"
#include "machine/system/machine.hpp"
#include "plant/parameters/config.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

using machine::Time;
using report::EventKind;

struct KindText {
  EventKind kind;
  const char* what;
  bool of_dsp = false;
};
constexpr std::array kind_texts{
    KindText{EventKind::refresh, "the host refreshes the list"},
    KindText{EventKind::load, "the host loads a task block"},
    KindText{EventKind::claim, "a DSP claims a task block", true},
    KindText{EventKind::finish, "a DSP has finished a task block", true},
    KindText{EventKind::remove, "the host removes a finished block"},
    KindText{EventKind::requeue, "the watchdog takes a block from its DSP and puts it back"},
    KindText{EventKind::miss, "a deadline is missed, a job dropped or lost"},
    KindText{EventKind::semaphore, "a semaphore is acquired, refused or released"},
    KindText{EventKind::bus_transaction, "a transaction on a bus has ended"},
    KindText{EventKind::latch, "the drives take the torque codes"},
    KindText{EventKind::interrupt, "a DSP gets the interrupt of its doorbell", true},
    KindText{EventKind::doorbell, "the host rings a DSP"},
    KindText{EventKind::idle, "a DSP goes idle, or is busy again", true},
    KindText{EventKind::fault, "a DSP cannot continue", true},
    KindText{EventKind::reset, "a DSP is reset, or has booted", true},
    KindText{EventKind::fence, "the host fences DSPs off, or lets them write again"},
    KindText{EventKind::dropped_write, "a write of a fenced DSP is dropped", true},
    KindText{EventKind::process, "a process starts or ends"},
    KindText{EventKind::error, "an error is noticed, decided, done or cleared"},
    KindText{EventKind::starved, "an interpolation buffer runs dry"},
    KindText{EventKind::landed, "a container stands"},
    KindText{EventKind::locked, "the twist locks close"},
    KindText{EventKind::opened, "the twist locks open"},
    KindText{EventKind::delivered, "a container is delivered"},
    KindText{EventKind::scripted, "an event of [[events]] happens"},
    KindText{EventKind::link_lost, "a word on a DSP's link is lost", true},
};

/// Events at every bus clock or every latch are not steps that a user follows: "any" leaves them out.
constexpr bool is_common(EventKind kind) {
  using enum EventKind;
  return kind == bus_transaction || kind == latch || kind == semaphore;
}

/// The place of a kind of task (KIND_*) among the arguments; none: it is no event of a task.
constexpr std::optional<std::size_t> task_argument(EventKind kind) {
  using enum EventKind;
  if (kind == load || kind == claim || kind == finish || kind == remove || kind == requeue) return 1;
  return kind == miss ? std::optional<std::size_t>(0) : std::nullopt;
}

}  // namespace

DockDebuggee::DockDebuggee(Simulation& simulation)
    : simulation_(simulation),
      words_([&](std::string_view name) { return simulation.image().symbol(name); }),
      window_(simulation.image().symbol("WINDOW_A")),
      traces_(simulation.machine().slots(), nullptr) {
  const auto joints = plant::joint_names(simulation.dock().config().crane.machine);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const std::string joint = joints[j].name;
    values_[fmt::format("plant.{}_{}", joint, joints[j].unit)] = [j](const plant::Signal& s) { return s.q[j]; };
    values_[fmt::format("plant.{}_rate_{}_per_s", joint, joints[j].unit)] = [j](const plant::Signal& s) {
      return s.qd[j];
    };
    values_[fmt::format("plant.{}_torque_Nm", joint)] = [j](const plant::Signal& s) { return s.torque[j]; };
    values_[fmt::format("plant.{}_code", joint)] = [j](const plant::Signal& s) { return s.code[j]; };
  }
  values_["plant.sway_alpha_rad"] = [](const plant::Signal& s) { return s.alpha; };
  values_["plant.sway_beta_rad"] = [](const plant::Signal& s) { return s.beta; };
  constexpr std::array axes{"x", "y", "z"};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    values_[fmt::format("plant.tip_{}_m", axes[i])] = [i](const plant::Signal& s) { return s.tip[i]; };
    values_[fmt::format("plant.payload_{}_m", axes[i])] = [i](const plant::Signal& s) { return s.payload[i]; };
  }
  values_["plant.payload_yaw_rad"] = [](const plant::Signal& s) { return s.yaw; };
  values_["plant.tension_N"] = [](const plant::Signal& s) { return s.tension; };
  values_["plant.contact"] = [](const plant::Signal& s) { return s.contact ? 1.0 : 0.0; };
}

DockDebuggee::~DockDebuggee() {
  simulation_.tap(nullptr);
  simulation_.machine().watch_shared({});
}

std::size_t DockDebuggee::chips() const { return simulation_.machine().slots(); }
std::string DockDebuggee::chip_name(std::size_t n) const { return fmt::format("DSP {}", n); }
c40::Chip& DockDebuggee::chip(std::size_t n) { return simulation_.machine().chip(static_cast<unsigned>(n)); }
const toolchain::Image& DockDebuggee::program(std::size_t) const { return simulation_.image(); }
Time DockDebuggee::time_of(std::size_t n, c40::Cycles cycle) const {
  return simulation_.machine().time_of(static_cast<unsigned>(n), cycle);
}

std::string DockDebuggee::describe(std::size_t n) {
  const auto slot = static_cast<unsigned>(n);
  const machine::Machine& machine = simulation_.machine();
  if (!machine.plugged(slot)) return "not plugged in";
  if (machine.standing(slot)) return "stands still";
  if (!machine.booted(slot)) return "boots";
  for (std::size_t i = 0; i < simulation_.image().symbol("BLOCK_COUNT"); ++i) {
    const Word block = words_.block(i);
    if (machine.peek(block + words_.flag) == words_.flag_taken && machine.peek(block + words_.owner) == slot + 1)
      return fmt::format("runs block {} ({})", i, task_name(machine.peek(block + words_.kind)));
  }
  return machine.chip(slot).idle() ? "idle" : "looks for work";
}

void DockDebuggee::set_trace(std::size_t n, c40::TraceSink* sink) {
  c40::Chip& chip = this->chip(n);
  if (sink == nullptr) return chip.set_trace(traces_[n]);
  traces_[n] = chip.trace();
  chip.set_trace(sink);
}

void DockDebuggee::changed_by_hand(std::optional<std::size_t> /*moved*/) { simulation_.machine().look_again(); }

std::optional<std::string> DockDebuggee::holds_pc(std::size_t n) {
  const auto slot = static_cast<unsigned>(n);
  const machine::Machine& machine = simulation_.machine();
  if (!machine.plugged(slot)) return "no board is in the slot";
  if (machine.standing(slot)) return "the DSP stands still, and only a reset ends that";
  if (machine.in_reset(slot)) return "the DSP is held in reset";
  if (machine.in_access(slot)) return "the DSP waits for a bus or a link; its instruction has to end first (stepi)";
  return std::nullopt;
}

Time DockDebuggee::now() const { return simulation_.time(); }

std::optional<std::string> DockDebuggee::over() const {
  if (!simulation_.ended()) return std::nullopt;
  return fmt::format("the run is over, at {:g} s", report::seconds(simulation_.time()));
}

void DockDebuggee::run_until(Time time) { simulation_.run_until(time); }

std::string DockDebuggee::save() { return state::save(simulation_); }
void DockDebuggee::load(std::string_view state) { state::load(simulation_, state); }

std::optional<c40::Address> DockDebuggee::shared_word(std::size_t, c40::Address address) const {
  const Word offset = address - window_;
  return offset < machine::SharedSram::size ? std::optional(offset) : std::nullopt;
}

std::optional<Word> DockDebuggee::peek(std::size_t n, c40::Address address) {
  if (const auto offset = shared_word(n, address)) return simulation_.machine().peek(*offset);
  try {
    return chip(n).peek(address);
  } catch (const std::out_of_range&) {
    return std::nullopt;
  }
}

void DockDebuggee::poke(std::size_t n, c40::Address address, Word value) {
  if (const auto offset = shared_word(n, address))
    simulation_.machine().poke(*offset, value);
  else
    chip(n).poke(address, value);
}

void DockDebuggee::watch_shared(machine::debug::SharedListener* listener, std::vector<c40::AddressRange> words) {
  if (listener == nullptr) return simulation_.machine().watch_shared({});
  simulation_.machine().watch_shared([this, listener, words = std::move(words)](Word offset, Word before, Word value,
                                                                                bool write, unsigned agent, Time done) {
    if (std::ranges::none_of(words, [&](const c40::AddressRange& range) { return range.contains(offset); })) return;
    const bool host = machine::is_host(agent);
    const std::optional<std::size_t> who = host ? std::nullopt : std::optional<std::size_t>(agent - 1);
    listener->shared_access({.time = done,
                             .word = offset,
                             .before = before,
                             .value = value,
                             .write = write,
                             .chip = who,
                             .who = host ? "the host" : chip_name(*who)});
  });
}

// ---- events ----

std::vector<machine::debug::EventKind> DockDebuggee::event_kinds() const {
  std::vector<machine::debug::EventKind> all;
  for (const KindText& row : kind_texts) {
    machine::debug::EventKind& kind = all.emplace_back();
    kind = {.name = report::name(row.kind), .what = row.what, .of_chip = row.of_dsp, .is_common = is_common(row.kind)};
    if (task_argument(row.kind)) kind.fields.push_back({.name = "task", .is_number = false, .words = task_names()});
    const auto names = report::argument_names(row.kind);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].empty()) continue;
      kind.fields.push_back({.name = std::string(names[i])});
      if (report::may_be_none(row.kind, i)) kind.fields.back().words = {"none"};
    }
  }
  return all;
}

void DockDebuggee::listen(machine::debug::DebugEventListener* listener, const std::set<std::string>& kinds) {
  listener_ = listener;
  kinds_.clear();
  for (const KindText& row : kind_texts)
    if (kinds.contains(report::name(row.kind)) || (kinds.contains("any") && !is_common(row.kind)))
      kinds_.insert(row.kind);
  simulation_.tap(listener == nullptr ? nullptr : this);
}

std::vector<std::string> DockDebuggee::task_names() const {
  std::vector<std::string> all;
  for (const KindRow& row : kind_rows)
    if (!row.symbol.empty()) all.emplace_back(row.name);
  for (const auto& task : simulation_.config().tasks) all.push_back(task.name);
  return all;
}

std::string DockDebuggee::task_name(Word kind) const {
  if (kind - words_.kind_user < simulation_.config().tasks.size())
    return simulation_.config().tasks[kind - words_.kind_user].name;
  return std::string(kind_rows[static_cast<std::size_t>(job_kind(kind, words_))].name);
}

void DockDebuggee::event(const report::Event& event) {
  if (!kinds_.contains(event.kind)) return;
  machine::debug::DebugEvent told{.time = event.time, .kind = report::name(event.kind), .text = report::to_text(event)};
  const auto names = report::argument_names(event.kind);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!names[i].empty())
      told.fields.emplace(names[i], report::may_be_none(event.kind, i) && event.arguments[i] == report::no_place
                                        ? "none"
                                        : fmt::format("{}", event.arguments[i]));
  if (event.component >= report::first_dsp && event.component < report::plant)
    told.chip = event.component - report::first_dsp;
  if (const auto place = task_argument(event.kind)) {
    told.fields["task"] = task_name(event.arguments[*place]);
    told.text += fmt::format(" task={}", told.fields["task"]);
  }
  listener_->happened(told);
}

// ---- values and pages ----

std::vector<std::string> DockDebuggee::value_names() {
  std::vector<std::string> names;
  for (const auto& [name, value] : values_) names.push_back(name);
  return names;
}

std::optional<double> DockDebuggee::value(std::string_view name) {
  const auto found = values_.find(name);
  if (found == values_.end()) return std::nullopt;
  return found->second(simulation_.dock().signal());
}

std::vector<std::string> DockDebuggee::page_names() const { return {"list", "dsps", "plant"}; }

/// The blocks in shared memory: first those that the work pointer and the links reach, then the claimed ones.
std::string DockDebuggee::list_page() const {
  const machine::Machine& machine = simulation_.machine();
  const auto row = [&](Word block) {
    const auto at = [&](Word word) { return machine.peek(block + word); };
    const Word flag = at(words_.flag);
    const std::string state = flag == words_.flag_waiting ? "waiting"
                              : flag == words_.flag_done  ? "done"
                                                          : fmt::format("DSP {}", at(words_.owner) - 1);
    return fmt::format("{:>5} {:<24} {:<8} {:>6} {:>4} {:>8} {:>10}\n",
                       (block - words_.block_pool) / words_.block_words, task_name(at(words_.kind)), state,
                       at(words_.importance), at(words_.t), at(words_.tick), at(words_.argument));
  };
  std::string text =
      fmt::format("refresh {}\n{:>5} {:<24} {:<8} {:>6} {:>4} {:>8} {:>10}\n", machine.peek(words_.list_refresh),
                  "block", "task", "state", "J", "t", "tick", "argument");
  const Word first = machine.peek(words_.list_work_pointer), count = simulation_.image().symbol("BLOCK_COUNT");
  std::set<Word> shown;
  for (Word block = first; block - words_.block_pool < count * words_.block_words && shown.insert(block).second;
       block = machine.peek(block + words_.link))
    text += row(block);
  if (shown.empty()) text += "      no block waits\n";
  for (Word i = 0; i < count; ++i)
    if (const Word block = words_.block(i);
        !shown.contains(block) && machine.peek(block + words_.flag) == words_.flag_taken)
      text += row(block);
  return text;
}

std::string DockDebuggee::page(std::string_view name) {
  std::string text;
  if (name == "list") return list_page();
  if (name == "dsps") {
    for (std::size_t n = 0; n < chips(); ++n)
      text += fmt::format("DSP {}: {}, at {:08X}h, cycle {}\n", n, describe(n), chip(n).pc(), chip(n).cycle());
  } else if (name == "plant") {
    const plant::Signal signal = simulation_.dock().signal();
    for (const auto& [value, of] : values_) text += fmt::format("{:<28} {:.6g}\n", value, of(signal));
  } else {
    throw machine::debug::DebugError(fmt::format("{}: list, dsps or plant is expected", name));
  }
  return text;
}

}  // namespace cmrc
