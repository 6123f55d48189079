#include <fmt/format.h>
#include <pybind11/stl.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "c40/chip.hpp"
#include "c40/peripherals/events.hpp"
#include "c40/peripherals/link.hpp"
#include "c40/self_check.hpp"
#include "machine/board_file.hpp"
#include "machine/boot.hpp"
#include "machine/debug/chip_debuggee.hpp"
#include "machine/network.hpp"
#include "python/bindings/c40.hpp"
#include "python/bindings/chip_inspection.hpp"
#include "python/bindings/ctrl_c.hpp"
#include "python/bindings/debug.hpp"
#include "python/bindings/devices.hpp"
#include "python/bindings/errors.hpp"
#include "state/file.hpp"
#include "toolchain/assembler/assembler.hpp"

namespace {

using c40::Cycles;
using c40::Word;

/// Pin `n` of those that begin with `first`.
c40::Pin pin_of(c40::Pin first, int n, int count) {
  if (n < 0 || n >= count) {
    const std::string called(name(first).substr(0, name(first).size() - 1));
    throw std::out_of_range("there is no pin " + called + std::to_string(n) + "; 0 to " + std::to_string(count - 1) +
                            " are possible");
  }
  return static_cast<c40::Pin>(static_cast<int>(first) + n);
}

py::dict describe(const c40::Chip& chip, const c40::StopInfo& stop) {
  py::dict out;
  out["reason"] = std::string(name(stop.reason));
  out["pc"] = chip.pc();
  out["cycle"] = chip.cycle();
  if (stop.reason == c40::StopInfo::Reason::external_access) {
    out["address"] = stop.access.address;
    out["write"] = stop.access.write;
    out["interlocked"] = stop.access.interlocked;
    out["value"] = stop.access.value;
    out["access_cycle"] = stop.access.cycle;
    out["channel"] = stop.access.channel;
  }
  if (stop.reason == c40::StopInfo::Reason::port_access || stop.reason == c40::StopInfo::Reason::port_wait) {
    out["message"] = describe(stop.port);
    out["port"] = stop.port.port;
    out["address"] = stop.port.address;
    out["write"] = stop.port.write;
    out["value"] = stop.port.value;
    out["access_cycle"] = stop.port.cycle;
    out["ready"] = stop.port.ready(chip.port(stop.port.port));
  }
  if (stop.fault) {
    out["kind"] = std::string(name(stop.fault->kind));
    out["message"] = stop.fault->message;
    out["word"] = stop.fault->word;
    out["address"] = stop.fault->address;
  }
  return out;
}

/// Keeps every record as a dict.
class Recorder : public c40::TraceSink {
 public:
  void instruction(const c40::TraceRecord& record) override {
    py::dict out;
    out["cycle"] = record.cycle;
    out["pc"] = record.pc;
    out["word"] = record.word;
    out["cycles"] = record.cycles;
    out["causes"] = causes_of(record.causes);
    const c40::PipelineStages& at = record.stages;
    out["stages"] = py::make_tuple(record.cycle + at.fetch, record.cycle + at.decode, record.cycle + at.read,
                                   record.cycle + at.execute);
    py::dict registers;
    for (const auto& change : record.registers) registers[py::str(std::string(isa::name(change.reg)))] = change.value;
    out["registers"] = registers;
    py::list memory;
    for (const auto& event : record.memory)
      memory.append(py::make_tuple(event.write ? "w" : "r", event.address, event.value));
    out["memory"] = memory;
    records.append(out);
  }
  void interrupt(Word vector, Cycles cycle) override {
    py::dict out;
    out["interrupt"] = vector;
    out["cycle"] = cycle;
    records.append(out);
  }
  py::list records;
};

class Processor : public c40::PeripheralSink {
 public:
  Processor(const std::string& board, bool checks, const std::vector<py::object>& own)
      : Processor(machine::read_board(board), checks, own) {}
  Processor(machine::BoardDescription described, bool checks, const std::vector<py::object>& own)
      : board(machine::configuration_of(described.board)),
        surroundings(described.board),
        chip(std::move(described.board)),
        devices(described.devices),
        ignored(described.ignored) {
    for (const py::object& device : own) {
      auto [place, behind] = PythonDevice::place(device);
      devices.add(std::move(place), std::move(behind));
    }
    for (const auto& [place, device] : devices.places()) board += machine::configuration_of(place);
    for (const auto& [base, words] : described.contents) chip.write_block(base, words);
    around.emplace(devices, chip);
    if (!checks) return;
    self_check.emplace(chip);
    chip.set_trace(&*self_check);
  }

