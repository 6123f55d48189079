// What of an engine lasts, and what is made anew from it.
#include <algorithm>

#include "c40/engine.hpp"
#include "c40/engine_dma.hpp"

namespace c40 {

void Engine::DmaSide::list_state(state::Visitor& list) {
  // Who looks before the next access is asked for may meet accesses that are over.
  std::erase_if(accesses, [&](const ProcessorAccess& access) { return !knows_accesses || access.end < engine.state_.dma.now; });
  list("accesses", accesses);
  list("knows accesses", knows_accesses);
  list("taken until", taken_until);
  list("written", written);
  list("last taken", last_taken);
  list("gained", gained);
  std::optional<Pipeline> alone = undisturbed ? std::optional(engine.pipelines_[*undisturbed]) : std::nullopt;
  list("undisturbed", alone);
  if (list.loads()) undisturbed = alone ? std::optional(engine.intern(*alone)) : std::nullopt;
}

// Not listed: blocks, sites, transitions and pipelines by number, which are recorded again; what is set anew at each call of the
// engine or for each instruction; breakpoints and listeners, which are their owners'.
void Engine::list_state(state::Visitor& list) {
  if (list.loads()) {
    flush_blocks();
    state_.cache.each_word([this](Address pc) {
      if (const Memory::Area* area = memory_.find(pc); area != nullptr && area->data != nullptr) area->unmark_code(pc);
    });
    touch();
  }
  settle_counts();
  for (Timer& timer : state_.timers)  // it is computed when somebody looks: as of now
    if (state_.cycle < timer.next_event()) timer.advance_to(state_.cycle);
  visit_state(state_, list);
  list("memory", memory_);
  Cycles since = idle_since();
  list("idle since", since);
  list("waiting access", waiting_access_);
  list("waiting", waiting_);
  list("port slot", port_slot_);
  list("port access", port_access_);
  list("held", held_);
  list("told", told_);
  list("fault", fault_);
  list("reported breakpoint", reported_breakpoint_);
  list("DMA's stop", dma_stop_);
  list("DMA's request", dma_request_);
  if (list.loads()) {
    idle_since_ = since;
    idle_until_ = state_.cycle;
    state_.core.code_writes = 0;
    state_.core.attention = true;
    interface_changed_ = false;
    forget_memory();
    flush_blocks();
    ++cache_version_;
    stale_code_ = false;
    state_.cache.each_word([this](Address pc) {
      const Memory::Area* area = std::as_const(memory_).find(pc);
      stale_code_ |= area != nullptr && area->data != nullptr && area->data[pc - area->base] != *state_.cache.find(pc);
    });
    expect_peripherals();
    watch_dma();
  }
  list("DMA's side", *dma_side_);
}

}  // namespace c40
