#pragma once
// The buses of a run in its Perfetto trace: the clocks of each master in each millisecond and, on request, every
// attempt.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus_model/bus.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/machine.hpp"
#include "report/events/perfetto_trace.hpp"
#include "report/events/trace_text.hpp"

namespace cmrc {

class PerfettoBuses {
 public:
  using Trace = report::PerfettoTrace;

  PerfettoBuses(Trace& trace, const machine::Machine& machine, bool each, report::Window window);
  /// \param ended false: at the end of the run the attempt is under way, and this is what has been of it
  void on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock, bool ended);
  void finish();

 private:
  struct Master {
    Trace::Track track;
    std::string name;
    std::int64_t clocks = 0;  // in the present millisecond
    std::int64_t written = 0;
  };
  struct Bus {
    std::int64_t millisecond = 0;
    std::vector<Master> masters;
    std::vector<std::string> targets;
    std::optional<Trace::Track> slices;
  };

  void tell(Bus& bus, std::int64_t millisecond);
  void slice(const Bus& bus, const pci::Attempt& attempt, report::Time from, report::Time to, bool ended);

  Trace& trace_;
  const report::Window window_;
  std::vector<Bus> buses_;
};

}  // namespace cmrc
