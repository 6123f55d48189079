#include "python/bindings/c40/c40.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "c40/chip/chip.hpp"
#include "machine/boards/board_file.hpp"
#include "machine/chips/boot.hpp"
#include "machine/debug/chip_debuggee.hpp"
#include "python/bindings/c40/chip_inspection.hpp"
#include "python/bindings/c40/devices.hpp"
#include "python/bindings/c40/processor.hpp"
#include "python/bindings/debug.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "python/bindings/interpreter/warnings.hpp"
#include "state/file.hpp"

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

/// The chip, for reading and for changing. Nobody keeps it at rest: its next run finds what was changed.
struct ChipOfProcessor {
  const c40::Chip& operator()(const Processor& p) const { return p.chip; }
  c40::Chip& operator()(Processor& p) const { return p.chip; }
  void poke(Processor& p, c40::Address address, Word value) const { p.chip.poke(address, value); }
  void changed(Processor&) const {}
};

void bind_processor(py::module_& m) {
  python::register_error<machine::BoardError>(m, "BoardError", PyExc_ValueError);
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
              ~Owner() { processor.cast<Processor&>().forget_ends(); }
            };
            auto owner = std::shared_ptr<Owner>(new Owner{self, program});
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
      .def("raise_timer", [](Processor& p, int timer) { p.chip.raise_timer(timer); })
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
            machine::BoardDescription described = python::read_board(board);
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
  bind_inspection(processor, ChipOfProcessor());
  bind_devices(processor, [](Processor& p) { return &p.devices; }, [](Processor& p) { return p.chip.cycle(); });
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
