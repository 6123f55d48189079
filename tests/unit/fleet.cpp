// The AGVs' steps: legs to the warehouse and back, the queue at the dock (ruling 11). The test plays the blocks.
#include "cmrc/processes/fleet.hpp"

#include <doctest/doctest.h>

#include <numbers>

#include "cmrc/configuration/dock/nominal_dock.hpp"
#include "cmrc/run/setup.hpp"
#include "tests/unit/made_host.hpp"

namespace {

using cmrc::JobKind;
using Kind = cmrc::Step::Kind;

cmrc::FleetJob fleet_job(unsigned agvs) {
  cmrc::FleetJob job;
  job.agvs = agvs;
  job.to_warehouse = {{22, 8, 0, 30, 0, 4}, {52, 8, 0, 20, 0.1, 3}};
  job.to_spot = {{60, 20, 1, 25, 0, 5}, {40, 20, 2, 15, -0.2, 3.5}, {2, 8, 0, 20, 0, 4}};
  job.refresh_frequency = 1000;
  job.interval = 20;
  return job;
}

struct Vehicles {
  explicit Vehicles(unsigned agvs) : fleet(fleet_job(agvs), w) {}
  cmrc::Words w = made::words();
  made::Host host;
  cmrc::Fleet fleet;

  cmrc::Step step(Kind kind, unsigned leg = 0, double seconds = 0, const char* task = "") {
    cmrc::Step one;
    one.kind = kind;
    one.leg = leg;
    one.seconds = seconds;
    one.task = task;
    return one;
  }
  void enter(unsigned agv, Kind kind, unsigned leg = 0, double seconds = 0) {
    fleet.enter(agv, step(kind, leg, seconds), host);
  }
  bool done(unsigned agv, Kind kind) { return fleet.done(agv, step(kind), host); }
  void block(unsigned agv, JobKind kind, made::Word result, made::Word notify) {
    cmrc::Task task;
    task.kind = w.program(kind);
    task.robot = agv + 1;
    fleet.finished(task, result, notify, host);
  }
  std::string refresh(unsigned agv) {
    fleet.refresh(agv, host);
    std::string all;
    for (const auto& [task, deadline] : std::exchange(host.loaded, {})) {
      CHECK(task.robot == agv + 1);
      CHECK(task.area == w.agv_area(agv));
      all += task.kind == w.program(JobKind::trajectory_agv) ? "T" : "I";
    }
    return all;
  }
  /// The leg is driven to its end: one point.
  void drive(unsigned agv) {
    CHECK(refresh(agv) == "T");
    block(agv, JobKind::trajectory_agv, w.end_of_leg, w.must_inverse);
    CHECK(refresh(agv) == "I");
    block(agv, JobKind::inverse_agv, 0, 0);
  }
  /// "x y heading length curvature speed" of the pieces that were written of this leg since the last call.
  std::string pieces(unsigned agv, made::Word leg) {
    std::string all;
    const made::Word first = w.agv_area(agv) + w.ag_segment + (leg - 1) * 64;
    for (made::Word piece = 0; host.words.contains(first + piece * 8); ++piece) {
      for (made::Word n = 0; n < 6; ++n) all += (n > 0 ? " " : "") + made::number(host.take(first + piece * 8 + n));
      all += ";";
    }
    return all;
  }
  /// "leg: pieces of interval", of the leg that was begun since the last call.
  std::string begun(unsigned agv, made::Word leg) {
    const made::Word area = w.agv_area(agv);
    CHECK(host.take(area + w.ag_leg + 1) == 0);
    for (made::Word n = w.ag_avoid_limit; n <= w.ag_avoid_beside; ++n) CHECK(host.take(area + n) == 0);
    return fmt::format("{}: {} of {}, {} us", host.take(area + w.ag_leg), host.take(area + w.ag_segment_count + leg),
                       host.take(area + w.ag_point_ticks), host.take(area + w.ag_point_ticks + 1));
  }
};

const std::string out = "22 8 0 30 0 4;52 8 0 20 0.1 3;";

}  // namespace

