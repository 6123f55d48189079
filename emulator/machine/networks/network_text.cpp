// The texts of a network: names, status of each chip, events.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "isa/types.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Address;

namespace {
/// "loop+2, ring.asm:14"; empty if the address is unknown.
std::string source_of(const toolchain::Image& image, Address pc) {
  const auto holds = [pc](const toolchain::Image::Section& s) { return s.loaded && pc - s.address < s.size; };
  const auto section = std::find_if(image.sections.begin(), image.sections.end(), holds);
  if (section == image.sections.end()) return {};
  std::string out;
  Address nearest = 0;
  for (const auto& [name, value] : image.names())
    if (value >= section->address && value <= pc && (out.empty() || value > nearest)) {
      nearest = value;
      out = value == pc ? std::string(name) : fmt::format("{}+{}", name, pc - value);
    }
  for (const toolchain::LineRecord& line : image.lines)
    if (line.address == pc && line.file < image.files.size() && &image.sections[line.section] == &*section)
      return fmt::format("{}{}{}:{}", out, out.empty() ? "" : ", ", image.files[line.file], line.line);
  return out;
}
}  // namespace

std::string_view name(NetworkEvent::Kind kind) {
  constexpr std::array<std::string_view, 14> names{"word",     "token", "lost",    "dead",    "cut",
                                                   "restored", "rise",  "fall",    "missed",  "discarded",
                                                   "reset",    "hold",  "release", "pull_out"};
  static_assert(
      names.size() == static_cast<std::size_t>(NetworkEvent::Kind::pull_out) + 1 && names.back() == "pull_out",
      "one name each, in order");
  return names[static_cast<std::size_t>(kind)];
}
std::string_view name(ChipStatus status) {
  constexpr std::array<std::string_view, 11> names{"running",   "waiting", "looping", "sleeping",        "halt",
                                                   "idle",      "until",   "fault",   "external_access", "held",
                                                   "pulled_out"};
  static_assert(names.size() == static_cast<std::size_t>(ChipStatus::pulled_out) + 1 && names.back() == "pulled_out",
                "one name each, in order");
  return names[static_cast<std::size_t>(status)];
}
std::string_view name(NetworkStop::Reason reason) {
  constexpr std::array<std::string_view, 4> names{"ended", "deadlock", "limit", "interrupted"};
  static_assert(
      names.size() == static_cast<std::size_t>(NetworkStop::Reason::interrupted) + 1 && names.back() == "interrupted",
      "one name each, in order");
  return names[static_cast<std::size_t>(reason)];
}

std::optional<std::size_t> Network::neighbour(const Node& node, int port) const {
  const PortName here{node.number, port};
  for (const std::size_t link : node.links) {
    if (ends(link).a == here) return ends(link).b.chip;
    if (ends(link).b == here) return ends(link).a.chip;
  }
  return {};
}

std::optional<std::size_t> Network::waits_for(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  if (node.waits_for_memory()) return memory_of(node, node.stop.access.address)->owner;
  std::vector<int> ports;
  if (node.patience.loop) {
    for (const Address address : node.patience.loop->reads)
      if (c40::is_port_register(address)) ports.push_back(c40::port_access(address, false, 0, 0).port);
  } else if (node.waits_for_port()) {
    ports.push_back(node.stop.port.port);
  }
  if (node.dma_waits())
    for (const c40::DmaWait& wait : node.chip.dma_waits())
      if (wait.port) ports.push_back(*wait.port);
  for (const int port : ports)
    if (const auto other = neighbour(node, port)) return other;
  return {};
}

/// Whether the chip is in the loader of the boot ROM.
bool Network::boots(const Node& node) const {
  return node.description.boot && node.chip.pc() < c40::rom_words &&
         reset_source(node.description.board.board) == ResetSource::ports;
}

std::string Network::where(const Node& node) const {
  if (boots(node)) {
    if (const auto next = node.chip.register_value(isa::Register::AR1); next != 0)  // boot_rom.asm
      return fmt::format("PC {:08X}h (the boot loader, which reads a stream in memory, its next word at {:08X}h)",
                         node.chip.pc(), next);
    std::string taken = "no word of its stream yet";
    for (int port = 0; port < c40::port_count; ++port)
      if (const auto words = node.chip.port(port).traffic.read; words != 0)
        taken = fmt::format("{} words of its stream from port {}", words, port);
    return fmt::format("PC {:08X}h (the boot loader, which has taken {})", node.chip.pc(), taken);
  }
  const std::string source = source_of(*node.description.program, node.chip.pc());
  return fmt::format("PC {:08X}h{}", node.chip.pc(), source.empty() ? "" : " (" + source + ")");
}

