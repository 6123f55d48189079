// A DSP board's link to the adapter, and the board's start: from plugging in and reset to the running program.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "c40/peripherals/register_map.hpp"
#include "isa/types.hpp"
#include "machine/bus_agents/guard.hpp"
#include "machine/dsps/dsp.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

// ---- the link ----

// At the access's own turn: links and the adapter have executed everything before it.
void Dsp::begin_port_access(Time now, Time horizon) {
  for (const Wire& wire : wires_)
    if (wire.port == port_access_.port) wire.link.advance_to(now);
  if (!port_access_.ready(chip_.port(port_access_.port))) {
    own_next_ = never;
    return;
  }
  chip_.complete_port(std::max(port_access_.cycle, clock_.tick_at_or_after(now)));
  run(horizon);
}

// An access that waited for the link may be able to continue.
void Dsp::link_moved(Time now) {
  if (state_ == State::port && own_next_ == never && port_access_.ready(chip_.port(port_access_.port))) own_next_ = now;
  if (state_ == State::idle && chip_.watches_ports()) {
    settle(now);
    if (!chip_.dormant()) {
      state_ = State::running;
      own_next_ = clock_.at(chip_.cycle());
    }
  }
  set_next();
}

// Runs the DMA of a waiting processor, as far as its ports are known.
void Dsp::run_dma(Time horizon) {
  const c40::Cycles known = limit(horizon), before = chip_.settled();
  if (known > before) chip_.run_until(0, known);
  dma_waits_ = chip_.settled() == before;
}

void Dsp::link_event(const c40::LinkEvent& event) {
  const bool to_dsp = event.side == 0;
  if (event.kind == c40::LinkEvent::Kind::word) {
    ++(to_dsp ? statistics_.words_to_dsp : statistics_.words_from_dsp);
    if (!to_dsp && !std::exchange(answered_, true)) has_booted(event.time);
  } else if (event.kind == c40::LinkEvent::Kind::lost) {
    ++statistics_.words_lost;
    if (context_.observer != nullptr) context_.observer->link_lost(slot_, to_dsp, event.word, event.bytes, event.time);
  }
}

// ---- the slot, reset, boot ----

// Its accesses break off, and nothing on the way to it is kept for the program that follows.
void Dsp::leave_buses(Time now) {
  for (Side& side : sides_) side.bridge.clear(context_.bus_clocks[side.bus].tick_at_or_after(now));
  for (pci::BusBridge& bridge : context_.bridges) bridge.forget(slot_ + 1);
  if (context_.guard != nullptr) context_.guard->forget(slot_);
}

void Dsp::unplug(Time now) {
  if (state_ == State::out) return;
  leave_buses(now);
  stand_still(now);
  state_ = State::out;
  context_.adapter.reset(slot_, now);
  context_.adapter.set_plugged(slot_, false, now);
  edge_ = reset_ = never;
  context_.slot_changed(slot_, now);
  set_next();
  if (context_.observer != nullptr) context_.observer->slot(slot_, SlotChange::unplugged, now);
}

void Dsp::plug(Time now) {
  if (state_ != State::out) return;
  broken_ = false;
  state_ = State::dead;
  // The board has an oscillator of its own.
  if (clock_.hertz() != context_.chip_clocks[slot_].hertz()) pace(now, 1'000'000);
  context_.adapter.set_plugged(slot_, true, now);
  if (context_.observer != nullptr) context_.observer->slot(slot_, SlotChange::plugged, now);
  reset(now);
}

void Dsp::reset(Time now) {
  if (state_ == State::out || broken_) return;
  leave_buses(now);
  stand_still(now);
  hold_in_reset(now);
  edge_ = reset_ = never;
  set_next();
  if (context_.observer != nullptr) context_.observer->slot(slot_, SlotChange::reset, now);
}

// RESET is low for a while; this also resets the adapter's end of the link.
void Dsp::hold_in_reset(Time now) {
  chip_.hold(true);
  context_.in_reset += 1;
  state_ = State::booting;
  settle(now);
  context_.adapter.reset(slot_, now);
  if (context_.config.boot == Boot::link)
    chip_.boot();
  else
    chip_.reset();
  answered_ = false;
  context_.slot_changed(slot_, now);
  own_next_ = std::max(now, clock_.at(chip_.cycle())) + context_.config.reset_time;
}

void Dsp::leave_reset(Time now) {
  settle(now);
  context_.in_reset -= 1;
  if (context_.config.boot == Boot::preloaded) return load();
  chip_.hold(false);
  state_ = State::running;
  own_next_ = clock_.at(chip_.cycle());
  context_.adapter.request(slot_, now);
}

std::vector<std::pair<c40::Address, Word>> start_words(const Symbols& symbols, const Config& config, unsigned slot) {
  return {
      {symbols.dsp_slot, slot}, {symbols.idle_policy, config.idle_policy}, {symbols.pause_count, config.pause_count}};
}

// The state in which a loader would leave the chip (c40-hardware.md 9.4).
void Dsp::load() {
  for (const auto& section : context_.program.sections) {
    if (section.loaded) {
      chip_.write_block(section.address, section.words);
    } else {
      const std::vector<Word> zeros(section.size);
      chip_.write_block(section.address, zeros);
    }
  }
  for (const auto& [address, value] : start_words(context_.symbols, context_.config, slot_)) chip_.poke(address, value);
  chip_.set_register(isa::Register::AR3,
                     c40::register_named(fmt::format("PORT{}.control", context_.symbols.link_port)).address);
  chip_.set_pc(context_.symbols.start);
  chip_.hold(false);
  state_ = State::running;
  own_next_ = clock_.at(chip_.cycle());
  answered_ = true;
  has_booted(own_next_);
}

void Dsp::has_booted(Time now) {
  statistics_.boots += 1;
  context_.slot_changed(slot_, now);
  if (context_.observer != nullptr) context_.observer->slot(slot_, SlotChange::booted, now);
}

}  // namespace machine
