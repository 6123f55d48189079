#pragma once
// One error (x = 1) of a run's report (docs/report.md, Errors handled).
#include <optional>
#include <string>
#include <vector>

#include "report/events/event.hpp"

namespace report {

struct HandledError {
  std::string origin;  ///< "following error", "drive fault", "drive time-out", "encoder", "sway sensor", "landing",
                       ///< "block given up"
  std::string robot;   ///< "crane", "agv 0"
  std::vector<std::string> of;   ///< joints, sway axes, or the kind of the block
  std::optional<Time> happened;  ///< if known: from the timed event, or from the plant
  std::string because;           ///< why it happened: "fail_drive luff", "drive_stopped"
  Time noticed{};
  std::optional<Time> decided;  ///< by an error block on a DSP
  std::string response;         ///< "stop", "hold", "set down", "retry", "second sensor"; empty: no DSP decided
  std::optional<Time> done;     ///< the response was carried out; empty: not before it was cleared, or by the end
  std::optional<Time> cleared;  ///< by the operator
  bool stands = false;          ///< at the end of the run the robot waits for the operator
  /// Distances of the load (for an AGV's error: of the AGV) from its place when the error happened or was noticed; from
  /// the plant, m.
  double moved_until_noticed_m = 0;
  std::optional<double> moved_until_done_m;
  double moved_most_m = 0;  ///< until it was cleared; without an operator until it was done; or until the end
};

/// Part of the report for a terminal; empty without errors.
std::string errors_text(const std::vector<HandledError>& errors);

}  // namespace report
