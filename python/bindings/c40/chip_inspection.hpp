#pragma once
// Python's read access to a chip, for every class that holds a chip.
#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/chip/snapshot.hpp"
#include "c40/peripherals/register_map.hpp"
#include "c40/values/float40.hpp"
#include "isa/types.hpp"
#include "machine/boards/board_reserved.hpp"
#include "python/bindings/bindings.hpp"
#include "state/archive.hpp"

inline isa::Register register_of(const std::string& name) {
  if (const auto r = isa::register_named(name)) return *r;
  throw py::key_error("no register is called " + name);
}

/// The exact value of a register as a Python number m * 2**e.
inline py::object value_of(c40::Float40 x) {
  const std::int64_t m = c40::float40::mantissa(x);
  return py::module_::import("fractions").attr("Fraction")(m) *
         py::module_::import("fractions").attr("Fraction")(2).attr("__pow__")(x.e - 31);
}

inline py::dict causes_of(const c40::Causes& causes) {
  py::dict out;
  for (std::size_t i = 0; i < c40::cause_count; ++i)
    out[py::str(std::string(c40::name(static_cast<c40::Cause>(i))))] = causes[i];
  return out;
}

/// A dict for each address that was accessed although the board has nothing there.
inline py::list reserved_accesses(const machine::IgnoredAccesses& ignored) {
  py::list out;
  for (const auto& note : ignored.notes())
    out.append(py::dict(
        py::arg("address") = note.address, py::arg("reads") = note.reads, py::arg("writes") = note.writes,
        py::arg("first") = note.write ? "write" : "read", py::arg("value") = note.value, py::arg("pc") = note.pc,
        py::arg("cycle") = note.cycle,
        py::arg("dma_channel") = note.channel < 0 ? py::object(py::none()) : py::object(py::int_(note.channel))));
  return out;
}

inline py::dict port_of(const c40::CommPort& port) {
  const c40::PortTraffic& t = port.traffic;
  const auto words = [](const c40::Fifo& fifo) {
    return std::vector<c40::Word>(fifo.words().begin(), fifo.words().end());
  };
  return py::dict(py::arg("input") = words(port.input), py::arg("output") = words(port.output),
                  py::arg("token") = port.token, py::arg("input_halted") = port.input_halted,
                  py::arg("output_halted") = port.output_halted, py::arg("control") = port.control(),
                  py::arg("written") = t.written, py::arg("sent") = t.sent, py::arg("received") = t.received,
                  py::arg("read") = t.read, py::arg("discarded_input") = t.discarded_input,
                  py::arg("discarded_output") = t.discarded_output);
}

/// Every change by hand goes through `chip`: what has come to rest looks again.
/// \param chip gives the chip of an object of the class, const or not; has `poke`, and `changed` for after a change
template <class Class, class Chip>
void bind_inspection(py::class_<Class>& bound, Chip chip) {
  bound
      .def(
          "port", [chip](const Class& p, int n) { return port_of(chip(p).port(n)); },
          "FIFOs, halts, token and counters of a communication port.")
      .def("timer_pin", [chip](const Class& p, int timer) { return chip(p).timer_pin(timer); })
      .def("peripheral", [chip](const Class& p, const std::string& name) { return chip(p).peripheral(name); })
      .def("fields",
           [chip](const Class& p, const std::string& name) {
             const c40::RegisterInfo& info = c40::register_named(name);
             const c40::Word value = chip(p).peripheral(name);
             py::dict out;
             for (const c40::Field& field : info.fields) out[py::str(std::string(field.name))] = field.of(value);
             return out;
           })
      .def(
          "peripherals",
          [chip](const Class& p) {
            py::dict out;
            for (const c40::RegisterInfo& info : c40::register_map()) {
              const bool fifo = c40::is_port_register(info.address) &&
                                c40::port_access(info.address, false, 0, 0).reg != c40::PortRegister::control;
              if (!fifo) out[py::str(info.name)] = chip(p).peripheral(info.name);
            }
            return out;
          },
          "Every register but those of FIFOs, by name.")
      .def(
          "snapshot",
          [chip](const Class& p) {
            const std::vector<std::uint64_t> words = c40::snapshot(chip(p));
            return py::bytes(reinterpret_cast<const char*>(words.data()), words.size() * sizeof(std::uint64_t));
          },
          "Registers, cycles by cause, peripherals, FIFOs and cache, as 64-bit numbers.")
      .def(
          "save_state", [chip](const Class& p) { return py::bytes(state::save(chip(p))); },
          "All its state, for a chip of the same board.")
      .def(
          "load_state",
          [chip](Class& p, const std::string& saved) {
            state::load(chip(p), saved);
            chip.changed(p);
          },
          "After a ValueError, the chip is in no usable state.")
      .def(
          "state_leaves",
          [chip](const Class& p) {
            state::Lister list;
            const_cast<c40::Chip&>(static_cast<const c40::Chip&>(chip(p)))
                .list_state(list);  // NOLINT: a lister only reads
            std::vector<std::tuple<std::string, std::size_t, std::size_t>> out;
            for (const state::Leaf& leaf : list.leaves()) out.emplace_back(leaf.path, leaf.offset, leaf.size);
            return out;
          },
          "Path, offset and size of each value of save_state().")
      .def(
          "digest", [chip](const Class& p) { return c40::digest(chip(p).memory()); }, "A hash of all RAM.")
      .def("peek", [chip](const Class& p, c40::Address a) { return chip(p).peek(a); })
      .def("poke",
           [chip](Class& p, c40::Address a, c40::Word v) {
             chip.poke(p, a, v);
             chip.changed(p);
           })
      .def("read",
           [chip](const Class& p, c40::Address a, std::size_t count) {
             std::vector<c40::Word> words(count);
             for (auto& word : words) word = chip(p).peek(a++);
             return words;
           })
      .def(
          "get",
          [chip](const Class& p, const std::string& name) -> std::uint64_t {
            if (const auto e = isa::expansion_named(name)) return chip(p).expansion(*e);
            return chip(p).register_value(register_of(name));
          },
          "A register by name: 40 bits for R0 to R11, exponent in 39..32.")
      .def("set",
           [chip](Class& p, const std::string& name, std::uint64_t value) {
             if (const auto e = isa::expansion_named(name))
               chip(p).set_expansion(*e, static_cast<c40::Word>(value));
             else
               chip(p).set_register(register_of(name), value);
             chip.changed(p);
           })
      .def(
          "value",
          [chip](const Class& p, const std::string& name) {
            return value_of(chip(p).float_register(register_of(name)));
          },
          "The exact value of R0 to R11 as a Fraction.")
      .def_property_readonly("cycle", [chip](const Class& p) { return chip(p).cycle(); })
      .def_property_readonly("instructions", [chip](const Class& p) { return chip(p).instructions(); })
      .def_property_readonly("causes", [chip](const Class& p) { return causes_of(chip(p).causes()); })
      .def_property_readonly("idle", [chip](const Class& p) { return chip(p).idle(); })
      .def_property_readonly("halted", [chip](const Class& p) { return chip(p).halted(); });
}
