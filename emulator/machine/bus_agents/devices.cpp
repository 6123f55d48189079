#include "machine/bus_agents/devices.hpp"

#include <stdexcept>
#include <string>

#include "machine/system/shared_numbers.hpp"

namespace machine {

Devices::Devices(const toolchain::Image& program, plant::Dock& dock, const std::array<Clock, device_groups>& clocks,
                 const Fence& fence)
    : clocks_{clocks}, fence_{fence}, cards_{dock, program} {
  if (const auto wrong = contradiction(program)) throw std::invalid_argument{"the DSP program: " + *wrong};
  for (const PlacedRegister& one : placed_registers(cards_, program)) define(one);
}

void Devices::define(const PlacedRegister& one) {
  if (one.offset > 0xFFFF || one.index > 255 || one.ray > 255)
    throw std::invalid_argument{"the DSP program: devices on bus B have offsets 0 to FFFFh"};
  if (one.offset >= registers_.size()) registers_.resize(one.offset + 1);
  if (registers_[one.offset].row != none)
    throw std::invalid_argument{"the DSP program: two devices share offset " + std::to_string(one.offset) +
                                " of bus B"};
  registers_[one.offset] = {static_cast<std::uint8_t>(one.row - rows_.data()),
                            {static_cast<std::uint8_t>(one.index), static_cast<std::uint8_t>(one.ray)}};
}

pci::Answer Devices::answer(pci::Address offset, unsigned words, bool write, const pci::Access&) {
  for (unsigned i = 0; i < words; ++i)
    if (!answers(offset + i, write)) return pci::Answer::abort;
  return pci::Answer::accept;
}

Word Devices::read(pci::Address offset, const pci::Access& access) {
  const Register& one = registers_[offset];
  const DeviceRegister& row = row_of(one);
  return row.read(cards_, one.place, instant(row, access));
}

void Devices::write(pci::Address offset, Word value, const pci::Access& access) {
  if (!is_host(access.agent) && fence_.closed(access.agent - 1)) return;
  const Register& one = registers_[offset];
  const DeviceRegister& row = row_of(one);
  row.write(cards_, one.place, value, instant(row, access));
}

std::vector<Devices::RegisterRange> Devices::ranges() const {
  std::vector<RegisterRange> all;
  for (Offset offset = 0; offset < size(); ++offset) {
    const Register& one = registers_[offset];
    const bool there = one.row != none;
    if (all.empty()) all.push_back({there ? row_of(one).group : DeviceGroup::drives, offset, offset});
    if (there && row_of(one).group != all.back().group) all.push_back({row_of(one).group, offset, offset});
    all.back().end = offset + 1;
  }
  return all;
}

void Devices::append_state(std::vector<std::uint64_t>& words) const {
  for (const DeviceConnections::AgvCommand& command : cards_.commands) {
    words.push_back(static_cast<std::uint32_t>(command.speed));
    words.push_back(static_cast<std::uint32_t>(command.front));
  }
}

}  // namespace machine
