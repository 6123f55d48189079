// Accesses of an instruction whose region is not known yet: finds the region, or asks the outside.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/engine/engine.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {

Engine::Stepped Engine::fail(Fault::Kind kind, std::string message, Address address) {
  Fault fault;
  fault.kind = kind;
  fault.message = std::move(message);
  fault.pc = state_.core.pc;
  fault.cycle = state_.cycle;
  fault.address = address;
  if (const Memory::Area* area = memory_.find(fault.pc); area != nullptr && area->data != nullptr)
    fault.word = area->data[fault.pc - area->base];
  fault_ = std::move(fault);
  return Stepped::fault;
}

// A flat board has RAM everywhere, up to a limit.
Engine::Stepped Engine::nothing_at(std::string_view access, Address address) {
  if (board_.is_flat)
    return fail(Fault::Kind::not_modelled,
                fmt::format("{} {:08X}h: the program uses more than the {} MiB of RAM that board {} may take", access,
                            address, board_.flat_words_max * sizeof(Word) >> 20, board_.name),
                address);
  return fail(Fault::Kind::reserved_address,
              fmt::format("{} {:08X}h, which is reserved on board {}", access, address, board_.name), address);
}

// The access's beginning after the beginning of the instruction; the pipeline is in the state `before`.
Cycles Engine::access_start(const Step& step, std::size_t access, PipelineId before) {
  Demand demand = step.demand();
  demand.count = static_cast<std::uint8_t>(access + 1);
  // Other chips act between the accesses, and timers count: the second access is not before the first one.
  const auto& starts = pipelines_.transition(before, demand, packed(demand), step.word).timing.start;
  const int start = std::max(starts.front(), starts[access]);
  const Access& data = demand.data[access];
  // Registers on the chip answer a read at the end of the read stage, with their state in the execute stage, in which
  // they are written (fidelity.md).
  const int later = data.resource == Resource::peripheral && !data.write ? 1 : 0;
  return std::max(start + later, 0);
}

Cycles Engine::access_cycle(const Step& step, std::size_t access) {
  Cycles cycle = state_.cycle + access_start(step, access, pipeline_.id());
  for (const Answer& answer : state_.answers)
    if (answer.given) cycle += answer.waited();
  return cycle;
}

// The region of an access is not known: finds it, or stops the chip.
Engine::Stepped Engine::resolve(Step& step) {
  const std::size_t k = state_.core.miss_access;
  const Memory::Area* area = find_area(step, k);
  if (area == nullptr) return Stepped::fault;
  DecodedSlot& decoded = *step.decoded;
  step.locks |= decoded.bound.row->interlocked && external(area->resource);
  if (decoded.demand.count <= k) decoded.demand.count = static_cast<std::uint8_t>(k + 1);
  decoded.data_bits = packed_data(decoded.demand);
  decoded.forget_transition();
  step.address[k] = state_.core.miss_address;
  if (area->data == nullptr) return access_outside(step, k, *area);
  access_memory(step, k, *area);
  return Stepped::done;
}

// Null if the chip stops with a fault. An access to an area on two strobes, or with pages, is resolved each time.
const Memory::Area* Engine::find_area(Step& step, std::size_t k) {
  const Address address = state_.core.miss_address;
  const bool write = state_.core.miss_write;
  DecodedSlot& decoded = *step.decoded;
  const Memory::Area* area = decoded.area[k];
  if (area != nullptr && area->contains(address) && decoded.demand.data[k].write == write) return area;
  area = decoded.area[k] = memory_.find(address);
  if (area == nullptr) {
    nothing_at(write ? "write to" : "read of", address);
    return nullptr;
  }
  if (write && area->kind == Region::Kind::rom) {
    fail(Fault::Kind::reserved_address, fmt::format("write to {:08X}h, which is in the {}", address, area->name),
         address);
    return nullptr;
  }
  if (!step.paged) pages_ = state_.open_pages;
  const Memory::AccessInfo met = memory_.meet(*area, address, write, pages_);
  step.paged |= met.paged;
  decoded.demand.data[k] = met.access;
  if (met.paged || met.words != area->words) decoded.area[k] = nullptr;
  return area;
}

// Windows cover whole areas; an area's map of code words follows its data.
void Engine::access_memory(Step& step, std::size_t k, const Memory::Area& area) {
  const Core& core = state_.core;
  const Address address = core.miss_address;
  DecodedSlot& decoded = *step.decoded;
  step.plain &= decoded.area[k] != nullptr && !step.locks;
  step.repeatable &= step.plain;
  const Word held = area.data[address - area.base];
  const Word value = core.miss_write ? core.miss_value : held;
  if (area.set_apart) [[unlikely]] {
    probe_.note({.address = address, .before = held, .value = value, .write = core.miss_write});
    decoded.area[k] = nullptr;
    step.plain = step.repeatable = false;
  }
  decoded.ops[0].access[k] = {area.data, area.base, area.words};
  if (trace != nullptr) events_.push_back({address, value, core.miss_write});
}

