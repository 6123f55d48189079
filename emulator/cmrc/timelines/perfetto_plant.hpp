#pragma once
// The plant's signals in the Perfetto trace of a run: counters of joints, sway, load and vehicles, fifty times per
// second.
#include <limits>
#include <vector>

#include "plant/dock/dock.hpp"
#include "report/events/perfetto_trace.hpp"
#include "report/events/trace_text.hpp"

namespace cmrc {

class PerfettoPlant {
 public:
  using Trace = report::PerfettoTrace;

  PerfettoPlant(Trace& trace, const plant::Dock& dock, report::Window window);
  /// Reads the dock's state at its last latch.
  void latched(const plant::Dock& dock, report::Time now);

 private:
  struct Signal {
    Trace::Track track;
    double written = std::numeric_limits<double>::quiet_NaN();
  };
  void tell(double value, report::Time now);

  Trace& trace_;
  const report::Window window_;
  std::vector<Signal> signals_;
  std::size_t next_ = 0;  // index of the next signal
};

}  // namespace cmrc