  void load_words(c40::Address address, const std::vector<Word>& words) { chip.write_block(address, words); }
  void load_image(const toolchain::Image& image) {
    toolchain::require_c40(image);
    for (const auto& section : image.sections) {
      if (!section.loaded) continue;
      try {
        chip.write_block(section.address, section.words);
      } catch (const std::out_of_range&) {
        throw std::out_of_range(machine::no_ram_for(surroundings, section.name, section.address, section.size));
      }
    }
    chip.set_pc(image.entry);
  }
  py::dict run(Cycles max_cycles, std::optional<c40::Address> until) {
    if (self_check) self_check->look();
    stop_at(until);
    const auto after = [&] {
      if (self_check) self_check->run_ended();
    };
    try {
      const c40::StopInfo stop = run_for(max_cycles);
      after();
      return describe(chip, stop);
    } catch (const py::error_already_set&) {
      after();
      throw;
    }
  }
  void add_breakpoint(c40::Address address) {
    breakpoints_.insert(address);
    if (until_ != address) chip.add_breakpoint(address);
  }
  void remove_breakpoint(c40::Address address) {
    breakpoints_.erase(address);
    if (until_ != address) chip.remove_breakpoint(address);
  }
  py::list trace(Cycles max_cycles) {
    Recorder recorder;
    stop_at(std::nullopt);
    if (self_check)
      self_check->look(), self_check->hand_on_to(&recorder);
    else
      chip.set_trace(&recorder);
    const auto after = [&] {
      if (self_check)
        self_check->run_ended(), self_check->hand_on_to(nullptr);
      else
        chip.set_trace(nullptr);
    };
    try {
      run_for(max_cycles);
    } catch (const py::error_already_set&) {
      after();
      throw;
    }
    after();
    return recorder.records;
  }

  py::dict step() {
    if (self_check) self_check->look();
    around->limit(chip.cycle());
    c40::StopInfo stop = chip.step();
    while (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access)) stop = chip.step();
    if (self_check) self_check->run_ended();
    return describe(chip, stop);
  }
  py::list diagnostics() const {
    py::list all;
    if (!self_check) return all;
    for (const c40::Diagnostic& d : self_check->diagnostics()) {
      all.append(py::dict(py::arg("rule") = std::string(c40::name(d.rule)), py::arg("section") = std::string(d.section),
                          py::arg("pc") = d.pc, py::arg("cycle") = d.cycle, py::arg("instruction") = d.instruction,
                          py::arg("message") = d.message, py::arg("count") = d.count));
    }
    return all;
  }

  void record_events() { chip.set_peripheral_sink(this); }
  void happened(const c40::PeripheralEvent& e) override {
    events.append(py::make_tuple(std::string(name(e.kind)), e.cycle, e.number, e.value, e.channel));
  }

  /// \throws StateError with checks on: what they have seen is not saved
  state::Key configuration(const toolchain::Image* program) const {
    if (self_check) throw state::StateError("a processor with checks has no snapshots; one without checks has");
    return {{"board", board}, {"program", program == nullptr ? "" : machine::configuration_of(*program)}};
  }

  std::string board;  ///< what has to be the same for a state to fit
  c40::Board surroundings;
  c40::Chip chip;
  machine::BoardDevices devices;
  std::optional<machine::LoneDevices> around;
  machine::IgnoredAccesses ignored;
  /// The chip, and what stands around it.
  void list_state(state::Visitor& list) {
    chip.list_state(list);
    if (!ignored.empty()) list("ignored", ignored);
    if (devices.empty()) return;
    list("devices", devices);
    list("around", *around);
  }
  std::optional<c40::SelfCheck> self_check;
  py::list events;

 private:
  std::set<c40::Address> breakpoints_;  ///< those of the caller
  std::optional<c40::Address> until_;   ///< one more, where the last run was to end

  /// A change of breakpoints makes the chip forget its blocks: who calls one routine after the other, each to the same
  /// return address, keeps them.
  void stop_at(std::optional<c40::Address> until) {
    if (until == until_) return;
    if (until_ && !breakpoints_.contains(*until_)) chip.remove_breakpoint(*until_);
    if (until && !breakpoints_.contains(*until)) chip.add_breakpoint(*until);
    until_ = until;
  }
  /// By a device, or as an access to nothing.
  bool answered(const c40::ExternalAccess& access) { return around->serve(access) || ignored.serve(chip, access); }
  /// In slices, so that Ctrl-C is heard.
  c40::StopInfo run_for(Cycles cycles) {
    constexpr Cycles slice = 50'000;
    return interruptible([&] {
      const Cycles limit = chip.cycle() + cycles;
      c40::StopInfo stop;
      do stop = chip.run_until(around->limit(std::min(limit, chip.cycle() + slice)));
      while (((stop.reason == c40::StopInfo::Reason::limit && chip.cycle() < limit) ||
              (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access))) &&
             !io::stop_asked());
      return stop;
    });
  }
};