TEST_CASE("a vehicle drives to the warehouse and back to the spot") {
  Vehicles v(1);
  v.fleet.start(v.host);
  CHECK(made::number(v.host.take(v.w.agv_area(0) + v.w.ag_step_time)) == "0.02");
  CHECK(v.host.take(v.w.agv_area(0) + v.w.ag_unit) == v.w.agv_unit);
  CHECK(v.host.words.empty());
  CHECK(v.fleet.queued(0));
  v.host.now = 100;
  v.fleet.set_interval(0, 22);
  CHECK(v.fleet.interval(0) == 20);
  v.enter(0, Kind::leg, 1);
  CHECK(v.host.news() == "0-sent-22");
  CHECK_FALSE(v.fleet.queued(0));
  CHECK(v.pieces(0, 1) == out);
  CHECK(v.begun(0, 1) == "1: 2 of 22, 22000 us");
  CHECK(v.host.words.empty());
  CHECK(v.fleet.on_leg(0, 100));
  CHECK_FALSE(v.done(0, Kind::leg));
  CHECK(v.host.news() == "1-leg-0-22@100");
  v.drive(0);
  v.host.now = 101;
  CHECK(v.done(0, Kind::leg));
  CHECK_FALSE(v.fleet.on_leg(0, 101));
  v.enter(0, Kind::hand_over);
  v.host.now = 101 + 10499;
  CHECK_FALSE(v.done(0, Kind::hand_over));
  v.host.now = 101 + 10500;  // ten seconds, and half of one in which it comes to stand
  CHECK(v.done(0, Kind::hand_over));
  v.enter(0, Kind::hold, 0, 0.0201);
  v.host.now += 20;
  CHECK_FALSE(v.done(0, Kind::hold));
  v.host.now += 1;
  CHECK(v.done(0, Kind::hold));
  v.host.news();
  v.enter(0, Kind::queue);
  CHECK(v.fleet.queued(0));
  CHECK(v.fleet.moving_up(0));
  CHECK(v.pieces(0, 2) == "60 20 1 25 0 5;40 20 2 15 -0.2 3.5;2 8 0 20 0 4;");
  CHECK(v.begun(0, 2) == "2: 3 of 22, 22000 us");
  CHECK_FALSE(v.done(0, Kind::queue));
  v.drive(0);
  v.host.now += 1;
  CHECK(v.done(0, Kind::queue));
  CHECK_FALSE(v.fleet.moving_up(0));
  v.host.told.clear();
  CHECK_FALSE(v.done(0, Kind::queue));  // it stands in the spot, and nothing moves
  CHECK(v.host.news().empty());
}

TEST_CASE("the queue closes up one slot after the other") {
  Vehicles v(3);
  CHECK(v.fleet.size() == 3);
  for (unsigned agv = 0; agv < 3; ++agv) CHECK(v.fleet.slot(agv) == agv);
  v.enter(0, Kind::leg, 1);
  v.host.words.clear();
  v.host.told.clear();
  // Vehicle 2 cannot move up: slot 1 is taken. Vehicle 1 can, from slot 1, which is 18 m behind the spot.
  CHECK_FALSE(v.done(2, Kind::queue));
  CHECK(v.host.words.empty());
  CHECK_FALSE(v.done(1, Kind::queue));
  CHECK(v.pieces(1, 2) == "4 8 0 18 0 1.5;");
  CHECK(v.begun(1, 2) == "2: 1 of 20, 20000 us");
  CHECK(v.host.news() == "1-leaves");
  CHECK(v.fleet.slot(1) == 0);
  CHECK(v.fleet.moving_up(1));
  CHECK_FALSE(v.done(2, Kind::queue));
  CHECK(v.pieces(2, 2) == "-14 8 0 18 0 1.5;");
  CHECK(v.fleet.slot(2) == 1);
  v.host.words.clear();
  v.host.told.clear();
  v.drive(2);
  v.host.now += 1;
  CHECK_FALSE(v.done(2, Kind::queue));  // in slot 1, not in the spot
  CHECK(v.host.news().ends_with("2-waits"));
  // Vehicle 0 comes back: behind the last one, so its way ends 36 m before the spot.
  v.enter(0, Kind::queue);
  CHECK(v.fleet.slot(0) == 2);
  CHECK(v.pieces(0, 2) == "60 20 1 24 0 5;");
}

