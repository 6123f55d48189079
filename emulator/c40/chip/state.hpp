#pragma once
/// The state of a chip that its program or its peripherals can distinguish. Memory contents are in Memory. The engine
/// lists its further state between two calls itself (chip_state.cpp).
#include "c40/memory/cache.hpp"
#include "c40/memory/memory.hpp"
#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/dma.hpp"
#include "c40/peripherals/pins.hpp"
#include "c40/peripherals/timer.hpp"
#include "c40/pipeline/timing.hpp"
#include "c40/values/core.hpp"

namespace c40 {

/// The machine's answer to an external access of the waiting instruction.
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
  /// Changes of CE, CF and CC by instructions; each is kept until the first fetch after its execute stage.
  /// `cache_changes` is their number.
  struct CacheChange {
    Cycles executed = 0;
    Word control = 0;
    bool clear = false;
    friend bool operator==(const CacheChange&, const CacheChange&) = default;
  };
  std::array<CacheChange, 4> cache_change{};
  std::size_t cache_changes = 0;
  bool cache_clear = false;  ///< the present instruction has written CC
  Memory::OpenPages open_pages;
  std::array<bool, 2> locked{};  ///< LLOCK, LOCK are low: an interlocked access keeps the local, the global bus.
  std::array<CommPort, port_count> ports{};
  std::array<Timer, timer_count> timers{};
  DmaState dma;
  bool stalled_on_port = false;  ///< The instruction at PC has begun an access for which a FIFO is not ready yet.
  std::uint8_t iiof_levels = 0;  ///< Bit n: IIOFn is held active, which is low.
  std::uint8_t iiof_driven =
      0;  ///< Bit n: the outside has driven IIOFn; the board's tied level does not count any more.
  bool nmi_low = false;
  std::array<Drive, pin_count> drives{};  ///< of watched outputs, as last reported
  Cycles drives_reported = 0;             ///< up to this cycle
  bool held = false;                      ///< In reset.
  bool faulted = false;

  void list_state(state::Visitor& list);
};

}  // namespace c40