/// A link of two processors; its events as dicts.
class Link : public c40::LinkListener {
 public:
  using End = std::pair<Processor*, int>;
  static c40::Link::Side side(End end, std::pair<std::int64_t, std::int64_t> hertz) {
    return {"port " + std::to_string(end.second), end.second, &end.first->chip.port(end.second),
            c40::PacedClock{c40::Clock{hertz.first, hertz.second}}};
  }
  Link(End a, End b, std::pair<std::int64_t, std::int64_t> hertz_a, std::pair<std::int64_t, std::int64_t> hertz_b)
      : link(side(a, hertz_a), side(b, hertz_b)), ends{a, b} {
    a.first->chip.attach(a.second, &link.listener(0));
    b.first->chip.attach(b.second, &link.listener(1));
    link.listener_of_events = this;
  }
  void happened(const c40::LinkEvent& e) override {
    events.append(py::dict(py::arg("kind") = std::string(name(e.kind)), py::arg("time") = e.time.count(),
                           py::arg("side") = e.side, py::arg("word") = e.word, py::arg("bytes") = e.bytes));
  }
  ~Link() override {
    for (const End& end : ends) end.first->chip.attach(end.second, nullptr);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  c40::Link link;
  std::array<End, 2> ends;
  py::list events;
};

void bind_link(py::module_& m) {
  using c40::Time;
  py::class_<Link>(m, "Link",
                   "A link of two ports, driven by whoever drives the processors. Ends are (processor, port), clocks "
                   "(numerator, denominator) in Hz, times picoseconds.")
      .def(py::init<Link::End, Link::End, std::pair<std::int64_t, std::int64_t>,
                    std::pair<std::int64_t, std::int64_t>>(),
           py::arg("a"), py::arg("b"), py::arg("hertz_a") = std::pair{20'000'000, 1},
           py::arg("hertz_b") = std::pair{20'000'000, 1}, py::keep_alive<1, 2>(), py::keep_alive<1, 3>())
      .def("advance_to", [](Link& l, std::int64_t t) { l.link.advance_to(Time{t}); })
      .def_property_readonly("next_event",
                             [](const Link& l) -> std::optional<std::int64_t> {
                               return l.link.next_event() == c40::never ? std::nullopt
                                                                        : std::optional{l.link.next_event().count()};
                             })
      .def("cut", [](Link& l, std::int64_t t) { l.link.cut(Time{t}); })
      .def("restore", [](Link& l, std::int64_t t) { l.link.restore(Time{t}); })
      .def_property_readonly("is_dead", [](const Link& l) { return l.link.is_dead(); })
      .def_property_readonly("lookahead", [](const Link& l) { return l.link.lookahead().count(); })
      .def("counters",
           [](const Link& l, int side) {
             const auto& c = l.link.counters(side);
             return py::dict(py::arg("sent") = c.sent, py::arg("arrived") = c.arrived, py::arg("lost") = c.lost,
                             py::arg("tokens") = c.tokens, py::arg("under_way") = l.link.under_way(side));
           })
      .def_readonly("events", &Link::events);
}

void bind_processor(py::module_& m) {
  py::class_<Processor> processor(
      m, "Processor", "One TMS320C40 on board `default`, `flat` (ruling 26), or one that a TOML file describes.");
  processor
      .def(py::init<const std::string&, bool, const std::vector<py::object>&>(), py::arg("board") = "default",
           py::arg("checks") = false, py::arg("devices") = std::vector<py::object>())
      .def("diagnostics", &Processor::diagnostics, "Rules that the program broke, with checks on.")
      .def("load_words", &Processor::load_words, py::arg("address"), py::arg("words"))
      .def_property_readonly("reserved_accesses", [](const Processor& p) { return reserved_accesses(p.ignored); })
      .def("load_image", &Processor::load_image, "Loads the sections of an image and sets the PC to its entry.")
      .def(
          "save",
          [](Processor& p, const toolchain::Image* program) {
            return py::bytes(state::seal("processor", p.configuration(program), state::save_with_tables(p)));
          },
          py::arg("program"))
      .def(
          "debug",
          [](const py::object& self, const toolchain::Image& program) {
            struct Owner {
              py::object processor;
              toolchain::Image program;
            };
            auto owner = std::make_shared<Owner>(self, program);
            auto& p = self.cast<Processor&>();
            if (const auto why = p.devices.stateless()) throw state::StateError(*why);
            const bool alone = p.devices.empty();
            auto debuggee = std::make_unique<machine::debug::ChipDebuggee>(
                p.chip, owner->program, alone ? nullptr : &p.devices, alone ? nullptr : &*p.around,
                p.ignored.empty() ? nullptr : &p.ignored);
            return std::make_unique<PythonDebugger>(std::move(owner), std::move(debuggee), true);
          },
          py::arg("program"))
      .def(
          "load",
          [](Processor& p, const std::string& sealed, const toolchain::Image* program) {
            state::load_or_leave(p, state::opened(sealed, "processor", p.configuration(program)).text);
          },
          py::arg("sealed"), py::arg("program"),
          "Raises an error for data that is not a snapshot of such a processor; nothing is changed then.")
      .def("run", &Processor::run, py::arg("max_cycles"), py::arg("until") = py::none(),
           "Runs whole instructions for max_cycles, or until the PC is at `until`; says why it stopped.")
      .def("trace", &Processor::trace, py::arg("max_cycles"), "Runs and returns one dict per instruction.")
      .def("step", &Processor::step)
      .def("reset", [](Processor& p) { p.chip.reset(); })
      .def("hold", [](Processor& p, bool held) { p.chip.hold(held); })
      .def("raise_iiof", [](Processor& p, int pin) { p.chip.raise_iiof(pin); })
      .def("set_iiof", [](Processor& p, int pin,
                          bool active) { p.chip.set_pin(pin_of(c40::Pin::iiof0, pin, 4), !active, p.chip.cycle()); })
      .def("raise_nmi", [](Processor& p) { p.chip.raise_nmi(); })
      .def(
          "complete_read",
          [](Processor& p, Word value, Cycles arbitration, Cycles transfer) {
            p.chip.complete_read(value, arbitration, transfer);
          },
          py::arg("value"), py::arg("arbitration") = 0, py::arg("transfer") = 0)
      .def(
          "complete_write",
          [](Processor& p, Cycles arbitration, Cycles transfer) { p.chip.complete_write(arbitration, transfer); },
          py::arg("arbitration") = 0, py::arg("transfer") = 0)
      .def(
          "complete_port", [](Processor& p, Cycles at) { p.chip.complete_port(at); }, py::arg("at"))
      .def(
          "deliver",
          [](Processor& p, int n, Word word) {
            if (p.chip.port(n).input.full()) throw py::value_error("the input FIFO is full");
            p.chip.port(n).receive(word);
          },
          "Puts a word into the input FIFO of a port, as its neighbour would.")
      .def(
          "collect",
          [](Processor& p, int n) {
            if (p.chip.port(n).output.empty()) throw py::value_error("the output FIFO is empty");
            return p.chip.port(n).send();
          },
          "Takes a word from the output FIFO of a port, as its neighbour would.")
      .def_static(
          "bootable",
          [](const std::string& board, std::optional<c40::Address> memory, const std::vector<py::object>& own) {
            machine::BoardDescription described = machine::read_board(board);
            described.board = memory ? machine::with_boot_from_memory(std::move(described.board), *memory)
                                     : machine::with_boot_from_port(std::move(described.board));
            return std::make_unique<Processor>(std::move(described), false, own);
          },
          py::arg("board") = "default", py::arg("memory") = py::none(), py::arg("devices") = std::vector<py::object>(),
          "With the boot ROM, its pins for a port, or for memory at this address.")
      .def(
          "boot", [](Processor& p) { p.chip.boot(); }, "What the RESET pin does.")
      .def("iiof_pin", [](const Processor& p, int pin) { return p.chip.iiof_pin(pin); })
      .def("record_events", &Processor::record_events)
      .def_readonly("events", &Processor::events)
      .def("set_timer_pin",
           [](Processor& p, int timer, bool level) {
             p.chip.set_pin(pin_of(c40::Pin::tclk0, timer, 2), level, p.chip.cycle());
           })
      .def_property_readonly("dma_active", [](const Processor& p) { return p.chip.dma_active(); })
      .def_property_readonly("settled", [](const Processor& p) { return p.chip.settled(); })
      .def_property_readonly("watches_ports", [](const Processor& p) { return p.chip.watches_ports(); })
      .def("add_breakpoint", &Processor::add_breakpoint)
      .def("remove_breakpoint", &Processor::remove_breakpoint)
      .def(
          "locked", [](const Processor& p, bool global) { return p.chip.locked(global); }, py::arg("global_bus"),
          "Whether LOCK of the global, LLOCK of the local bus is low.")
      .def(
          "set_exact", [](Processor& p, bool exact) { p.chip.set_exact(exact); },
          "One instruction at a time, no blocks.")
      .def_property(
          "pc", [](const Processor& p) { return p.chip.pc(); },
          [](Processor& p, c40::Address pc) { p.chip.set_pc(pc); });
  bind_inspection(processor, [](auto& p) -> auto& { return p.chip; });
  bind_devices(processor, [](Processor& p) { return &p.devices; });
}

}  // namespace

void bind_c40(py::module_& core) {
  auto m = core.def_submodule("c40", "One TMS320C40.");
  bind_processor(m);
  bind_link(m);
  bind_registers(m);
  bind_float40(m);
  bind_snapshots(core);
}
