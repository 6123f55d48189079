// The course of a run: a row for each latch, in limited memory; milestones and starved intervals.
#include "cmrc/measures/course.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "plant/dock/dock.hpp"
#include "plant/parameters/config.hpp"

namespace {

using cmrc::Milestone;
using cmrc::Time;
constexpr Time latch = plant::latch_period;
constexpr std::size_t slew = 1;

/// A dock whose jib swings, latch by latch; and the slewing angle at each.
struct Swinging {
  plant::Dock dock{plant::default_dock(2)};
  std::vector<double> slewed;
  Time now{};

  Swinging() { dock.enable_drives(1U << slew, Time{}); }
  void record(cmrc::Course& course, int latches) {
    for (int n = 0; n < latches; ++n) {
      dock.set_torque_code(static_cast<int>(slew), 1500, now);
      now += latch;
      dock.advance_to(now);
      course.latch(dock, now);
      slewed.push_back(cmrc::Course::to_grid(dock.place().q[slew]));
    }
  }
};

}  // namespace

TEST_CASE("row i is the latch at i + 1 steps, and between rows a column is a line") {
  cmrc::Course course(64, 2);
  Swinging swinging;
  CHECK(course.recorded());
  CHECK_FALSE(cmrc::Course(0, 2).recorded());
  course.latch(swinging.dock, Time{});  // nothing has moved at 0
  CHECK(course.size() == 0);
  swinging.record(course, 40);
  REQUIRE(course.size() == 40);
  CHECK(course.end() == 40 * latch);
  CHECK(course.bytes() == 40 * (5 + 3 + 2 + 2 * 2) * sizeof(double));
  const std::vector<double>& q = swinging.slewed;
  CHECK(q[39] != q[38]);
  for (std::size_t n = 0; n < 40; ++n) CHECK(course.at(static_cast<std::int64_t>(n + 1) * latch)[slew] == q[n]);
  CHECK(course.at(Time{})[slew] == q[0]);
  CHECK(course.at(39 * latch + latch / 2)[slew] == q[38]);
  CHECK(course.at(39 * latch + latch / 4, slew) == doctest::Approx(q[38] + 0.25 * (q[39] - q[38])).epsilon(1e-12));
  CHECK(course.at(99 * latch)[slew] == q[39]);
  const plant::Place place = swinging.dock.place();
  const auto row = course.at(40 * latch);
  CHECK(row[cmrc::load_column] == cmrc::Course::to_grid(place.payload[0]));
  CHECK(row[cmrc::load_column + 2] == cmrc::Course::to_grid(place.payload[2]));
  CHECK(row[cmrc::sway_column] == cmrc::Course::to_grid(place.alpha));
  CHECK(row[cmrc::sway_column + 1] == cmrc::Course::to_grid(place.beta));
  for (int agv = 0; agv < 2; ++agv) {
    CHECK(row[cmrc::agv_column + 2 * static_cast<std::size_t>(agv)] == cmrc::Course::to_grid(swinging.dock.agv(agv).x));
    CHECK(row[cmrc::agv_column + 2 * static_cast<std::size_t>(agv) + 1] ==
          cmrc::Course::to_grid(swinging.dock.agv(agv).y));
  }
}

TEST_CASE("when its rows are full a course keeps every second one") {
  cmrc::Course course(8, 2);
  Swinging swinging;
  swinging.record(course, 8);
  CHECK(course.step() == latch);
  CHECK(course.size() == 8);
  swinging.record(course, 1);
  CHECK(course.step() == 2 * latch);
  CHECK(course.size() == 4);
  swinging.record(course, 1);
  CHECK(course.size() == 5);
  swinging.record(course, 15);
  CHECK(course.step() == 4 * latch);
  CHECK(course.end() == 24 * latch);
  for (std::int64_t n = 1; n <= 6; ++n)
    CHECK(course.at(4 * n * latch)[slew] == swinging.slewed[static_cast<std::size_t>(4 * n - 1)]);
}

