// The crane's steps: legs, points, rest, pauses and locks (plant-and-bus.md 4.4).
#include <doctest/doctest.h>

#include "tests/unit/made_crane.hpp"

using made::Crane;
using made::JobKind;
using made::Kind;

TEST_CASE("a leg is written before its points are planned, with new intervals and speeds") {
  Crane c;
  c.host.now = 10;
  c.enter(Kind::leg, 3);
  CHECK(c.host.take(c.w.cr_base + c.w.cr_leg) == 3);
  CHECK(c.host.words.empty());  // nothing else has changed
  CHECK(c.steps.on_leg(10));
  CHECK_FALSE(c.done(Kind::leg));
  CHECK(c.host.news() == "0-leg-0-64@10");
  c.steps.set_interval(80);
  c.steps.set_speeds({1, 2, 3, 4, 5, 6, 7});
  CHECK(c.steps.interval() == 64);
  c.enter(Kind::align);
  CHECK(c.steps.interval() == 80);
  CHECK(c.host.take(c.w.cr_base + c.w.cr_agv) == c.w.agv_unit + 2 * c.w.agv_unit_words);
  CHECK(c.host.take(c.w.cr_base + c.w.cr_leg) == c.w.leg_align);
  CHECK(made::number(c.host.take(c.w.cr_base + c.w.cr_point_period)) == "0.08");
  CHECK(c.host.take(c.w.cr_base + c.w.cr_point_ticks) == 80);
  CHECK(made::number(c.host.take(c.w.cr_base + c.w.cr_stretch)) == "1.25");
  for (made::Word n = 0; n < 7; ++n) CHECK(c.host.take(c.w.cr_base + c.w.cr_speed + n) == n + 1);
  CHECK(c.host.words.empty());
  CHECK_FALSE(c.done(Kind::align));
  CHECK(c.host.news() == "0-leg-0-80@10");
}

TEST_CASE("points are counted in 16 bits, and segments follow one another unless one began late") {
  Crane c;
  c.enter(Kind::leg, 1);
  CHECK(c.refresh() == "T");
  c.block(JobKind::trajectory_crane, 0, c.w.must_inverse | c.w.must_trajectory);
  CHECK(c.refresh() == "TI");
  c.block(JobKind::inverse_crane, 0, 0);
  c.block(JobKind::trajectory_crane, c.w.end_of_leg, c.w.must_inverse);
  CHECK(c.refresh() == "I");
  c.block(JobKind::inverse_crane, 0, 0);
  c.host.news();
  c.pid(100, c.w.pid_began, 1);
  CHECK_FALSE(c.done(Kind::leg));
  CHECK(c.host.news() == "0-point-0@100");
  c.pid(170, 0, 1);
  c.pid(175, 0, 0x8002);  // backwards
  CHECK_FALSE(c.done(Kind::leg));
  CHECK(c.host.news().empty());
  c.pid(180, 0, 2);  // reported late: the segment began 64 refreshes after the one before
  CHECK(c.done(Kind::leg));
  CHECK(c.host.news() == "0-point-1@164 0-leg-ended-0@180");

  Crane slow;
  slow.host.behind = 5;  // the path has a clock of its own
  slow.plan(1);
  slow.host.news();
  slow.pid(300, 0, 1);
  CHECK(slow.done(Kind::leg));
  CHECK(slow.host.news() == "0-point-0@300 0-leg-ended-0@300");
}

TEST_CASE("blocks that were dropped are loaded again") {
  Crane c;
  c.enter(Kind::leg, 1);
  CHECK(c.refresh() == "T");
  cmrc::Task lost;
  lost.kind = c.w.program(JobKind::inverse_crane);
  c.steps.dropped(lost);
  CHECK(c.refresh().empty());
  lost.kind = c.w.program(JobKind::trajectory_crane);
  c.steps.dropped(lost);
  CHECK(c.refresh() == "T");
  c.block(JobKind::trajectory_crane, 0, c.w.must_inverse);
  CHECK(c.refresh() == "I");
  lost.kind = c.w.program(JobKind::inverse_crane);
  c.steps.dropped(lost);
  CHECK(c.refresh() == "I");
  c.steps.abandon();
  c.steps.dropped(lost);
  CHECK(c.refresh().empty());
  c.steps.resume();
  CHECK(c.refresh() == "I");
}

TEST_CASE("a load has come to rest when PID says so after the last segment, or the limit has passed") {
  Crane c;
  c.host.now = 100;
  c.enter(Kind::settle);
  c.pid(164, c.w.pid_settled);
  CHECK_FALSE(c.done(Kind::settle));
  c.pid(165, 0);
  CHECK_FALSE(c.done(Kind::settle));
  c.pid(165, c.w.pid_settled);
  CHECK(c.done(Kind::settle));
  c.pid(165, 0);
  c.host.now = 2164;
  CHECK_FALSE(c.done(Kind::settle));
  c.host.now = 2165;
  CHECK(c.done(Kind::settle));
}

TEST_CASE("a pause lasts whole refreshes; locks and lock pins are waited for") {
  Crane c;
  c.host.now = 7;
  c.enter(Kind::hold, 0, 0.0101);
  c.host.now = 17;
  CHECK_FALSE(c.done(Kind::hold));
  c.host.now = 18;
  CHECK(c.done(Kind::hold));
  c.enter(Kind::lock);
  CHECK(c.host.take(c.w.cr_base + c.w.cr_spreader) == 1);
  c.pid(20, c.w.pid_open | c.w.pid_landed | c.w.pid_settled);
  CHECK_FALSE(c.done(Kind::lock));
  c.pid(21, c.w.pid_locked);
  CHECK(c.done(Kind::lock));
  CHECK(c.host.news() == "0-locked-0@21");
  c.enter(Kind::open);
  CHECK(c.host.take(c.w.cr_base + c.w.cr_spreader) == 0);
  CHECK_FALSE(c.done(Kind::open));
  c.pid(22, c.w.pid_open);
  CHECK(c.done(Kind::open));
  CHECK(c.host.news() == "0-opened-0@22");
  CHECK(c.steps.pid().open);
  CHECK_FALSE(c.steps.pid().locked);
  c.pid(23, c.w.pid_starved);
  CHECK(c.steps.pid().starved);
  CHECK_FALSE(c.steps.pid().landed);
  CHECK_FALSE(c.steps.pid().windy);
}
