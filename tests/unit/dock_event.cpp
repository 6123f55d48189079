// What an event of the dock says: names of joints, vehicles and containers instead of their numbers.
#include "plant/dock/dock_event.hpp"

#include <doctest/doctest.h>

#include <string>

namespace {

using plant::CraneKind;
using plant::EventKind;

std::string said(EventKind kind, int index, std::array<double, 2> values, CraneKind crane = CraneKind::slewing) {
  const plant::Event event{plant::Time{0}, kind, index, values};
  return std::string(plant::name(kind)) + " | " + plant::object_of(event, crane) + " | " + plant::values_of(event);
}

}  // namespace

TEST_CASE("every kind of event of the dock names its object and its values") {
  CHECK(said(EventKind::near_contact, -1, {0.5, 1250.4}) == "near_contact |  | clearance 0.5 m, energy jump 1250 J");
  CHECK(said(EventKind::free_again, -1, {0.6, -3}) == "free_again |  | clearance 0.6 m, energy jump -3 J");
  CHECK(said(EventKind::touch, -1, {0.1, 0.02}) == "touch |  | vertical speed 0.1 m/s, horizontal speed 0.02 m/s");
  CHECK(said(EventKind::hard_landing, -1, {1, 0}) == "hard_landing |  | vertical speed 1 m/s, horizontal speed 0 m/s");
  CHECK(said(EventKind::landed, -1, {}) == "landed |  | ");
  CHECK(said(EventKind::lifted, -1, {}) == "lifted |  | ");
  CHECK(said(EventKind::locked, 3, {}) == "locked | container 3 | ");
  CHECK(said(EventKind::locked, -1, {}) == "locked |  | ");
  CHECK(said(EventKind::opened, 0, {}) == "opened | container 0 | ");
  CHECK(said(EventKind::refused, -1, {}) == "refused |  | ");
  CHECK(said(EventKind::set_on_agv, 3, {1, 0}) == "set_on_agv | container 3 | AGV 1");
  CHECK(said(EventKind::agv_dry, 2, {}) == "agv_dry | AGV 2 | ");
  CHECK(said(EventKind::agv_overflow, 0, {}) == "agv_overflow | AGV 0 | ");
  CHECK(said(EventKind::agv_arrived, 1, {}) == "agv_arrived | AGV 1 | ");
  CHECK(said(EventKind::delivered, 4, {0, 0}) == "delivered | container 4 | AGV 0");
  CHECK(said(EventKind::joint_limit, 0, {}) == "joint_limit | joint s | ");
  CHECK(said(EventKind::drive_stopped, 1, {}) == "drive_stopped | joint psi | ");
  CHECK(said(EventKind::drive_resumed, 2, {}) == "drive_resumed | joint phi | ");
  CHECK(said(EventKind::drive_resumed, 2, {}, CraneKind::gantry) == "drive_resumed | joint trolley | ");
  CHECK(said(EventKind::drive_tripped, 3, {0, 0.5}) == "drive_tripped | joint l | too fast, heat 0.5");
  CHECK(said(EventKind::drive_tripped, 4, {1, 1}) ==
        "drive_tripped | joint kappa | too long at its largest code, heat 1");
  CHECK(said(EventKind::drive_tripped, 0, {2, 1.3}) == "drive_tripped | joint s | too hot, heat 1.3");
  CHECK(said(EventKind::drive_warm, 1, {1.01, 0}) == "drive_warm | joint psi | heat 1.01");
  CHECK(said(EventKind::fault, -1, {0.7, -0.1}) == "fault |  | alpha 0.7 rad, beta -0.1 rad");
  CHECK(said(EventKind::joint_stuck, 2, {}) == "joint_stuck | joint phi | ");
  CHECK(said(EventKind::joint_slipped, 2, {}) == "joint_slipped | joint phi | ");
  CHECK(said(EventKind::collision, 1, {0.4, 0}) == "collision | AGV 1 | closing speed 0.4 m/s, AGV 0");
  CHECK(said(EventKind::collision, 1, {0.4, -1}) == "collision | AGV 1 | closing speed 0.4 m/s");
  CHECK(said(EventKind::missed, 2, {0.05, 0.01}) == "missed | attempt 2 | lateral error 0.05 m, yaw error 0.01 rad");
}
