// emulator exec with several programs: a network of chips.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/arguments/network_arguments.hpp"
#include "cli/arguments/options.hpp"
#include "cli/arguments/program.hpp"
#include "cli/exec/board_front.hpp"
#include "cli/exec/chip_listeners.hpp"
#include "cli/exec/exec_memory.hpp"
#include "cli/output_files/network_timeline.hpp"
#include "cli/output_files/timeline_file.hpp"
#include "io/output_file.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "machine/networks/network.hpp"
#include "state/archive.hpp"

namespace cli {
namespace {

using Json = nlohmann::ordered_json;
using machine::ChipStatus;
using machine::Network;

struct NetworkDump {
  std::size_t chip = 0;
  c40::Address address = 0, count = 0;
};

/// The file for one chip, for example FILE.chip2.
std::optional<std::string> trace_file(const ExecOptions& options, std::size_t chip) {
  return options.trace ? std::optional(fmt::format("{}.chip{}", *options.trace, chip)) : std::nullopt;
}

/// The listeners of each chip.
class Watched {
 public:
  Watched(Network& network, const ExecOptions& options) {
    for (std::size_t n = 0; n < network.chip_count(); ++n) {
      const auto& added = all_.emplace_back(std::make_unique<ChipListeners>(
          network.chip(n), network.program(n), options, static_cast<unsigned>(n), trace_file(options, n)));
      network.set_trace(n, added->sink());
    }
  }
  void run_ended() {
    for (auto& one : all_) one->run_ended();
  }
  const ChipListeners& operator[](std::size_t n) const { return *all_[n]; }

