#pragma once
// What the files that bind the controller share.
#include <memory>

#include "cmrc/configuration/rows/timed_event.hpp"
#include "python/bindings/bindings.hpp"
#include "report/events/event.hpp"

namespace cmrc {
struct Reference;
}
namespace plant {
class Dock;
}

/// An event from the fields of a row of [[events]]. \throws cmrc::ConfigError
cmrc::TimedEvent event_of(const py::dict& fields);

/// \param argument for the message \throws pybind11::value_error
report::Time to_time(const char* argument, double seconds);

/// The plant's time series, one array per signal, units in the names; where the ideal run is there (or null), each
/// joint's and the load's way in it too.
py::dict signals_of(const plant::Dock& dock, const std::shared_ptr<const cmrc::Reference>& reference);

void bind_simulation(py::module_& m);
void bind_run_snapshots(py::module_& m);