TEST_CASE("home is a place in the queue") {
  Vehicles v(2);
  const cmrc::Step home = v.step(Kind::task, 0, 0, "home.agv");
  v.fleet.enter(1, home, v.host);
  CHECK(v.fleet.slot(1) == 1);
  CHECK(v.pieces(1, 3) == "60 20 1 25 0 5;40 20 2 15 -0.2 3.5;2 8 0 2 0 4;");
  CHECK(v.begun(1, 3) == "3: 3 of 20, 20000 us");
  CHECK_FALSE(v.fleet.on_leg(1, 0));
  v.enter(0, Kind::leg, 1);
  v.host.words.clear();
  v.fleet.enter(0, home, v.host);  // it was away, and comes behind the other one
  CHECK(v.fleet.slot(0) == 2);
  CHECK(v.fleet.queued(0));
  v.host.words.clear();
  v.fleet.enter(0, v.step(Kind::task, 0, 0, "identify"), v.host);
  CHECK(v.host.words.empty());
  v.enter(0, Kind::leg, 3);  // the leg home, whose pieces are written
  CHECK(v.host.words.empty());
  CHECK(v.fleet.on_leg(0, 0));
}

TEST_CASE("an empty round passes the warehouse at the speed of the slowest lane") {
  const cmrc::FleetJob job = fleet_job(2);
  const auto told = [](const std::vector<cmrc::Lane>& lanes) {
    std::string all;
    for (const cmrc::Lane& lane : lanes)
      all += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g};", lane.x, lane.y, lane.heading, lane.length, lane.speed);
    return all;
  };
  CHECK(told(cmrc::round_from(job, 0)) == "22 8 0 30 3;52 8 0 20 3;60 20 1 25 3;40 20 2 15 3;2 8 0 20 3;");
  CHECK(told(cmrc::round_from(job, 1)) == "4 8 0 18 3;22 8 0 30 3;52 8 0 20 3;60 20 1 25 3;40 20 2 15 3;2 8 0 2 3;");
  cmrc::FleetJob turned = job;
  turned.spot_heading = std::numbers::pi / 2;
  turned.move_up_speed = 9;
  turned.slot_spacing = 20;
  CHECK(told(cmrc::round_from(turned, 1)) == "22 -12 1.5708 20 3;22 8 0 30 3;52 8 0 20 3;60 20 1 25 3;40 20 2 15 3;");
  Vehicles v(1);
  v.fleet.send_round(0, v.host);
  CHECK(v.fleet.moving_up(0));
  CHECK(v.begun(0, 2) == "2: 5 of 20, 20000 us");
}

TEST_CASE("vehicles' blocks that were dropped are loaded again, and each vehicle's work is its own") {
  Vehicles v(2);
  v.enter(0, Kind::leg, 1);
  v.enter(1, Kind::leg, 1);
  CHECK(v.refresh(0) == "T");
  CHECK(v.refresh(1) == "T");
  cmrc::Task lost;
  lost.robot = 2;
  lost.kind = v.w.program(JobKind::inverse_agv);
  v.fleet.dropped(lost);
  CHECK(v.refresh(1).empty());
  lost.kind = v.w.program(JobKind::trajectory_agv);
  v.fleet.dropped(lost);
  CHECK(v.refresh(0).empty());
  CHECK(v.refresh(1) == "T");
  v.block(1, JobKind::trajectory_agv, 0, v.w.must_inverse | v.w.must_trajectory);
  CHECK(v.refresh(1) == "TI");
  lost.kind = v.w.program(JobKind::inverse_agv);
  v.fleet.dropped(lost);
  CHECK(v.refresh(1) == "I");
  v.fleet.abandon(1);
  v.fleet.dropped(lost);
  CHECK(v.refresh(1).empty());
  v.fleet.resume(1);
  CHECK(v.refresh(1) == "I");
  v.block(0, JobKind::trajectory_agv, 0, 0);  // the point was not made, and none is demanded
  CHECK(v.refresh(0).empty());
}

TEST_CASE("the fleet's job has the places of the layout") {
  const cmrc::Config config;
  plant::DockConfig dock = cmrc::nominal_dock_of(config);
  dock.layout.spot.x = 21.0;
  dock.layout.spot.y = 7.0;
  dock.layout.spot.heading = 0.25;
  dock.layout.slot_spacing = 12.0;
  const cmrc::FleetJob job = cmrc::fleet_of(config, dock, made::words());
  CHECK(job.spot_x == 21.0);
  CHECK(job.spot_y == 7.0);
  CHECK(job.spot_heading == 0.25);
  CHECK(job.slot_spacing == 12.0);
  CHECK(job.to_warehouse.size() == dock.layout.legs[0].size());
  CHECK(job.to_spot.size() == dock.layout.legs[1].size());
}