 private:
  std::vector<std::unique_ptr<ChipListeners>> all_;
};

/// CHIP:ADDRESS:COUNT
NetworkDump parse_dump(const std::string& text, const Network& network) {
  const std::size_t first = text.find(':'), last = text.rfind(':');
  if (first == last)
    throw InputError(fmt::format("--dump: \"{}\" is not CHIP:ADDRESS:COUNT, which a network needs", text));
  NetworkDump dump;
  dump.chip = parse_address(std::string_view(text).substr(0, first), nullptr, "--dump, CHIP");
  if (dump.chip >= network.chip_count())
    throw InputError(
        fmt::format("--dump: there is no chip {}; 0 to {} are possible", dump.chip, network.chip_count() - 1));
  dump.address =
      parse_address(std::string_view(text).substr(first + 1, last - first - 1), &network.program(dump.chip), "--dump");
  dump.count = parse_address(std::string_view(text).substr(last + 1), nullptr, "--dump, COUNT");
  if (dump.count == 0 || dump.count > 1'000'000)
    throw InputError(fmt::format("--dump: {} words; 1 to 1000000 are possible", dump.count));
  return dump;
}

std::vector<c40::Word> words_of(const Network& network, const NetworkDump& dump) {
  std::vector<c40::Word> words;
  for (c40::Address i = 0; i < dump.count; ++i) {
    try {
      words.push_back(network.chip(dump.chip).peek(dump.address + i));
    } catch (const std::out_of_range&) {
      throw InputError(fmt::format("--dump: {:08X}h is no memory of chip {}", dump.address + i, dump.chip));
    }
  }
  return words;
}

std::size_t faults(const Network& network) {
  std::size_t count = 0;
  for (std::size_t n = 0; n < network.chip_count(); ++n)
    count += network.status(n) == ChipStatus::fault || network.status(n) == ChipStatus::external_access;
  return count;
}

std::string sentence(const Network& network, const machine::NetworkStop& stop, bool asked) {
  const std::size_t failed = faults(network);
  switch (stop.reason) {
    case machine::NetworkStop::Reason::ended:
      return failed == 0 ? "every chip has ended" : fmt::format("every chip has ended, {} of them in a fault", failed);
    case machine::NetworkStop::Reason::deadlock: return "no event is left, and chips wait";
    case machine::NetworkStop::Reason::limit:
      return asked ? "the cycles of --cycles have passed" : "--max-cycles reached";
    case machine::NetworkStop::Reason::interrupted: return "ended by a signal";
  }
  return {};
}

double microseconds(machine::Time time) { return static_cast<double>(time.count()) * 1e-6; }

void print_text(const Network& network, const machine::NetworkStop& stop, const std::vector<NetworkDump>& dumps,
                const Watched& watched, bool peripherals, bool asked) {
  io::print("stop: {}: {} ({:.3f} us)\n", name(stop.reason), sentence(network, stop, asked), microseconds(stop.time));
  for (std::size_t n = 0; n < network.chip_count(); ++n) {
    const c40::Chip& chip = network.chip(n);
    const std::string& called = network.chip_name(n);
    io::print("chip {}{}: {}: {}\n", n, called == std::to_string(n) ? "" : " (" + called + ")", name(network.status(n)),
              network.describe(n));
    io::print("  {} instructions, {} cycles:", chip.instructions(), chip.cycle());
    for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
      if (chip.causes()[cause] != 0) io::print(" {} {}", name(static_cast<c40::Cause>(cause)), chip.causes()[cause]);
    io::print("\n{}{}{}{}", watched[n].checks_text(), watched[n].text(), network.ignored(n).text(),
              peripherals ? peripherals_text(chip) : "");
  }
  for (std::size_t n = 0; n < network.link_count(); ++n) {
    const machine::NetworkLink& ends = network.ends(n);
    const c40::Link& link = network.link(n);
    io::print("link {}{}{}:", to_text(ends), link.is_cut() ? " (cut)" : "", link.is_dead() ? " (token lost)" : "");
    for (int side = 0; side < 2; ++side) {
      const auto& counters = link.counters(side);
      io::print("{} {} words", side == 0 ? " forth" : ", back", counters.sent);
      if (counters.lost != 0) io::print(" ({} lost)", counters.lost);
    }
    io::print("\n");
  }
  for (std::size_t n = 0; n < network.net_count(); ++n) {
    const machine::Net& net = network.net(n);
    io::print("net {} ({}): {}, {} edges", net.description().name, to_text(net.description()),
              net.level() ? "high" : "low", net.edges());
    if (net.missed() != 0)
      io::print(", {} {} missed by a receiver", net.missed(), net.missed() == 1 ? "pulse" : "pulses");
    io::print("\n");
  }
  for (const machine::NetworkEvent& event : network.events())
    if (!is_common(event.kind)) io::print("event {}\n", network.text(event));
  for (const NetworkDump& dump : dumps) {
    const std::vector<c40::Word> words = words_of(network, dump);
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (i % 8 == 0) io::print("{}chip {} {:08X}:", i == 0 ? "" : "\n", dump.chip, dump.address + i);
      io::print(" {:08X}{}", words[i], i + 1 == words.size() ? "\n" : "");
    }
  }
}

Json chip_json(const Network& network, std::size_t n) {
  const c40::Chip& chip = network.chip(n);
  Json out = {{"name", network.chip_name(n)},   {"status", name(network.status(n))},
              {"message", network.describe(n)}, {"pc", chip.pc()},
              {"cycles", chip.cycle()},         {"instructions", chip.instructions()}};
  for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
    out["causes"][std::string(name(static_cast<c40::Cause>(cause)))] = chip.causes()[cause];
  for (std::uint8_t code = 0; code < 32; ++code) {
    const auto reg = static_cast<isa::Register>(code);
    out["registers"][ascii::upper(isa::name(reg))] = chip.register_value(reg);
  }
  out["waits_for"] = network.waits_for(n) ? Json(*network.waits_for(n)) : Json();
  add_ports(chip, out);
  add_reserved(network.ignored(n), out);
  return out;
}

void print_json(const Network& network, const machine::NetworkStop& stop, const std::vector<NetworkDump>& dumps,
                const Watched& watched, bool peripherals, bool asked, const BoardConsole& front) {
  Json root = {
      {"stop",
       {{"reason", name(stop.reason)}, {"message", sentence(network, stop, asked)}, {"time_ps", stop.time.count()}}}};
  root["chips"] = Json::array();
  for (std::size_t n = 0; n < network.chip_count(); ++n) {
    Json chip = chip_json(network, n);
    watched[n].add_to(chip);
    if (peripherals) add_peripherals(network.chip(n), chip);
    root["chips"].push_back(std::move(chip));
  }
  root["links"] = Json::array();
  for (std::size_t n = 0; n < network.link_count(); ++n) {
    const machine::NetworkLink& ends = network.ends(n);
    const c40::Link& link = network.link(n);
    Json out = {{"a", to_text(ends.a)}, {"b", to_text(ends.b)}, {"cut", link.is_cut()}, {"token_lost", link.is_dead()}};
    for (int side = 0; side < 2; ++side) {
      const auto& c = link.counters(side);
      out[side == 0 ? "forth" : "back"] = {{"sent", c.sent},
                                           {"arrived", c.arrived},
                                           {"under_way", link.under_way(side)},
                                           {"lost", c.lost},
                                           {"tokens", c.tokens}};
    }
    root["links"].push_back(std::move(out));
  }
  root["nets"] = Json::array();
  for (std::size_t n = 0; n < network.net_count(); ++n) {
    const machine::Net& net = network.net(n);
    root["nets"].push_back({{"name", net.description().name},
                            {"pins", to_text(net.description())},
                            {"level", net.level() ? 1 : 0},
                            {"edges", net.edges()},
                            {"missed", net.missed()}});
  }
  root["events"] = Json::array();
  for (const machine::NetworkEvent& event : network.events()) root["events"].push_back(network.text(event));
  root["dumps"] = Json::array();
  for (const NetworkDump& dump : dumps)
    root["dumps"].push_back({{"chip", dump.chip}, {"address", dump.address}, {"words", words_of(network, dump)}});
  front.add_to(root);
  io::print("{}\n", root.dump(2, ' ', true, Json::error_handler_t::replace));
}

/// The instant that --cycles or --max-cycles of chip 0 means.
machine::Time end_of(const Network& network, const ExecOptions& options) {
  constexpr double most_seconds = 9e6;  // the limit of 64 bits of picoseconds
  const std::int64_t cycles = options.cycles.value_or(options.max_cycles.value_or(default_max_cycles));
  const auto most = static_cast<std::int64_t>(most_seconds * static_cast<double>(network.clock(0).hertz()));
  if (cycles > most)
    throw InputError(fmt::format("{}: {} cycles are more than a network's time holds; up to {} of chip 0 are possible",
                                 options.cycles ? "--cycles" : "--max-cycles", cycles, most));
  return network.clock(0).at(cycles);
}

}  // namespace

