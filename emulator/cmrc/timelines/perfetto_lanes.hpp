#pragma once
// Slices whose ends are reported in no order, on as many tracks as needed so that none overlap.
#include <string>
#include <string_view>
#include <vector>

#include "report/events/perfetto_trace.hpp"

namespace cmrc {

/// A slice within another.
struct Inner {
  std::string_view name;
  report::Time from{};  ///< from here to the end of the outer slice
};

class PerfettoLanes {
 public:
  using Trace = report::PerfettoTrace;

  /// Its first track. \param name of this track and, with a number, of the others
  PerfettoLanes(Trace& trace, std::string name, Trace::Track parent, std::string_view description = {});
  void slice(report::Time from, report::Time to, std::string_view name, Trace::Notes notes = {},
             const Inner* inner = nullptr);

 private:
  Trace& trace_;
  std::string name_;
  Trace::Track parent_;
  struct Lane {
    Trace::Track track;
    report::Time until{};
  };
  std::vector<Lane> lanes_;
};

}  // namespace cmrc
