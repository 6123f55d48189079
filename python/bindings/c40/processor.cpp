#include "python/bindings/c40/processor.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "machine/chips/boot.hpp"
#include "machine/networks/network.hpp"
#include "python/bindings/c40/chip_inspection.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "toolchain/assembler/assembler.hpp"

using c40::Cycles;
using c40::Word;

namespace {

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
  void interrupt(const c40::InterruptRecord& record) override {
    py::dict out;
    out["interrupt"] = record.vector;
    out["cycle"] = record.cycle;
    out["causes"] = causes_of(record.causes);
    records.append(out);
  }
  py::list records;
};

}  // namespace

Processor::Processor(machine::BoardDescription described, bool checks, const std::vector<py::object>& own)
    : board(machine::configuration_of(described.board)),
      surroundings(described.board),
      chip(std::move(described.board)),
      devices(described.devices),
      ignored(described.ignored) {
  for (const py::object& device : own) {
    auto [place, behind] = PythonDevice::place(device);
    devices.add(surroundings, std::move(place), std::move(behind));
  }
  for (const auto& [place, device] : devices.places()) board += machine::configuration_of(place);
  for (const auto& [base, words] : described.contents) chip.write_block(base, words);
  around.emplace(devices, chip);
  if (!checks) return;
  self_check.emplace(chip);
  chip.set_trace(&*self_check);
}

void Processor::load_image(const toolchain::Image& image) {
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

py::dict Processor::run(Cycles max_cycles, std::optional<c40::Address> until) {
  if (self_check) self_check->look();
  stop_at(until);
  const auto after = [&] {
    if (self_check) self_check->run_ended();
  };
  try {
    const c40::StopInfo stop = run_for(max_cycles);
    after();
    return describe(chip, stop);
  } catch (...) {
    after();
    throw;
  }
}

void Processor::add_breakpoint(c40::Address address) {
  breakpoints_.insert(address);
  if (until_ != address) chip.add_breakpoint(address);
}

void Processor::remove_breakpoint(c40::Address address) {
  breakpoints_.erase(address);
  if (until_ != address) chip.remove_breakpoint(address);
}

py::list Processor::trace(Cycles max_cycles) {
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
  } catch (...) {
    after();
    throw;
  }
  after();
  return recorder.records;
}

py::dict Processor::step() {
  if (self_check) self_check->look();
  // What devices do comes after all that the DMA has done before it, and an interrupt before the instruction.
  c40::StopInfo stop = settle_dma();
  if (stop.reason == c40::StopInfo::Reason::limit) {
    around->limit(chip.cycle());
    // Behind the instruction the chip may stop again, for an access of its DMA.
    const auto stepped = [this, pc = chip.pc(), before = chip.instructions()] {
      return chip.instructions() != before || chip.pc() != pc;
    };
    stop = chip.step();
    while (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access))
      stop = stepped() ? settle_dma() : chip.step();
  }
  around->run_ended();
  if (self_check) self_check->run_ended();
  return describe(chip, stop);
}

/// The DMA comes to where the processor is.
c40::StopInfo Processor::settle_dma() {
  c40::StopInfo stop;
  do stop = chip.run_until(around->limit(chip.cycle()));
  while (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access));
  return stop;
}

py::list Processor::diagnostics() const {
  py::list all;
  if (!self_check) return all;
  for (const c40::Diagnostic& d : self_check->diagnostics()) {
    all.append(py::dict(py::arg("rule") = std::string(c40::name(d.rule)), py::arg("section") = std::string(d.section),
                        py::arg("pc") = d.pc, py::arg("cycle") = d.cycle, py::arg("instruction") = d.instruction,
                        py::arg("message") = d.message, py::arg("count") = d.count));
  }
  return all;
}

state::Key Processor::configuration(const toolchain::Image* program) const {
  if (self_check) throw state::StateError("a processor with checks has no snapshots; one without checks has");
  return {{"board", board}, {"program", program == nullptr ? "" : machine::configuration_of(*program)}};
}

void Processor::stop_at(std::optional<c40::Address> until) {
  if (until == until_) return;
  if (until_ && !breakpoints_.contains(*until_)) chip.remove_breakpoint(*until_);
  if (until && !breakpoints_.contains(*until)) chip.add_breakpoint(*until);
  until_ = until;
}

c40::StopInfo Processor::run_for(Cycles cycles) {
  constexpr Cycles slice = 50'000;
  return interruptible([&] {
    const Cycles limit = chip.cycle() + cycles;
    c40::StopInfo stop;
    do stop = chip.run_until(around->limit(std::min(limit, chip.cycle() + slice)));
    while (((stop.reason == c40::StopInfo::Reason::limit && chip.cycle() < limit) ||
            (stop.reason == c40::StopInfo::Reason::breakpoint && !is_own_breakpoint(chip.pc())) ||  // a debugger's
            (stop.reason == c40::StopInfo::Reason::external_access && answered(stop.access))) &&
           !io::stop_asked());
    around->run_ended();
    return stop;
  });
}

void Processor::happened(const c40::PeripheralEvent& e) {
  events.append(py::make_tuple(std::string(name(e.kind)), e.cycle, e.number, e.value, e.channel));
}

void Processor::list_state(state::Visitor& list) {
  chip.list_state(list);
  if (!ignored.empty()) list("ignored", ignored);
  if (devices.empty()) return;
  list("devices", devices);
  list("around", *around);
}
