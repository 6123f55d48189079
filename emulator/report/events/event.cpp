#include "report/events/event.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>

#include "state/enumerators.hpp"

namespace report {
namespace {

/// The format of an argument: d decimal, h hexadecimal with a leading 0x, s signed decimal, n decimal or "none".
struct Argument {
  std::string_view name;
  char format = 'd';
};

struct KindRow {
  EventKind kind;
  std::string_view name;
  std::array<Argument, 5> arguments;
};

constexpr KindRow kind_rows[] = {
    {EventKind::refresh, "refresh", {{{"number"}, {"blocks"}, {"waiting"}, {"pointer", 'h'}, {"skipped"}}}},
    {EventKind::load, "load", {{{"block", 'h'}, {"kind"}, {"area", 'h'}, {"tick"}, {"generation"}}}},
    {EventKind::claim, "claim", {{{"block", 'h'}, {"kind"}, {"area", 'h'}, {"tick"}, {"generation"}}}},
    {EventKind::start, "start", {{{"block", 'h'}, {"kind"}}}},
    {EventKind::finish, "finish", {{{"block", 'h'}, {"kind"}, {"result", 'h'}, {"notify", 'h'}, {"generation"}}}},
    {EventKind::remove, "remove", {{{"block", 'h'}, {"kind"}, {"generation"}}}},
    {EventKind::requeue, "requeue", {{{"block", 'h'}, {"kind"}, {"generation"}, {"owner"}, {"recomputations"}}}},
    {EventKind::bus_transaction, "bus_transaction", {{{"master"}, {"address", 'h'}, {"words"}, {"flags"}, {"waited"}}}},
    {EventKind::semaphore, "semaphore", {{{"number"}, {"state"}, {"owner"}}}},
    {EventKind::latch, "latch", {{{"s", 's'}, {"psi", 's'}, {"phi", 's'}, {"l", 's'}, {"kappa", 's'}}}},
    {EventKind::interrupt, "interrupt", {{{"pin"}}}},
    {EventKind::doorbell, "doorbell", {{{"slot"}}}},
    {EventKind::idle, "idle", {{{"state"}}}},
    {EventKind::fault, "fault", {{{"kind"}, {"pc", 'h'}, {"word", 'h'}}}},
    {EventKind::reset, "reset", {{{"state"}}}},
    {EventKind::fence, "fence", {{{"mask", 'h'}}}},
    {EventKind::dropped_write, "dropped_write", {{{"bus"}, {"address", 'h'}, {"value", 'h'}}}},
    {EventKind::process, "process", {{{"number"}, {"state"}, {"robot"}}}},
    {EventKind::miss, "miss", {{{"kind"}, {"tick"}, {"class"}, {"block", 'h'}}}},
    {EventKind::landed, "landed", {{{"container", 'n'}, {"place", 'n'}}}},
    {EventKind::locked, "locked", {{{"container", 'n'}}}},
    {EventKind::opened, "opened", {{{"container", 'n'}}}},
    {EventKind::delivered, "delivered", {{{"container", 'n'}}}},
    {EventKind::starved, "starved", {{{"robot"}, {"point"}}}},
    {EventKind::link_lost, "link_lost", {{{"word"}, {"to_dsp"}, {"bytes"}}}},
    {EventKind::scripted, "scripted", {{{"action"}, {"number"}, {"amount_low"}, {"amount_high"}}}},
    {EventKind::set, "set", {{{"key"}, {"value_low", 'h'}, {"value_high", 'h'}}}},
    {EventKind::error, "error", {{{"number"}, {"what", 'h'}, {"robot"}, {"phase"}, {"response"}}}},
    {EventKind::control, "control", {{{"generation"}, {"changed", 'h'}}}},
    {EventKind::issue, "issue", {{{"block", 'h'}, {"flag", 'h'}, {"delay_low"}, {"delay_high"}}}},
    {EventKind::push, "push", {{{"agv"}, {"speed", 's'}, {"front", 's'}, {"rear", 's'}}}},
};

constexpr const KindRow* find(EventKind kind) {
  const auto* row = std::ranges::find(kind_rows, kind, &KindRow::kind);
  return row == std::end(kind_rows) ? nullptr : row;
}
static_assert(state::all_enumerators<EventKind>([](EventKind kind, auto) { return find(kind) != nullptr; }),
              "each kind of event has one row");

constexpr Argument unnamed[] = {{"a0", 'h'}, {"a1", 'h'}, {"a2", 'h'}, {"a3", 'h'}, {"a4", 'h'}};

std::span<const Argument> arguments_of(EventKind kind) {
  const KindRow* row = find(kind);
  return row ? std::span<const Argument>(row->arguments) : unnamed;
}

}  // namespace

std::string name(Component component) {
  switch (component) {
    case host: return "host";
    case bus_a: return "bus A";
    case bus_b: return "bus B";
    case bus_c: return "bus C";
    case bus_d: return "bus D";
    case plant: return "plant";
    default: break;
  }
  if (component >= first_dsp) return fmt::format("dsp {}", component - first_dsp);
  return fmt::format("component {}", component);
}

std::string name(EventKind kind) {
  const KindRow* row = find(kind);
  return row ? std::string(row->name) : fmt::format("event {}", static_cast<unsigned>(kind));
}

std::array<std::string_view, 5> argument_names(EventKind kind) {
  std::array<std::string_view, 5> names;
  std::ranges::transform(arguments_of(kind), names.begin(), &Argument::name);
  return names;
}

bool may_be_none(EventKind kind, std::size_t argument) { return arguments_of(kind)[argument].format == 'n'; }

std::string to_text(const Event& event) {
  constexpr std::int64_t second = 1'000'000'000'000;
  std::string line = fmt::format("{}.{:012} [{}] {}", event.time.count() / second, event.time.count() % second,
                                 name(event.component), name(event.kind));
  std::size_t i = 0;
  for (const Argument& argument : arguments_of(event.kind)) {
    const std::uint32_t value = event.arguments[i++];
    if (argument.name.empty()) break;
    auto out = std::back_inserter(line);
    switch (argument.format) {
      case 'h': fmt::format_to(out, " {}={:#x}", argument.name, value); break;
      case 's': fmt::format_to(out, " {}={}", argument.name, static_cast<std::int32_t>(value)); break;
      case 'n': fmt::format_to(out, " {}={}", argument.name, value == no_place ? "none" : std::to_string(value)); break;
      default: fmt::format_to(out, " {}={}", argument.name, value);
    }
  }
  return line;
}

}  // namespace report
