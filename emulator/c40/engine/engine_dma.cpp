// The DMA coprocessor beside the processor: how far it may advance, and why it stops the chip.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/chip/interrupts.hpp"
#include "c40/engine/engine.hpp"
#include "c40/peripherals/register_map.hpp"

namespace c40 {
namespace {

/// A DMA with the higher priority can keep the processor from its bus for 2^32 words: after this number of cycles,
/// run_until returns to its caller.
constexpr Cycles starved_cycles = 10'000;

}  // namespace

// How far the DMA may advance while the processor runs or idles: all that the processor does before this cycle is
// known. The links are known up to `limit` only.
Cycles Engine::known_until(Cycles limit, bool idles) const {
  const Cycles until = idles ? std::max(limit, state_.cycle) : state_.cycle - read_lead;
  return uses_linked_port() ? std::min(limit, until) : until;
}

// How far the DMA advances before the processor's access begins: what it does earlier comes first, however the run is
// cut.
Cycles Engine::known_before_access(Cycles limit) const {
  return uses_linked_port() ? std::min(limit, access_.cycle()) : access_.cycle();
}

bool Engine::uses_linked_port() const { return ports_.attached() != 0 && (dma_.ports_used() & ports_.attached()) != 0; }

// Lets the DMA follow the processor, or run on without it while the processor waits or idles; and the timers, each
// event in its turn. It stops where the DMA begins to use a linked port of which the caller does not know: the link may
// be behind. A stop with the reason `limit`: the processor did not get its bus for starved_cycles, and the DMA has not
// reached the cycle up to which it follows.
std::optional<StopInfo> Engine::run_dma(Cycles limit, bool processor_waits) {
  DmaSide& side = dma_side_;
  if (auto earlier = std::exchange(side.stop, std::nullopt)) return earlier;
  const Cycles began = state_.cycle;
  const auto moves = [&] { return dma_.busy() || dma_.ends(); };
  const bool moved = processor_waits && peripherals_.dma_active() && (moves() || peripherals_.has_dma_input());
  while (peripherals_.dma_active()) {
    if (!waits_in_idle() && state_.cycle > began + starved_cycles) return StopInfo{};
    if (side.request) return dma_stop(*side.request);
    const bool idles = !processor_waits && waits_in_idle();
    const Cycles until = processor_waits ? limit : known_until(limit, idles);
    const Cycles event = std::min(peripherals_.next_event(), peripherals_.next_dma_input()),
                 to = std::min(until, event);
    if (state_.dma.now >= until && !dma_.ends_at(until) && event > until) break;
    const bool rests = !moves();
    std::optional<DmaRequest> request;
    if (rests) {
      dma_.rest_until(to);
    } else {
      side.begin_following(!processor_waits && !idles);
      request = dma_.advance_to(to);
      side.end_following();
      peripherals_.watch_dma();
    }
    if (idles) pass(Cause::idle, std::min(to, state_.dma.now));
    if (rests && event > to) break;
    if (request) return dma_stop(*request);
    if (side.take_touched_link()) return stop(Stepped::horizon);
    if (dma_.stop_requested && watches_another_port()) return stop(Stepped::horizon);
    if (moved && !moves() && !peripherals_.has_dma_input() && event > dma_.last_done())
      break;  // at rest: how far the timers go beyond is decided by the caller, who knows whether anything else will
              // happen
    if (event > to || state_.dma.now < event) continue;
    peripherals_.advance_to(event);
    peripherals_.give_dma_inputs(event);
    if (watches_another_port()) return stop(Stepped::horizon);
  }
  return std::nullopt;
}

StopInfo Engine::dma_stop(const DmaRequest& request) {
  if (request.nothing_there) {
    const Memory::Area* area = memory_.find(request.address);
    const std::string access =
        fmt::format("DMA channel {}: {}", request.channel, request.write ? "write to" : "read of");
    if (area == nullptr)
      nothing_at(access, request.address);
    else
      fail(Fault::Kind::not_modelled,
           fmt::format("{} {:08X}h, which is {}", access, request.address, describe_register(request.address)),
           request.address);
    fault_->cycle = request.cycle;  // the processor may be ahead of this cycle, or may have waited for long
    return stop(Stepped::fault);
  }
  dma_side_.request = request;
  peripherals_.advance_to(state_.cycle);  // as at the end of a run: the answer may be late
  StopInfo info;
  info.reason = StopInfo::Reason::external_access;
  info.access = {request.address, request.write, false, request.value, request.cycle, request.channel};
  return info;
}

void Engine::complete_dma(bool write, Word value, Cycles waited) {
  if (dma_side_.request->write != write)
    throw std::logic_error(fmt::format("the DMA does not wait for a {}", write ? "write" : "read"));
  const Address address = dma_side_.request->address;
  const Word word = write ? dma_side_.request->value : value;
  const int channel = std::exchange(dma_side_.request, std::nullopt)->channel;
  access_.set_reported(false);  // it begins before the DMA continues
  state_.dma.answered_until = state_.dma.now + waited;
  dma_side_.tell_probe(channel, address, word, word, write, state_.dma.answered_until - 1);
  dma_.answer(value, state_.dma.answered_until);
  peripherals_.watch_dma();
}

}  // namespace c40