TEST_CASE("milestones have the same key in the same work, and gaps between points are counted") {
  cmrc::Course course(0, 1);
  const auto key = [&](std::size_t n) { return course.milestones().at(n).key; };
  course.process_begun(0, 3);
  course.leg_begun(0, 10, Time{100}, Time{1000});
  course.milestone(0, Milestone::Kind::point, 10, Time{1100});
  course.milestone(0, Milestone::Kind::point, 11, Time{1200});
  course.milestone(0, Milestone::Kind::leg_ended, 0, Time{1300});
  course.process_begun(0, 4);
  course.leg_begun(0, 12, Time{50}, Time{2000});
  course.milestone(0, Milestone::Kind::ramp_begun, 0, Time{2010});
  course.milestone(0, Milestone::Kind::ramp_begun, 0, Time{2020});
  CHECK(key(0) == (3ull << 60 | 1ull << 44 | 1ull << 36));
  CHECK(key(1) == (3ull << 60 | 1ull << 44 | 1ull << 36 | 1ull << 32));
  CHECK(key(2) == key(1) + 1);
  CHECK(key(3) == (3ull << 60 | 1ull << 44 | 1ull << 36 | 2ull << 32));
  CHECK(key(4) == (4ull << 60 | 2ull << 44 | 1ull << 36));
  CHECK(key(6) == key(5) + 1);
  CHECK(course.milestones()[2].kind() == Milestone::Kind::point);
  CHECK(course.milestones()[2].at == Time{1200});
  CHECK(course.starved_intervals(Time{2199}).at(0) == 2);  // of 50 each

  cmrc::Course starved(0, 1);
  starved.leg_begun(1, 0, Time{100}, Time{1000});
  starved.milestone(1, Milestone::Kind::point, 0, Time{1199});  // 1.99 intervals: none is whole behind the first
  CHECK(starved.starved_intervals(Time{1199}).at(1) == 0);
  starved.milestone(1, Milestone::Kind::point, 1, Time{1399});
  CHECK(starved.starved_intervals(Time{1399}).at(1) == 1);
  CHECK(starved.starved_intervals(Time{1698}).at(1) == 2);
  CHECK(starved.starved_intervals(Time{1699}).at(1) == 3);
  starved.milestone(1, Milestone::Kind::leg_ended, 0, Time{1500});
  CHECK(starved.starved_intervals(Time{9000}).at(1) == 1);
}

TEST_CASE("memory of milestones is limited, whatever their kinds") {
  const auto kinds = [](const cmrc::Course& course, Milestone::Kind kind) {
    return std::ranges::count_if(course.milestones(), [&](const auto& one) { return one.kind() == kind; });
  };
  constexpr auto most = cmrc::Course::milestones_max;
  cmrc::Course ends(0, 1);
  std::int64_t now = 0;
  const auto process = [&](cmrc::Course& course) {
    course.process_begun(1, 9);
    course.milestone(1, Milestone::Kind::process_ended, 0, Time{++now});
  };
  for (std::size_t n = 0; n < 3 * most; ++n) process(ends);
  CHECK(ends.milestones().size() <= most);
  CHECK(ends.milestones().size() > most / 4);
  for (std::size_t n = 1; n < ends.milestones().size(); ++n)
    CHECK(ends.milestones()[n].at - ends.milestones()[n - 1].at <= Time{8});

  // Legs stay; points and ends of processes make room for them.
  cmrc::Course legs(0, 1);
  for (std::size_t n = 0; n < most; ++n) {
    process(legs);
    legs.leg_begun(1, 0, Time{100}, Time{++now});
    legs.milestone(1, Milestone::Kind::point, 0, Time{++now});
    legs.milestone(1, Milestone::Kind::point, 1, Time{++now});
    legs.milestone(1, Milestone::Kind::leg_ended, 0, Time{++now});
  }
  CHECK(kinds(legs, Milestone::Kind::leg_begun) == most);
  CHECK(kinds(legs, Milestone::Kind::leg_ended) == most);
  CHECK(legs.milestones().size() < 4 * most);
}

TEST_CASE("servoing begins and ends in turn") {
  cmrc::Course course(0, 1);
  course.servo(false, Time{1});
  course.servo(true, Time{2});
  course.servo(true, Time{3});
  course.servo(false, Time{4});
  course.servo(false, Time{5});
  course.servo(true, Time{6});
  CHECK(course.servo_times() == std::vector<Time>{Time{2}, Time{4}, Time{6}});
}
