#pragma once
// The host board: a HostProgram behind a bridge to each of the board's buses.
#include <cstdint>
#include <deque>
#include <vector>

#include "bus_model/bridge.hpp"
#include "machine/bus_agents/shared_memory.hpp"
#include "machine/dsps/link_adapter.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/host_program.hpp"
#include "machine/system/machine_config.hpp"
#include "machine/time/scheduler.hpp"
#include "machine/time/time.hpp"

namespace machine {

class HostBoard final : public Scheduler::Actor, public HostPort, public pci::Bridge::Client {
 public:
  /// Becomes the first master of its buses. `ways`: routes of offsets in HostPort's numbering.
  HostBoard(HostProgram& program, const Config& config, std::deque<pci::Bus>& buses,
            const std::vector<BusRoute>& routes, std::vector<Clock> bus_clocks, const SharedRegisters& registers,
            const LinkAdapter& adapter);

  Time next() const override { return next_; }
  void boot_requested(Time now) {
    program_.boot_requested(now);
    set_next(now);
  }
  void act(Time now) override;

  /// The processor is stopped until then; posted writes continue.
  void pause(Time until);

  void list_state(state::Visitor& list);

  /// No write that the host has posted or will post can act on a DSP before this (a lower bound, never before `now`).
  /// The host may be woken at `woken`.
  Time earliest_action(Time woken) const;

  void read(Offset offset, unsigned n_words, std::uint32_t tag) override;
  void write(Offset offset, std::span<const Word> words) override;
  using HostPort::write;
  bool reading() const override { return words_wanted_ != 0; }
  std::size_t pending_writes() const override {
    std::size_t words = waiting_.size() - first_waiting_;
    for (const pci::Bridge& bridge : bridges_) words += bridge.posted() + bridge.blocked_write();
    return words;
  }

 private:
  void answered(Word value, pci::Clocks ready, pci::Clocks arbitration, pci::Result result) override;
  void taken(pci::Clocks ready, pci::Clocks arbitration) override;
  void landed(const pci::Posted&, pci::Clocks, pci::Result) override {}
  // Nearly always the words are in shared memory, on the first path; every machine has a path there.
  void require_answer(Offset offset, std::size_t words, bool write) const {
    const BusRoute& first = paths_.front().route;
    if (offset < first.first || offset + words > std::min<std::size_t>(first.end, SharedSram::size))
      require_answers(offset, words, write);
  }
  void require_answers(Offset offset, std::size_t words, bool write) const;
  /// A route, the bridge that leads there, the clock of the bridge's bus, and with instant access the target that was
  /// reached last.
  struct Path {
    BusRoute route;
    pci::Bridge& bridge;
    const Clock& clock;
    pci::DirectWindow target{};
  };
  Path* path_of(Offset offset) {
    for (Path& path : paths_)
      if (path.route.holds(offset)) return &path;
    return nullptr;
  }
  bool blocked() const;
  Time next_bus_event() const;
  // The first clock of the host at or after a path's clock, and the reverse. Port 0 is on the bus whose clock is the
  // host's.
  pci::Clocks own_clock(const Path& path, pci::Clocks clock) const {
    return path.route.port == 0 ? clock : clock_.tick_at_or_after(path.clock.at(clock));
  }
  pci::Clocks bus_clock(const Path& path, pci::Clocks own) const {
    return path.route.port == 0 ? own : path.clock.tick_at_or_after(clock_.at(own));
  }
  Path& path_to_write(Offset offset);
  // Passes a word to its bridge. False: the bridge has no room, and the board waits.
  bool post(Path& path, Offset offset, Word value) {
    cpu_ += config_.host_write_clocks;
    if (config_.instant_access && access_instantly(path, offset, true, value)) return true;
    path.bridge.write({.address = offset + path.route.shift, .value = value, .clock = bus_clock(path, cpu_)});
    return !path.bridge.blocked();
  }
  bool access_instantly(Path& path, Offset offset, bool write, Word& value);
  void ask();
  void take(const Path& path, Word value, pci::Clocks ready);
  void feed();
  void set_next(Time now);

  HostProgram& program_;
  const Config& config_;
  std::deque<pci::Bus>& buses_;
  std::vector<Clock> clocks_;  // by bus
  Clock clock_;                // of the host's first bus: the host counts in this clock
  const SharedRegisters& registers_;
  const LinkAdapter& adapter_;
  std::deque<pci::Bridge> bridges_;  // by the host's buses
  std::vector<Path> paths_;
  Time next_ = never;
  Time read_done_ = never;
  Time paused_until_{0};
  unsigned written_ = 0;              // the number of the last write's path
  pci::Clocks cpu_ = 0;               // the processor issues its next access at this clock or later
  std::vector<pci::Posted> waiting_;  // writes that found the FIFO full
  std::size_t first_waiting_ = 0;
  std::uint64_t acting_ = 0;  // words posted so far that act on a DSP on arrival
  std::uint32_t tag_ = 0;
  Offset read_offset_ = 0;
  unsigned words_wanted_ = 0;
  std::vector<Word> words_read_;
  Time action_time_;  // from the host's own event to the effect of its write on a DSP
};

}  // namespace machine
