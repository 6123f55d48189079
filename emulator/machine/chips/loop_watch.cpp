#include "machine/chips/loop_watch.hpp"

#include <algorithm>

#include "c40/chip/state.hpp"
#include "c40/peripherals/register_map.hpp"
#include "isa/types.hpp"

namespace machine {
namespace {

constexpr std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9E3779B97F4A7C15u;
  return hash ^ hash >> 29;
}

bool has_effect(const c40::MemoryEvent& event) {
  if (c40::register_at(event.address) == nullptr) return false;
  return event.write || (c40::is_port_register(event.address) &&
                         c40::port_access(event.address, false, 0, 0).reg == c40::PortRegister::input);
}

}  // namespace

void LoopWatch::instruction(const c40::TraceRecord& record) {
  if (next_ != nullptr) next_->instruction(record);
  const c40::Core& core = chip_->state().core;
  Round& round = rounds_.emplace_back();
  round.pc = record.pc;
  round.hash = mixed(mixed(record.pc, record.word), core.repeat_single);
  for (const c40::RegisterChange& change : record.registers)
    round.hash = mixed(mixed(round.hash, isa::code(change.reg)), change.value);
  for (const c40::MemoryEvent& event : record.memory) {
    round.hash = mixed(mixed(mixed(round.hash, event.address), event.value), event.write);
    if (!event.write) round.reads.push_back(event.address);
    round.has_effect |= has_effect(event);
  }
}

void LoopWatch::interrupt(const c40::InterruptRecord& record) {
  if (next_ != nullptr) next_->interrupt(record);
  rounds_.clear();
}

std::optional<LoopWatch::Loop> LoopWatch::loop() const {
  const auto same = [](const Round& a, const Round& b) { return a.hash == b.hash; };
  for (std::size_t length = 1; 2 * length <= rounds_.size(); ++length) {
    const auto end = rounds_.end();
    const auto size = static_cast<std::ptrdiff_t>(length);
    if (!std::equal(end - size, end, end - 2 * size, same)) continue;
    Loop loop{rounds_.back().pc, {}};
    for (auto round = end - size; round != end; ++round) {
      if (round->has_effect) return std::nullopt;
      loop.pc = std::min(loop.pc, round->pc);
      loop.reads.insert(round->reads.begin(), round->reads.end());
    }
    return loop;
  }
  return std::nullopt;
}

}  // namespace machine
