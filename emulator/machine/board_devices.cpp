#include "machine/board_devices.hpp"

#include <array>
#include <utility>

namespace machine {
namespace {

using c40::Address;
using c40::Word;

constexpr std::array<std::pair<DeviceKind, std::string_view>, 3> names{
    {{DeviceKind::console, "console"}, {DeviceKind::registers, "registers"}, {DeviceKind::led, "led"}}};
constexpr Word has_come = 1, can_be_sent = 2;
constexpr Address status = 1;

}  // namespace

std::string_view name(DeviceKind kind) { return names[static_cast<std::size_t>(kind)].second; }

std::optional<DeviceKind> device_kind_named(std::string_view text) {
  for (const auto& [kind, called] : names)
    if (called == text) return kind;
  return std::nullopt;
}

BoardDevices::BoardDevices(const std::vector<DeviceDescription>& described) {
  for (const DeviceDescription& device : described)
    devices_.push_back({device, std::vector<Word>(device.words, device.value)});
}

Word BoardDevices::read(Device& device, Address offset) {
  if (device.described.kind != DeviceKind::console) return device.words[offset];
  const bool comes = taken_ < input_.size();
  if (offset == status) return can_be_sent | (comes ? has_come : 0);
  return comes ? static_cast<unsigned char>(input_[taken_++]) : 0;
}

void BoardDevices::write(Device& device, Address offset, Word value, c40::Cycles cycle) {
  if (device.described.kind == DeviceKind::console) {
    if (offset != status && on_output) on_output(static_cast<char>(value & 0xFF));
    return;
  }
  const Word before = std::exchange(device.words[offset], value);
  if (device.described.kind == DeviceKind::led && before != value && on_change)
    on_change({device.described.name, cycle, value});
}

std::optional<BoardDevices::Answer> BoardDevices::access(const c40::ExternalAccess& access) {
  for (Device& device : devices_) {
    const Address offset = access.address - device.described.base;
    if (offset >= device.described.words) continue;
    if (access.write) write(device, offset, access.value, access.cycle);
    return Answer{access.write ? 0 : read(device, offset), device.described.waits};
  }
  return std::nullopt;
}

void BoardDevices::list_state(state::Visitor& list) {
  list("devices", devices_);
  list("input", input_);
  list("taken", taken_);
}

bool serve(BoardDevices& devices, c40::Chip& chip, const c40::ExternalAccess& access) {
  const auto answer = devices.access(access);
  if (!answer) return false;
  if (access.write)
    chip.complete_write(0, answer->waits);
  else
    chip.complete_read(answer->value, 0, answer->waits);
  return true;
}

}  // namespace machine