/// The RAM into which a boot stream could have loaded something.
std::string Network::memories_of(const Node& node) const {
  std::vector<std::string> ram{fmt::format("{:08X}h", c40::on_chip_ram)};
  for (const c40::Region& region : node.description.board.board.regions)
    if (region.kind == c40::Region::Kind::ram) ram.push_back(fmt::format("{:08X}h", region.base));
  return fmt::format("board {} has RAM from {} on", node.description.board.board.name, fmt::join(ram, ", "));
}

std::string Network::describe_wait(const Node& node) const {
  if (node.waits_for_device())
    return fmt::format("waits for device {} at {:08X}h since cycle {}",
                       node.devices->at_address(node.stop.access.address).described.name, node.stop.access.address,
                       node.stop.access.cycle);
  if (node.waits_for_memory()) {
    const Memory& memory = *memory_of(node, node.stop.access.address);
    return fmt::format(
        "waits for memory {} at {:08X}h{} since cycle {}", memory.description.name, node.stop.access.address,
        memory.owner ? fmt::format(", which chip {} has locked,", *memory.owner) : "", node.stop.access.cycle);
  }
  const c40::PortAccess& access = node.stop.port;
  const std::string what = access.write ? fmt::format("room in output FIFO {}", access.port)
                                        : fmt::format("a word in input FIFO {}", access.port);
  return fmt::format("waits for {}{} since cycle {}", what, whom(node, access.port, access.write), access.cycle);
}

/// " from chip 0 port 3 (the link is cut)"
std::string Network::whom(const Node& node, int port, bool write) const {
  const PortName here{node.number, port};
  for (const std::size_t n : node.links) {
    const NetworkLink& link = ends(n);
    if (link.a != here && link.b != here) continue;
    const PortName& other = link.a == here ? link.b : link.a;
    return fmt::format(" {} chip {} port {}{}", write ? "towards" : "from", other.chip, other.port,
                       links_[n]->is_cut()    ? " (the link is cut)"
                       : links_[n]->is_dead() ? " (the token is lost)"
                                              : "");
  }
  return ", to which nothing is linked,";
}

/// A loop that reads nothing that others could change is an end, like a branch to itself.
bool Network::polls(const Node& node) const {
  const auto& reads = node.patience.loop->reads;
  return std::any_of(reads.begin(), reads.end(),
                     [&](Address a) { return c40::is_port_register(a) || memory_of(node, a) != nullptr; });
}

std::string Network::describe_loop(const Node& node) const {
  std::vector<std::string> polled;
  std::vector<int> unlinked;
  for (const Address address : node.patience.loop->reads) {
    if (const Memory* memory = memory_of(node, address))
      polled.push_back(fmt::format("memory {} at {:08X}h", memory->description.name, address));
    if (!c40::is_port_register(address)) continue;
    const int port = c40::port_access(address, false, 0, 0).port;
    if (neighbour(node, port))
      polled.push_back(fmt::format("port {}{}", port, whom(node, port, false)));
    else
      unlinked.push_back(port);
  }
  if (!unlinked.empty())
    polled.push_back(fmt::format("port{} {}, to which nothing is linked", unlinked.size() == 1 ? "" : "s",
                                 fmt::join(unlinked, ", ")));
  const Address pc = node.patience.loop->pc;
  const std::string source = source_of(*node.description.program, pc);
  const std::string_view rom = boots(node) ? " (the boot loader)" : "";
  const std::string does = polled.empty() ? "repeats a loop" : fmt::format("polls {}", fmt::join(polled, "; "));
  return fmt::format("{}; no change since cycle {}, at PC {:08X}h{}{}", does, node.patience.since, pc, rom,
                     source.empty() ? "" : " (" + source + ")");
}

std::string Network::describe_dma(const Node& node) const {
  std::vector<std::string> waits;
  for (const c40::DmaWait& wait : node.chip.dma_waits())
    waits.push_back(fmt::format("{}{} since cycle {}", c40::describe(wait),
                                wait.port ? whom(node, *wait.port, wait.write) : "", wait.since));
  return fmt::format("{}", fmt::join(waits, "; "));
}

bool Network::calls_debugger(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  return node.status == ChipStatus::fault && node.stop.fault->kind == c40::Fault::Kind::software_interrupt;
}