// An access to a register, a port or a window: the instruction gets a cell with the answer.
Engine::Stepped Engine::access_outside(Step& step, std::size_t k, const Memory::Area& area) {
  const Core& core = state_.core;
  const Address address = core.miss_address;
  const bool write = core.miss_write;
  const bool window = area.kind != Region::Kind::registers;
  // Where a DMA is active, an access to a port may let it continue.
  const bool at_link = !window && is_linked(address) && !peripherals_.dma_active();
  step.plain = false;
  step.repeatable &=
      (area.kind == Region::Kind::external_window || at_link) && step.decoded->area[k] != nullptr && step.windows == 0;
  auto& cell = scratch_[k].cell;
  cell = {};
  const Stepped why = window                      ? access_window(step, k, cell[0])
                      : is_port_register(address) ? access_port(step, k, cell[0])
                                                  : access_register(step, k, cell[0]);
  if (why != Stepped::done) return why;
  if (window || at_link) step.windows |= static_cast<std::uint8_t>(1u << k);
  step.decoded->ops[0].access[k] = {cell.data(), address, 1};
  const Word value = write ? core.miss_value : cell[0];
  if (probe_.on_data()) [[unlikely]]
    probe_.note({.address = address, .before = value, .value = value, .write = write});
  if (trace != nullptr) events_.push_back({address, value, write});
  return Stepped::done;
}

Engine::Stepped Engine::access_register(Step& step, std::size_t k, Word& cell) {
  const Address address = state_.core.miss_address;
  const bool write = state_.core.miss_write;
  step.register_cycle[k] = access_cycle(step, k);
  if (!peripherals_.read(address, step.register_cycle[k], cell))
    return fail(Fault::Kind::not_modelled,
                fmt::format("{} {:08X}h: {} is not modelled", write ? "write to" : "read of", address,
                            describe_register(address)),
                address);
  step.register_writes |= static_cast<std::uint8_t>(unsigned{write} << k);
  return Stepped::done;
}

// Where the access is not answered at once, the chip stops first.
Engine::Stepped Engine::access_window(const Step& step, std::size_t k, Word& cell) {
  const Core& core = state_.core;
  const bool write = core.miss_write;
  if (!access_.is_answer_to(k, core.miss_address, write)) {
    const bool locks = step.decoded->bound.row->interlocked;
    const Word value = write ? core.miss_value : 0;
    const ExternalAccess access{core.miss_address, write, locks, value, access_cycle(step, k), -1};
    // The wait holds the whole instruction, also its access to a register on the chip, which came first: with the
    // answer the instruction is done again.
    const Memory::Area* first = step.decoded->area[0];
    const bool behind_register = k != 0 && first != nullptr && first->kind == Region::Kind::registers;
    if (behind_register || !answers_at_once(access)) {
      access_.begin(k, access);
      return Stepped::external;
    }
    access_.forget();
    state_.answers[k] = opened_.given(write, core.miss_address);
  }
  cell = state_.answers[k].value;
  return Stepped::done;
}

// Whether a register belongs to a port with a link.
bool Engine::is_linked(Address address) const {
  return is_port_register(address) && ports_.listener(port_access(address, false, 0, 0).port) != nullptr;
}

// Does the access to a port. If the port has a link, or the access has to wait, the chip stops first.
Engine::Stepped Engine::access_port(const Step& step, std::size_t k, Word& cell) {
  const Core& core = state_.core;
  const bool write = core.miss_write;
  if (!access_.is_answer_to(k, core.miss_address, write)) {
    access_.begin(k, port_access(core.miss_address, write, write ? core.miss_value : 0, access_cycle(step, k)));
    if (!ports_.is_free(access_.port())) return Stepped::port;
    complete_port(access_.cycle());
  }
  cell = state_.answers[k].value;
  return Stepped::done;
}

void Engine::complete(bool write, Word value, Cycles arbitration, Cycles transfer) {
  if (dma_side_.request) return complete_dma(write, value, arbitration + transfer);
  access_.answer_window(write, value, arbitration, transfer);
}

void Engine::complete_port(Cycles at) {
  if (!access_.at_port()) throw std::logic_error("the chip waits for no communication port");
  const PortAccess& access = access_.port();
  CommPort& side = ports_[access.port];
  if (!access.ready(side))
    throw std::logic_error(fmt::format("communication port {}: the {} FIFO is {}", access.port,
                                       access.write ? "output" : "input", access.write ? "full" : "empty"));
  if (at < access.cycle) throw std::logic_error("an access cannot take place before it begins");
  peripherals_.end_dma_block(at);
  peripherals_.advance_to(at);
  const Word value = access.perform(side);
  access_.answer_port(value, at);
  ports_.accessed(access, value, at, -1);
}

void Engine::settle_answers() {
  for (Answer& answer : state_.answers) {
    if (!answer.given) continue;
    settle_answer({answer.value, answer.arbitration, answer.transfer}, answer.comm_port);
    answer = {};
  }
}

}  // namespace c40
