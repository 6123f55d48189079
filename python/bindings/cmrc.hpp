#pragma once
// What the files that bind the controller share.
#include "cmrc/configuration/timed_event.hpp"
#include "python/bindings/bindings.hpp"
#include "report/event.hpp"

/// An event from the fields of a row of [[events]]. \throws cmrc::ConfigError
cmrc::TimedEvent event_of(const py::dict& fields);

/// \param argument for the message \throws pybind11::value_error
report::Time to_time(const char* argument, double seconds);

void bind_simulation(py::module_& m);
