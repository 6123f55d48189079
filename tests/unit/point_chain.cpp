// Points ahead of a robot (plant-and-bus.md 4.4 item 4); refreshes.
#include "cmrc/processes/point_chain.hpp"

#include <doctest/doctest.h>

#include "tests/unit/made_host.hpp"

namespace {

constexpr made::Word trajectory = 1, inverse = 2;

struct Chain {
  made::Host host;
  cmrc::PointChain chain{{.kind = trajectory, .robot = 3}, {.kind = inverse, .robot = 3}, 2};

  /// What is loaded at this refresh: kind, its number, its deadline, its t.
  std::string at(std::int64_t tick) {
    host.now = tick;
    chain.refresh(host);
    std::string all;
    for (const auto& [task, deadline] : std::exchange(host.loaded, {})) {
      CHECK(task.tick == tick);
      all += fmt::format("{}{} due {} t {};", task.kind == trajectory ? "T" : "I", task.argument, deadline.value(),
                         task.t);
    }
    return all;
  }
};

}  // namespace

TEST_CASE("a crane's points are planned two ahead, and due when the buffer runs dry") {
  Chain c;
  CHECK(c.at(0).empty());
  CHECK_FALSE(c.chain.active());
  c.chain.begin(5, 64, 1000);
  CHECK(c.chain.next_point() == 5);
  CHECK(c.chain.under_way(1000));
  CHECK(c.at(1000) == "T5 due 1064 t 0;");
  CHECK(c.host.news() == "3-leg-5-64@1000");
  CHECK(c.at(1001).empty());
  c.chain.trajectory_done(false, true, true);
  CHECK(c.at(1003) == "T6 due 1128 t 0;I5 due 1064 t 3;");
  c.chain.trajectory_done(false, true, true);
  CHECK(c.at(1004).empty());  // two points ahead, and the ring of Cartesian points is full
  c.chain.inverse_done();
  CHECK(c.at(1005) == "I6 due 1128 t 2;");
  c.chain.inverse_done();
  CHECK(c.at(1006).empty());
  // The robot uses point 5 from refresh 1050 on: one place is free, and point 7 is needed one interval after point 6.
  CHECK_FALSE(c.chain.dry(1050));
  c.chain.consumed(6, 1050);
  CHECK(c.at(1051) == "T7 due 1178 t 0;");
  CHECK(c.host.news() == "3-point-5@1050");
  c.chain.consumed(6, 1060);  // the same report again changes nothing
  CHECK_FALSE(c.chain.dry(1178));
  CHECK(c.chain.dry(1179));  // joint points reach to 1050 + 64 + 64
  c.chain.trajectory_done(true, true, false);
  CHECK(c.at(1052) == "I7 due 1178 t 1;");
  c.chain.inverse_done();
  c.chain.consumed(7, 1114);
  CHECK(c.at(1115).empty());  // the leg has no further point
  CHECK_FALSE(c.chain.through(1115));
  CHECK_FALSE(c.chain.ended(c.host));
  c.chain.consumed(8, 1178);
  c.host.now = 1179;
  CHECK(c.chain.ended(c.host));
  CHECK_FALSE(c.chain.under_way(1179));
  CHECK_FALSE(c.chain.dry(2000));
  CHECK(c.host.news() == "3-point-6@1114 3-point-7@1178 3-leg-ended-0@1179");
  CHECK(c.chain.ended(c.host));
  CHECK(c.host.news().empty());
}

TEST_CASE("a point that trajectory planning does not make demands no inverse kinematics") {
  Chain c;
  c.chain.begin(0, 10, 100);
  CHECK(c.at(100) == "T0 due 110 t 0;");
  c.chain.trajectory_done(false, false, true);
  CHECK(c.at(101) == "T0 due 110 t 0;");
  c.chain.trajectory_done(false, true, false);
  CHECK(c.at(102) == "I0 due 110 t 1;");  // and the leg does not continue
  c.chain.inverse_done();
  CHECK(c.at(103).empty());
  CHECK_FALSE(c.chain.through(103));  // it has not ended either
}

