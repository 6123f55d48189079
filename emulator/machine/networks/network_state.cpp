// The list with which a network is saved and loaded, and the properties that must be equal for that.
#include <fmt/format.h>

#include "machine/networks/network_parts.hpp"
#include "state/visitor.hpp"

namespace machine {
namespace {

std::string text_of(const c40::Board& board) {
  std::string out = fmt::format("{} {} {} {:X} {:X} {} {:X};", board.is_flat, board.flat_words_max,
                                board.has_peripherals, board.global_interface_control, board.local_interface_control,
                                board.pins.reset_location, board.pins.iiof);
  for (const c40::Region& r : board.regions)
    out += fmt::format("{:X} {} {} {} {} {} {};", r.base, r.words, r.read_waits, r.write_waits,
                       static_cast<int>(r.kind), static_cast<int>(r.bus), r.page_waits);
  for (const c40::Word word : board.rom) out += fmt::format("{:X} ", word);
  return out;
}

std::string text_of(const toolchain::Image& image) {
  std::string out = fmt::format("{:X};", image.entry);
  for (const auto& section : image.sections) {
    if (!section.loaded) continue;
    out += fmt::format("{:X}:", section.address);
    for (const c40::Word word : section.words) out += fmt::format("{:X} ", word);
  }
  return out;
}

}  // namespace

std::string configuration_of(const c40::Board& board) { return text_of(board); }
std::string configuration_of(const toolchain::Image& image) { return text_of(image); }

state::Key Network::configuration() const {
  state::Key key;
  std::string links, memories;
  key.emplace_back("number of chips", fmt::format("{}", nodes_.size()));
  for (const auto& node : nodes_) {
    const NetworkChip& d = node->description;
    const auto what = [&](std::string_view part) { return fmt::format("{} of chip {}", part, node->number); };
    key.emplace_back(what("program"), fmt::format("{};{};{};{}", text_of(*d.program), d.entry.value_or(0),
                                                  d.until.has_value(), d.until.value_or(0)));
    std::string devices;
    if (node->devices != nullptr)
      for (const auto& [described, device] : node->devices->places()) devices += machine::configuration_of(described);
    key.emplace_back(what("board"), fmt::format("{}{}{}", text_of(d.board.board), d.boot, devices));
    key.emplace_back(what("clock"), fmt::format("{}", node->clock.hertz()));
  }
  for (const NetworkLink& link : description_.links) {
    const c40::LinkParameters& p = link.parameters;
    links += fmt::format("{} {} {} {} {};", machine::to_text(link), p.word_cycles, p.token_cycles, p.enter_cycles,
                         p.exit_cycles);
  }
  for (const auto& memory : memories_) {
    memories +=
        fmt::format("{} {} {}", memory->description.words, memory->description.waits, memory->description.dual_port);
    for (const auto& [chip, base] : memory->description.places) memories += fmt::format(" {} {:X}", chip, base);
    memories += ';';
  }
  key.emplace_back("set of links", links);
  key.emplace_back("set of memories", memories);
  std::string nets;
  for (const auto& net : nets_)
    nets += fmt::format("{} {} {} {};", net->description().name, machine::to_text(net->description()),
                        net->description().open_drain, net->description().rest);
  key.emplace_back("set of nets", nets);
  return key;
}

void Network::Memory::list_state(state::Visitor& list) {
  const std::size_t size = words.size();
  list("words", words);
  if (words.size() != size)
    throw state::StateError(fmt::format("memory {}: {} words instead of {}", description.name, words.size(), size));
  list("free", free);
  list("sides", sides);
  list("owner", owner);
}

void LoopWatch::list_state(state::Visitor& list) { list("rounds", rounds_); }

// Patience is state: its result ends a run, and the time of its checks depends on earlier events.
void Network::Node::list_state(state::Visitor& list) {
  list("chip", chip);
  if (devices != nullptr) list("devices", *devices);
  if (!ignored.empty()) list("ignored", ignored);
  list("status", status);
  list("stop", stop);
  if (list.loads() && waits_for_port()) await(stop.port.port);
  list("was_ready", was_ready);
  list("ready_since", ready_since);
  list("asleep_since", asleep_since);
  list("dma_answered", dma_answered);
  list("patience_since", patience.since);
  list("patience_length", patience.length);
  list("patience_news", patience.news);
  bool looks = patience.looking.has_value();
  list("looks", looks);
  if (list.loads()) {
    patience.looking.reset();
    if (looks) patience.looking.emplace(chip, trace);
    chip.set_trace(looks ? &*patience.looking : trace);
  }
  if (looks) list("looking", *patience.looking);
  list("loop", patience.loop);
  list("found", patience.found);
  list("is_private", patience.is_private);
  list("peripheral_events", peripheral_events);
}

// Not listed: listeners, what is recorded from now on, the order of turns.
void Network::list_state(state::Visitor& list) {
  list("now", now_);
  list("nodes", nodes_);
  list("links", links_);
  list("memories", memories_);
  list("nets", nets_);
  list("actions", actions_);
  list("events", events_);
  list("net_events", net_events_);
  list("news", news_);
  list("happened", happened_);
  list("changed", changed_);
}

}  // namespace machine
