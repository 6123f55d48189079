#pragma once
/// The whole state of a chip, in one place: what a snapshot holds and what a comparison compares. Memory contents are apart
/// (Memory); everything else a chip has is derived from these.
#include <string_view>

#include "c40/cache.hpp"
#include "c40/memory.hpp"
#include "c40/op.hpp"
#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/dma.hpp"
#include "c40/peripherals/timer.hpp"

namespace c40 {

/// The machine's answer to an external access of the instruction that waits for it.
struct Answer {
  bool given = false;
  bool write = false;
  Address address = 0;
  Word value = 0;
  Cycles arbitration = 0, transfer = 0, comm_port = 0;
  Cycles waited() const { return arbitration + transfer + comm_port; }
};

struct State {
  Core core;
  Pipeline pipeline;
  Cycles cycle = 0;
  std::uint64_t instructions = 0;
  Causes causes{};
  std::array<Answer, 2> answers{};  ///< By access of the instruction at PC.
  Word global_interface_control = 0, local_interface_control = 0;
  Cache cache;
  Word cache_control = 0;  ///< CE and CF, as the fetch stage sees them
  /// What instructions have done to CE, CF and CC, each until the first fetch after its execute stage; `cache_changes` of them.
  struct CacheChange {
    Cycles executed = 0;
    Word control = 0;
    bool clear = false;
    friend bool operator==(const CacheChange&, const CacheChange&) = default;
  };
  std::array<CacheChange, 4> cache_change{};
  std::size_t cache_changes = 0;
  bool cache_clear = false;  ///< the instruction under way has written CC
  Memory::OpenPages open_pages;
  std::array<bool, 2> locked{};  ///< LLOCK, LOCK are low: the local, the global bus is kept by an interlocked access.
  std::array<CommPort, port_count> ports{};
  std::array<Timer, timer_count> timers{};
  DmaState dma;
  bool stalled_on_port = false;  ///< The instruction at PC has begun an access that a FIFO does not answer yet.
  std::uint8_t iiof_levels = 0;  ///< Bit n: IIOFn is held active.
  bool held = false;             ///< In reset.
  bool faulted = false;
};

/// Calls visit(name, field) for every field of the state; the only list of them.
template <class S, class Visit>
void visit_state(S& s, Visit&& visit) {
  auto& c = s.core;
  visit(std::string_view{"registers"}, c.r);
  visit(std::string_view{"exponents"}, c.e);
  visit(std::string_view{"negative"}, c.negative);
  visit(std::string_view{"zero"}, c.zero);
  visit(std::string_view{"carry"}, c.carry);
  visit(std::string_view{"range"}, c.range);
  visit(std::string_view{"sticky"}, c.sticky);
  visit(std::string_view{"modes"}, c.modes);
  visit(std::string_view{"pc"}, c.pc);
  visit(std::string_view{"delay_target"}, c.delay_target);
  visit(std::string_view{"delay_slots"}, c.delay_slots);
  visit(std::string_view{"delay_taken"}, c.delay_taken);
  visit(std::string_view{"delay_repeat"}, c.delay_repeat);
  visit(std::string_view{"annul"}, c.annul);
  visit(std::string_view{"idle"}, c.idle);
  visit(std::string_view{"repeat_single"}, c.repeat_single);
  visit(std::string_view{"ivtp"}, c.ivtp);
  visit(std::string_view{"tvtp"}, c.tvtp);
  visit(std::string_view{"pipeline"}, s.pipeline);
  visit(std::string_view{"cycle"}, s.cycle);
  visit(std::string_view{"instructions"}, s.instructions);
  visit(std::string_view{"causes"}, s.causes);
  visit(std::string_view{"answers"}, s.answers);
  visit(std::string_view{"global_interface_control"}, s.global_interface_control);
  visit(std::string_view{"local_interface_control"}, s.local_interface_control);
  visit(std::string_view{"cache"}, s.cache);
  visit(std::string_view{"cache_control"}, s.cache_control);
  visit(std::string_view{"cache_change"}, s.cache_change);
  visit(std::string_view{"cache_changes"}, s.cache_changes);
  visit(std::string_view{"open_pages"}, s.open_pages);
  visit(std::string_view{"locked"}, s.locked);
  visit(std::string_view{"ports"}, s.ports);
  visit(std::string_view{"timers"}, s.timers);
  visit(std::string_view{"dma"}, s.dma);
  visit(std::string_view{"stalled_on_port"}, s.stalled_on_port);
  visit(std::string_view{"iiof_levels"}, s.iiof_levels);
  visit(std::string_view{"held"}, s.held);
  visit(std::string_view{"faulted"}, s.faulted);
}

}  // namespace c40
