#pragma once
// What the files that bind the controller share.
#include "cmrc/configuration/timed_event.hpp"
#include "python/bindings/bindings.hpp"

/// An event from the fields of a row of [[events]]. \throws cmrc::ConfigError
cmrc::TimedEvent event_of(const py::dict& fields);

void bind_simulation(py::module_& m);