std::string Network::describe(std::size_t n) const {
  const Node& node = *nodes_.at(n);
  if (node.patience.loop)
    return node.dma_waits() ? fmt::format("{}; {}", describe_loop(node), describe_dma(node)) : describe_loop(node);
  switch (node.status) {
    case ChipStatus::looping: break;
    case ChipStatus::running: return fmt::format("runs at {}", where(node));
    case ChipStatus::waiting:
      return fmt::format("{}, at {}{}", describe_wait(node), where(node),
                         node.dma_waits() ? "; " + describe_dma(node) : "");
    case ChipStatus::sleeping:
      if (node.awaits_dma_forever())
        return fmt::format("{}; the processor sleeps at {}", describe_dma(node), where(node));
      if (node.has_ended())
        return fmt::format("{} {}; {}", node.chip.idle() ? "is in IDLE before" : "branches to itself at", where(node),
                           describe_dma(node));
      return fmt::format("sleeps at {} until {} interrupts it", where(node),
                         node.reacts_to_pins() ? "a pin" : "a port");
    case ChipStatus::halt: return fmt::format("branches to itself at {}", where(node));
    case ChipStatus::idle: return fmt::format("is in IDLE before {}, and no interrupt will come", where(node));
    case ChipStatus::until: return fmt::format("reached {}", where(node));
    case ChipStatus::fault:
      return fmt::format("{}, at {}, cycle {}{}", node.stop.fault->message, where(node), node.stop.fault->cycle,
                         boots(node) ? "; " + memories_of(node) : "");
    case ChipStatus::external_access: {
      const std::string who =
          node.stop.access.channel < 0 ? "" : fmt::format("DMA channel {} ", node.stop.access.channel);
      return fmt::format(
          "{}{} {:08X}h at {}: this is a window without a device of the board or a memory of the network", who,
          node.stop.access.write ? "writes" : "reads", node.stop.access.address, where(node));
    }
    case ChipStatus::held: return fmt::format("is held at {}", where(node));
    case ChipStatus::pulled_out: return "has been pulled out";
  }
  return {};
}

std::string Network::text(const NetworkEvent& event) const {
  using enum NetworkEvent::Kind;
  const std::string head = fmt::format("{} {}", event.time.count(), name(event.kind));
  if (event.kind == discarded)
    return fmt::format("{} {}.{} {} {:08X}", head, event.place, event.side, event.count == 1 ? "input" : "output",
                       event.word);
  if (event.kind == missed) return fmt::format("{} {} chip {}", head, net(event.place).description().name, event.side);
  if (event.kind == rise || event.kind == fall) return fmt::format("{} {}", head, net(event.place).description().name);
  if (event.kind >= reset) return fmt::format("{} {}", head, event.place);
  const NetworkLink& link = ends(event.place);
  const PortName &from = event.side == 0 ? link.a : link.b, &to = event.side == 0 ? link.b : link.a;
  if (event.kind == word)
    return fmt::format("{} {}>{} {:08X}", head, machine::to_text(from), machine::to_text(to), event.word);
  if (event.kind == lost)
    return fmt::format("{} {}>{} {:08X} after {} bytes", head, machine::to_text(from), machine::to_text(to), event.word,
                       event.count);
  if (event.kind == token) return fmt::format("{} {}", head, machine::to_text(from));
  return fmt::format("{} {}", head, machine::to_text(link));
}

std::vector<NetworkEvent> Network::events() const {
  std::vector<NetworkEvent> all;
  std::ranges::merge(events_, net_events_, std::back_inserter(all), {}, &NetworkEvent::time, &NetworkEvent::time);
  return all;
}

std::vector<ChipEvent> Network::peripheral_events() const {
  std::vector<ChipEvent> all;
  for (const auto& node : nodes_)
    for (const c40::PeripheralEvent& event : node->peripheral_events)
      all.push_back({node->number, node->clock.at(event.cycle), event});
  std::stable_sort(all.begin(), all.end(), [](const ChipEvent& a, const ChipEvent& b) { return a.time < b.time; });
  return all;
}

std::string Network::text(const ChipEvent& event) const {
  const AddressNames& names = nodes_.at(event.chip)->names();
  return fmt::format("{} chip {}: {}", event.time.count(), event.chip,
                     to_text(event.event, [&names](Address at) { return names.text(at); }));
}

std::vector<std::string> Network::event_trace() const {
  std::vector<std::string> lines;
  const std::vector<NetworkEvent> all = events();
  auto link = all.begin();
  const auto links_until = [&](Time time) {
    for (; link != all.end() && link->time <= time; ++link) lines.push_back(text(*link));
  };
  for (const ChipEvent& event : peripheral_events()) {
    links_until(event.time);
    lines.push_back(text(event));
  }
  links_until(never);
  return lines;
}

}  // namespace machine
