#pragma once
// The same run with instant execution: the difference is the cost of missed deadlines and delays (docs/report.md,
// Ideal).
//
// It runs the same programs with the same bits, so its arithmetic is the controller's own; only time is removed: one
// DSP is ideal_speed times as fast (a board's clock counts as 40 MHz at least), an access through a bus takes no time,
// and the host works in no time. Every block ends within microseconds of its release, well before the next latch of the
// drives. Failures of the machine do not happen here; the operator's changes, and failures of drives and sensors, do.
#include "cmrc/configuration/config.hpp"

namespace cmrc {

/// The configuration of a run with run.ideal; unchanged if run.ideal is not set.
Config as_run(const Config& config);

/// Whether the event happens in a run of the configuration: in an ideal run none of the machine's does.
bool happens(const TimedEvent& event, const Config& config);

/// The same run, with run.ideal set.
Config ideal(Config config);

}  // namespace cmrc
