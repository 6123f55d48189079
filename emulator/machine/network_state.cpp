// What of a network lasts, and its file.
#include <fmt/format.h>

#include "c40/chip_file.hpp"
#include "machine/network_parts.hpp"
#include "state/archive.hpp"
#include "state/file.hpp"

namespace machine {

void LoopWatch::list_state(state::Visitor& list) { list("rounds", rounds_); }

void Network::Node::list_state(state::Visitor& list) {
  list("chip", chip);
  list("status", status);
  list("stop", stop);
  list("was ready", was_ready);
  list("ready since", ready_since);
  list("asleep since", asleep_since);
  list("since", patience.since);
  list("length", patience.length);
  list("happenings", patience.happenings);
  bool looking = patience.looking.has_value();
  list("looking", looking);
  if (list.loads()) {
    patience.looking.reset();
    if (looking) patience.looking.emplace(chip, trace);
  }
  if (looking) list("looking at", *patience.looking);
  list("loop", patience.loop);
  list("is private", patience.is_private);
  list("peripheral events", peripheral_events);
  if (list.loads()) chip.set_trace(looking ? static_cast<c40::TraceSink*>(&*patience.looking) : trace);
}

void Network::Memory::list_state(state::Visitor& list) {
  list("words", words);
  list("free", free);
  list("owner", owner);
}

// The order in which chips are advanced changes nothing, and is not listed.
void Network::list_state(state::Visitor& list) {
  list("nodes", nodes_);
  list("links", links_);
  list("memories", memories_);
  list("actions", actions_);
  list("events", events_);
  list("now", now_);
  list("happenings", happenings_);
  list("happened", happened_);
  list("changed", changed_);
}

namespace {

constexpr std::string_view kind = "network";

}  // namespace

// What two networks must have in common for the one to go on as the other.
std::string Network::snapshot_key() const {
  std::string key = fmt::format("shape {} {}\n", description_.shape[0], description_.shape[1]);
  for (const auto& node : nodes_) {
    const NetworkChip& chip = node->description;
    key += fmt::format("chip {}: clock {} boot {} entry {:X} until {:X}\n{}", node->number, chip.clock_mhz.value_or(0), chip.boot, chip.entry.value_or(0),
                       chip.until.value_or(0), c40::key_of(node->chip.board()));
    for (const auto& section : chip.program->sections) key += fmt::format("{} {:X} {}\n", section.name, section.address, fmt::join(section.words, " "));
  }
  for (const NetworkLink& link : description_.links)
    key += fmt::format("link {} {} {} {} {}\n", machine::to_text(link), link.parameters.word_cycles, link.parameters.token_cycles, link.parameters.enter_cycles, link.parameters.exit_cycles);
  for (const SharedMemory& memory : description_.memories) {
    key += fmt::format("memory {} {} {}:", memory.name, memory.words, memory.waits);
    for (const auto& [chip, base] : memory.places) key += fmt::format(" {}@{:X}", chip, base);
    key += '\n';
  }
  return key;
}

std::string Network::sealed() const { return state::sealed(kind, {snapshot_key(), state::save(*this)}); }

void Network::restore(std::string_view file) {
  const std::vector<std::string> parts = state::opened(file, kind, 2);
  if (parts[0] != snapshot_key()) throw state::StateError("the snapshot is of another network: chips, programs, boards, links or memories differ");
  state::load_or_leave(*this, parts[1]);
}

}  // namespace machine
