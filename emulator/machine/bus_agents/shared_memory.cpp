#include "machine/bus_agents/shared_memory.hpp"

#include <stdexcept>

#include "machine/bus_agents/guard.hpp"

namespace machine {

namespace {

constexpr unsigned owner_of(unsigned agent) { return is_host(agent) ? host_owner : agent; }

}  // namespace

void SharedSram::write(pci::Address offset, Word value, const pci::Access& access) {
  if (!is_host(access.agent)) return write_of_dsp(offset, value, access);
  store(offset, value, access);
}

void SharedSram::write_of_dsp(pci::Address offset, Word value, const pci::Access& access) {
  const unsigned slot = access.agent - 1;
  if (fence_.closed(slot)) return;
  if (guard_ == nullptr ||
      guard_->admits(slot, offset, value, registers_->holder(guard_->list_semaphore()) == slot + 1))
    store(offset, value, access);
}

void SharedSram::store_watched(Offset offset, Word value, const pci::Access& access) {
  watch_(offset, words_[offset], value, true, access);
  words_[offset] = value;
}

SharedRegisters::SharedRegisters(const Symbols& symbols, unsigned slots, Clock bus_clock, Fence& fence,
                                 DoorbellClient& client)
    : symbols_{symbols}, slots_{slots}, clock_{bus_clock}, fence_{fence}, client_{client} {
  if (symbols_.semaphore_count > most_semaphores)
    throw std::invalid_argument{"the DSP program: SEMAPHORE_COUNT is at most 64"};
  for (const Offset offset :
       {symbols_.semaphore, symbols_.semaphore_owner, symbols_.semaphore_held, symbols_.doorbell_ring,
        symbols_.doorbell_idle, symbols_.doorbell_busy, symbols_.fence_mask, symbols_.reset_dsp})
    if (offset - base >= size)
      throw std::invalid_argument{
          "the DSP program: registers of the shared memory lie at offsets 10000h to 10FFFh of bus A"};
}

bool SharedRegisters::answers(Offset offset, bool write, bool by_host) const {
  const auto within = [&](Offset first) { return offset - first < symbols_.semaphore_count; };
  if (within(symbols_.semaphore)) return true;
  if (within(symbols_.semaphore_owner) || within(symbols_.semaphore_held)) return !write;
  if (offset == symbols_.doorbell_idle) return true;
  if (offset == symbols_.doorbell_busy) return write;
  if (offset == symbols_.fence_mask) return !write || by_host;
  if (offset == symbols_.doorbell_ring || offset == symbols_.reset_dsp) return write && by_host;
  return false;
}

pci::Answer SharedRegisters::answer(pci::Address offset, unsigned, bool write, const pci::Access& access) {
  return answers(base + offset, write, is_host(access.agent)) ? pci::Answer::accept : pci::Answer::abort;
}

// The host also gets, in one step, a semaphore held by a fenced DSP: if the semaphore were freed first, a polling DSP
// could take it in between.
Word SharedRegisters::acquire(unsigned number, const pci::Access& access) {
  const unsigned owner = owner_of(access.agent);
  Semaphore& semaphore = semaphores_[number];
  const bool fenced = !is_host(access.agent) && fence_.closed(access.agent - 1);
  const bool orphaned =
      is_host(access.agent) && semaphore.owner != 0 && semaphore.owner != owner && fence_.closed(semaphore.owner - 1U);
  if ((semaphore.owner != 0 && !orphaned) || fenced) {
    client_.semaphore_event(number, SemaphoreEvent::refused, owner, access.clock);
    return 1;
  }
  semaphore.owner = static_cast<std::uint8_t>(owner);
  semaphore.since = access.clock;
  client_.semaphore_event(number, SemaphoreEvent::acquired, owner, access.clock);
  return 0;
}

// By its owner, or by the host: a DSP that wakes late must not release what another DSP has acquired since.
void SharedRegisters::release(unsigned number, const pci::Access& access) {
  if (!is_host(access.agent) && semaphores_[number].owner != owner_of(access.agent)) return;
  semaphores_[number] = {};
  client_.semaphore_event(number, SemaphoreEvent::released, owner_of(access.agent), access.clock);
}

Word SharedRegisters::microseconds_held(const Semaphore& semaphore, pci::Clocks now) const {
  if (semaphore.owner == 0) return 0;
  return static_cast<Word>((clock_.at(now) - clock_.at(semaphore.since)).count() / 1'000'000);
}

Word SharedRegisters::read(pci::Address offset, const pci::Access& access) {
  const Offset bus_offset = base + offset;
  const Word count = symbols_.semaphore_count;
  if (const Word n = bus_offset - symbols_.semaphore; n < count) return acquire(n, access);
  if (const Word n = bus_offset - symbols_.semaphore_owner; n < count) return semaphores_[n].owner;
  if (const Word n = bus_offset - symbols_.semaphore_held; n < count)
    return microseconds_held(semaphores_[n], access.clock);
  return bus_offset == symbols_.doorbell_idle ? idle_ : fence_.mask;
}

void SharedRegisters::write(pci::Address offset, Word value, const pci::Access& access) {
  const Offset bus_offset = base + offset;
  if (!is_host(access.agent) && fence_.closed(access.agent - 1)) return;
  acted_ += acts_on_dsps(bus_offset);
  const Word bit = value < 32 ? Word{1} << value : 0;
  if (const Word n = bus_offset - symbols_.semaphore; n < symbols_.semaphore_count) {
    release(n, access);
  } else if (bus_offset == symbols_.doorbell_idle) {
    idle_ |= bit;
  } else if (bus_offset == symbols_.doorbell_busy) {
    idle_ &= ~bit;
  } else if (bus_offset == symbols_.fence_mask) {
    fence_.mask = value;
  } else if (value < slots_) {
    if (bus_offset == symbols_.doorbell_ring) {
      idle_ &= ~bit;
      client_.ring(value, access.clock);
    } else {
      client_.reset_slot(value, access.clock);
    }
  }
}

void SharedRegisters::append_state(std::vector<std::uint64_t>& words) const {
  for (unsigned n = 0; n < symbols_.semaphore_count; ++n) {
    words.push_back(semaphores_[n].owner);
    words.push_back(static_cast<std::uint64_t>(semaphores_[n].since));
  }
  words.push_back(idle_);
  words.push_back(fence_.mask);
}

}  // namespace machine