int exec_network(const ExecOptions& options) {
  if (!options.roms.empty())
    throw InputError("--rom: is for one chip; the chips of a network have the ROMs of their boards (region.file)");
  if (options.console_input == "live")
    throw InputError(
        "--console-input live: one chip has a live console; a network takes a file, or - for standard input");
  if (options.boot)
    throw InputError(
        "--boot: in a network the chips boot one another: boot = true of a [[chip]] in a --network file "
        "(docs/networks.md)");
  if (options.load_at && std::none_of(options.programs.begin(), options.programs.end(),
                                      [](const std::string& p) { return p.ends_with(".hex"); }))
    throw InputError("--load-at: is for .hex files only; other programs contain their addresses");
  Network network(described(options), options.turn_order);
  std::vector<NetworkDump> dumps;
  for (const std::string& text : options.dumps)
    words_of(network, dumps.emplace_back(parse_dump(text, network)));  // refuses bad ranges before the run
  for (const std::string& text : options.actions) network.schedule(action_of(text, network));
  io::FileRoles files = files_read(options);
  for (const std::string& text : options.loads) files.reads("--load", text.substr(0, text.rfind('@')));
  for (std::size_t n = 0; n < network.chip_count(); ++n)
    for (const std::string& source : network.program(n).files_read) files.reads("a source", source);
  for (std::size_t n = 0; n < network.chip_count(); ++n) files.writes("--trace", trace_file(options, n).value_or(""));
  files.writes("--link-trace", options.link_trace.value_or(""))
      .writes("--events", options.events.value_or(""))
      .writes("--perfetto", options.perfetto.value_or(""));
  add_device_files(options, files);
  Watched watched(network, options);
  std::vector<std::pair<std::string, machine::BoardDevices*>> boards;
  for (std::size_t n = 0; n < network.chip_count(); ++n) boards.emplace_back(network.chip_name(n), network.devices(n));
  BoardConsole front(std::move(boards), options, false);
  std::optional<io::OutputFile> link_trace, events;
  if (options.link_trace) link_trace.emplace(*options.link_trace);
  if (options.events) events.emplace(*options.events);
  std::optional<TimelineFile> timeline;
  if (options.perfetto) timeline.emplace(*options.perfetto);
  network.record_words(link_trace || events || timeline);
  network.record_peripherals(events || timeline);
  const io::StopBySignal signals;
  const machine::NetworkStop stop = network.run_until(end_of(network, options));
  watched.run_ended();
  if (link_trace) {
    for (const machine::NetworkEvent& event : network.events()) link_trace->stream() << network.text(event) << '\n';
    link_trace->commit_or_note();
  }
  if (events) {
    for (const std::string& line : network.event_trace()) events->stream() << line << '\n';
    events->commit_or_note();
  }
  if (timeline) {
    draw_network(network, timeline->stream());
    timeline->finish();
  }
  front.run_ended({front.empty() ? std::string() : state::save(network)});
  if (options.json) {
    print_json(network, stop, dumps, watched, options.peripherals, options.cycles.has_value(), front);
  } else {
    print_text(network, stop, dumps, watched, options.peripherals, options.cycles.has_value());
    io::print("{}{}", front.text(), front.hash_text());
  }
  if (stop.reason == machine::NetworkStop::Reason::interrupted) return signals.status(run_failed);
  if (stop.reason == machine::NetworkStop::Reason::limit && !options.cycles) return run_failed;
  return stop.reason == machine::NetworkStop::Reason::deadlock || faults(network) != 0 ? run_failed : success;
}

}  // namespace cli
