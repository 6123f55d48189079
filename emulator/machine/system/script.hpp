#pragma once
// The machine's script: its events by time, as an actor of the scheduler.
#include <deque>
#include <functional>
#include <vector>

#include "machine/system/scripted_events.hpp"
#include "machine/time/scheduler.hpp"

namespace pci {
class Bus;
}
namespace plant {
class Dock;
}

namespace machine {

class Dsp;
class HostBoard;
class LinkAdapter;
class SharedRegisters;
struct Fence;

/// The objects of scripted events.
struct Stage {
  std::deque<Dsp>& dsps;
  SharedRegisters& registers;
  Fence& fence;
  LinkAdapter& adapter;
  HostBoard* host;  ///< may be null
  std::deque<pci::Bus>& buses;
  const std::vector<Clock>& bus_clocks;
  plant::Dock* dock;  ///< may be null
};

class Script final : public Scheduler::Actor {
 public:
  using Act = std::function<void(const ScriptedEvent&, Time now)>;
  /// \param events by time; future ones are kept there too
  Script(std::vector<ScriptedEvent>& events, Act act) : events_{events}, act_{std::move(act)} {}

  Time next() const override { return done < events_.size() ? events_[done].time : never; }
  void act(Time now) override;
  /// Added after the events of the same time.
  void add(const ScriptedEvent& event);

  std::size_t done = 0;  ///< number of events that have happened

 private:
  std::vector<ScriptedEvent>& events_;
  Act act_;
};

}  // namespace machine