TEST_CASE("the lead is never more than the depth, whatever is out") {
  Chain c;
  c.chain.begin(0, 10, 100);
  c.at(100);
  c.chain.trajectory_done(false, true, true);
  CHECK(c.at(101) == "T1 due 120 t 0;I0 due 110 t 1;");
  c.chain.inverse_done();
  c.chain.trajectory_done(false, true, true);
  CHECK(c.at(102) == "I1 due 120 t 1;");
  c.chain.consumed(1, 110);
  CHECK(c.at(110) == "T2 due 130 t 0;");
  c.chain.trajectory_done(false, true, true);
  c.chain.consumed(2, 120);
  CHECK(c.at(120).empty());  // the block of point 1 is still out: the ring has no place for a third point
}

TEST_CASE("points that the host learns of late have the refreshes in which they were taken") {
  Chain crane;
  crane.chain.begin(5, 64, 1000);
  crane.at(1000);
  for (int point = 0; point < 2; ++point) {
    crane.chain.trajectory_done(false, true, true);
    crane.at(1001 + 2 * point);
    crane.chain.inverse_done();
    crane.at(1002 + 2 * point);
  }
  crane.chain.consumed(7, 1114);  // the host was paused: point 5 was taken an interval before point 6
  crane.at(1300);
  CHECK(crane.host.news() == "3-leg-5-64@1000 3-point-5@1050 3-point-6@1114");

  Chain agv;
  agv.chain.begin(0, 160, 1000);
  agv.at(1000);
  for (int point = 0; point < 2; ++point) {
    agv.chain.trajectory_done(false, true, true);
    agv.at(1001 + 2 * point);
    agv.chain.inverse_done();
    agv.chain.pushed(1010 + point);
  }
  agv.at(1500);
  CHECK(agv.host.news() == "3-leg-0-160@1000 3-point-0@1010 3-point-1@1170");
}

TEST_CASE("an AGV's drive holds the points that were pushed") {
  Chain c;
  c.chain.begin(0, 160, 1000);
  c.at(1000);
  c.chain.trajectory_done(false, true, true);
  c.at(1001);
  c.chain.inverse_done();
  c.chain.pushed(1010);  // held until 1170
  c.chain.trajectory_done(false, true, true);
  CHECK(c.at(1011) == "T2 due 1330 t 0;I1 due 1170 t 10;");
  c.host.news();
  c.chain.inverse_done();
  c.chain.pushed(1020);  // held behind the first one, until 1330
  c.chain.trajectory_done(true, true, false);
  CHECK(c.at(1169) == "I2 due 1330 t 158;");
  CHECK(c.host.news().empty());
  c.at(1170);
  CHECK(c.host.news() == "3-point-1@1170");
  c.chain.inverse_done();
  c.chain.pushed(1331);  // too late: the drive had run dry
  CHECK(c.at(1331).empty());
  CHECK(c.host.news() == "3-point-2@1331 3-leg-ended-0@1331");  // the point that the drive holds is used
  CHECK_FALSE(c.chain.dry(1331));
}

TEST_CASE("work that is given up is not loaded until it is resumed, and lost blocks are loaded again") {
  Chain c;
  c.chain.begin(0, 10, 100);
  c.chain.abandon();
  CHECK(c.at(100).empty());
  CHECK_FALSE(c.chain.under_way(100));
  c.chain.resume();
  CHECK(c.at(101) == "T0 due 110 t 0;");
  CHECK(c.at(102).empty());
  c.chain.lost_trajectory();
  CHECK(c.at(103) == "T0 due 110 t 0;");
  c.chain.trajectory_done(true, true, false);
  CHECK(c.at(104) == "I0 due 110 t 1;");
  c.chain.lost_inverse();
  CHECK(c.at(106) == "I0 due 110 t 3;");
  c.chain.abandon();
  c.chain.abandon();
  c.chain.resume();
  CHECK_FALSE(c.chain.active());  // what was not active when it was given up does not begin
}
