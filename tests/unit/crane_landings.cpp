// The crane's landings: ramps of the hoist, and landings that fail, jam, or wait for the wind (plant-and-bus.md 1.5 and
// 4.4).
#include <doctest/doctest.h>

#include "tests/unit/made_crane.hpp"

using made::Crane;
using made::JobKind;
using made::Kind;

TEST_CASE("a load is lowered until its corner switches have closed, and raised by the same way") {
  Crane c;
  c.torque(100);
  c.enter(Kind::lower);
  CHECK_FALSE(c.steps.lowering());
  c.host.resting = false;
  CHECK(c.land(100, 0) == "-");
  c.host.resting = true;
  c.host.behind = 20;
  // 1.875 * 0.7 m / 0.15 m/s is 8.75 s; it begins two servo intervals later, in the path's clock.
  CHECK(c.land(120, 0) == "116+8751 0 0.7");
  CHECK(c.host.news() == "0-ramp-0@136");
  CHECK(c.steps.lowering());
  CHECK(c.land(8886, c.w.pid_landed | c.w.pid_ramp_done) == "-");  // the ramp ends at 116 + 8751 = 8867, here 8887
  CHECK(c.host.news().empty());
  CHECK(c.land(8887, c.w.pid_landed) == "-");
  CHECK(c.land(8888, c.w.pid_landed | c.w.pid_ramp_done) == "done");
  CHECK(c.host.news() == "0-ramp-ended-0@8888");
  CHECK_FALSE(c.steps.retrying());
  c.enter(Kind::raise);
  CHECK(c.ramp() == "8884+8751 0.7 -0.7");
  c.pid(17654, c.w.pid_ramp_done);
  CHECK_FALSE(c.done(Kind::raise));
  c.pid(17655, c.w.pid_ramp_done);
  CHECK(c.done(Kind::raise));
  c.host.resting = false;
  c.enter(Kind::raise);
  CHECK_FALSE(c.done(Kind::raise));
  c.host.resting = true;
  CHECK_FALSE(c.done(Kind::raise));
  CHECK(c.ramp() == "17651+1 0 0");  // nothing is left
}

TEST_CASE("lowering is prolonged while the rope carries the load, five times; then the landing is missed") {
  Crane c;
  c.drive(2);
  c.torque(1000);
  c.enter(Kind::lower);
  CHECK(c.land(0, 0) == "16+8751 0 0.7");
  std::int64_t end = 16 + 8751;
  const std::string offsets[] = {"0.7", "0.8", "0.9", "1", "1.1"};
  for (const std::string& offset : offsets) {
    CHECK(c.land(end, c.w.pid_ramp_done) == "-");
    CHECK(c.land(end + 1000, c.w.pid_ramp_done) == "-");  // one second after the ramp's end
    CHECK(c.land(end + 1001, c.w.pid_ramp_done) == "-");
    CHECK(c.land(end + 1002, c.w.pid_ramp_done) == fmt::format("{}+1251 {} 0.1", end + 1002 + 16, offset));
    CHECK(c.steps.retrying());
    end += 1002 + 16 + 1251;
  }
  c.host.news();
  CHECK(c.land(end + 1000, c.w.pid_ramp_done) == "-");
  CHECK(c.host.news() == "0-ramp-ended-0@" + std::to_string(end + 1000));
  CHECK(c.land(end + 1001, c.w.pid_ramp_done) == "-");
  CHECK(c.host.news() == "missed");
  // Up, and not to be lowered again before the error block has decided.
  CHECK(c.land(end + 1002, c.w.pid_ramp_done) == fmt::format("{}+15001 1.2 -1.2", end + 1018));
  end += 1018 + 15001;
  CHECK(c.land(end, c.w.pid_ramp_done) == "-");
  c.steps.landing_decided(true);
  CHECK(c.land(end + 1, c.w.pid_ramp_done) == "-");
  // Leg 2 ends above no ship and no AGV: the load comes to rest, after one interval, and is lowered again.
  CHECK(c.land(end + 65, c.w.pid_ramp_done | c.w.pid_settled) == "-");
  CHECK_FALSE(c.steps.lowering());
  CHECK(c.land(end + 66, c.w.pid_ramp_done | c.w.pid_settled) == "-");
  CHECK(c.land(end + 67, c.w.pid_ramp_done) == fmt::format("{}+8751 0 0.7", end + 83));
  CHECK(c.land(end + 83 + 8751, c.w.pid_ramp_done | c.w.pid_landed) == "done");
}

TEST_CASE("a second miss is the last one; the load hangs until the operator has the landing begun again") {
  Crane c;
  c.drive(2);
  c.torque(1000);
  std::int64_t now = 0;
  c.enter(Kind::lower);
  const auto miss = [&] {
    for (int ramps = 0; ramps < 6; ++ramps) {
      for (int tries = 0; tries < 3 && c.land(now, c.w.pid_ramp_done) == "-"; ++tries) now += 10;
      now += 20000;
    }
    c.host.news();
    c.land(now, c.w.pid_ramp_done);
    const std::string news = c.host.news();
    return news.substr(news.rfind(' ') + 1);
  };
  CHECK(miss() == "missed");
  c.land(now, c.w.pid_ramp_done);
  c.steps.landing_decided(true);
  now += 30000;
  c.land(now, c.w.pid_ramp_done);
  now += 100;
  c.land(now, c.w.pid_settled | c.w.pid_ramp_done);
  CHECK(miss() == "missed-last");
  c.land(now, c.w.pid_ramp_done);
  c.steps.landing_decided(false);
  CHECK_FALSE(c.steps.gave_up());
  now += 30000;
  CHECK(c.land(now, c.w.pid_ramp_done) == "-");
  CHECK(c.steps.gave_up());
  CHECK(c.land(now + 100, c.w.pid_ramp_done | c.w.pid_settled) == "-");
  c.steps.landing_again();
  CHECK_FALSE(c.steps.gave_up());
  CHECK(c.land(now + 200, c.w.pid_ramp_done) == fmt::format("{}+1 0 0", now + 216));
  now += 300;
  c.land(now, c.w.pid_ramp_done);
  now += 100;
  c.land(now, c.w.pid_settled | c.w.pid_ramp_done);
  CHECK(miss() == "missed");  // counted from the start
}

TEST_CASE("above the ship a container is looked for again; above an AGV its place is measured again") {
  const auto missed = [](Crane& c, made::Word bits) {
    c.torque(1000);
    c.steps.landing_again();  // as after a miss and the decision to try again
    c.host.now = 1000;
    CHECK(c.land(1000, bits) == "1016+1 0 0");
    CHECK(c.land(1017, bits | c.w.pid_ramp_done) == "-");
  };
  Crane ship;
  ship.drive(1);
  missed(ship, 0);
  CHECK(ship.land(1100, ship.w.pid_settled) == "-");
  CHECK(ship.refresh() == "identify");
  ship.land(1101, 0);
  CHECK(ship.refresh().empty());
  cmrc::Task lost;
  lost.kind = ship.w.program(JobKind::identify);
  ship.steps.dropped(lost);
  ship.land(1102, 0);
  CHECK(ship.refresh() == "identify");
  ship.block(JobKind::identify, 0, ship.w.must_process << 2);
  ship.land(1103, 0);
  CHECK(ship.refresh() == "plan");
  ship.block(JobKind::error, 0, 0);
  ship.land(1103, 0);
  CHECK(ship.refresh().empty());  // another block that ends is not the plan
  ship.host.words.clear();
  ship.block(JobKind::grab_path, 0, 0);
  CHECK(ship.host.take(ship.w.cr_base + ship.w.cr_leg) == 1);
  CHECK(ship.land(1104, ship.w.pid_settled) == "-");
  CHECK(ship.refresh() == "T");
  ship.block(JobKind::trajectory_crane, ship.w.end_of_leg, ship.w.must_inverse);
  CHECK(ship.refresh() == "I");
  ship.block(JobKind::inverse_crane, 0, 0);
  CHECK(ship.land(1200, ship.w.pid_settled | 1) == "-");
  CHECK(ship.land(1200, ship.w.pid_settled | 2) == "-");  // the leg's point is used: from here the load comes to rest
  CHECK(ship.land(1264, ship.w.pid_settled | 2) == "-");
  CHECK(ship.land(1265, ship.w.pid_settled | 2) == "-");
  CHECK(ship.land(1266, 2) == "1282+8751 0 0.7");

  Crane nothing_found;
  nothing_found.drive(1);
  missed(nothing_found, 0);
  nothing_found.land(1100, 0);
  nothing_found.block(JobKind::identify, 0, 0);
  nothing_found.land(1101, nothing_found.w.pid_settled);
  CHECK(nothing_found.refresh() == "identify");
  CHECK(nothing_found.land(1102, 0) == "1118+8751 0 0.7");

  Crane agv;
  agv.drive(1);
  agv.enter(Kind::align);
  agv.host.words.clear();
  missed(agv, agv.w.pid_locked);
  CHECK(agv.host.take(agv.w.cr_base + agv.w.cr_leg) == agv.w.leg_align);
  CHECK(agv.refresh() == "T");

  Crane empty;  // aligned, but with nothing on the hook
  empty.drive(1);
  empty.enter(Kind::align);
  empty.host.words.clear();
  missed(empty, 0);
  CHECK(empty.host.words.empty());
  empty.land(1082, empty.w.pid_settled);
  CHECK(empty.land(1083, 0) == "1099+8751 0 0.7");

  Crane full;  // above the ship with a container
  full.drive(1);
  missed(full, full.w.pid_locked);
  full.land(1082, full.w.pid_settled | full.w.pid_locked);
  CHECK(full.refresh().empty());
  CHECK(full.land(1083, full.w.pid_locked) == "1099+8751 0 0.7");
}

TEST_CASE("a load that is jammed is lifted in small steps until it is free, and put down again") {
  Crane c;
  c.drive(2);
  c.torque(1000);
  c.enter(Kind::lower);
  CHECK(c.land(0, 0) == "16+8751 0 0.7");
  std::int64_t now = 16 + 8751 + 1001;
  c.torque(899);  // less than nine tenths of what hung on the rope
  CHECK(c.land(now, c.w.pid_ramp_done) == fmt::format("{}+1251 0.7 -0.05", now + 16));  // at half the speed
  CHECK(c.steps.retrying());
  now += 16 + 1251;
  CHECK(c.land(now + 150, c.w.pid_ramp_done) == "-");
  CHECK(c.land(now + 151, c.w.pid_ramp_done) == fmt::format("{}+1251 0.65 -0.05", now + 167));
  now += 167 + 1251;
  c.torque(900);
  CHECK(c.land(now + 151, c.w.pid_ramp_done) == fmt::format("{}+2501 0.6 0.1", now + 167));  // free: down again
  now += 167 + 2501;
  // Still not landed: the next try begins a second after the ramp.
  CHECK(c.land(now + 1000, c.w.pid_ramp_done) == "-");
  c.torque(500);
  CHECK(c.land(now + 1001, c.w.pid_ramp_done) == fmt::format("{}+1251 0.7 -0.05", now + 1017));
  now += 1017 + 1251;
  for (int n = 1; n < 6; ++n, now += 167 + 1251)
    CHECK(c.land(now + 151, c.w.pid_ramp_done) == fmt::format("{}+1251 {:.6g} -0.05", now + 167, 0.7 - 0.05 * n));
  CHECK(c.land(now + 151, c.w.pid_ramp_done) == fmt::format("{}+7501 0.4 0.3", now + 167));  // 0.3 m is the most
  now += 167 + 7501;
  c.host.resting = false;
  c.land(now + 1001, c.w.pid_ramp_done);  // the servo's words cannot be changed: tried again, and not counted
  c.host.resting = true;
  CHECK(c.land(now + 1002, c.w.pid_ramp_done) == fmt::format("{}+1251 0.7 -0.05", now + 1018));
  now += 1018 + 1251;
  CHECK(c.land(now + 10, c.w.pid_landed) == "-");  // the corner switches close: free
  CHECK(c.land(now + 151, c.w.pid_ramp_done) == fmt::format("{}+1251 0.65 0.05", now + 167));
  now += 167 + 1251;
  CHECK(c.land(now, c.w.pid_ramp_done | c.w.pid_landed) == "done");
}

TEST_CASE("in wind a load hangs between the guides until it is steady") {
  Crane c;
  c.torque(1000);
  const made::Word windy = c.w.pid_windy, ended = windy | c.w.pid_ramp_done, steady = ended | c.w.pid_steady;
  c.enter(Kind::lower);
  CHECK(c.land(0, windy) == "16+5001 0 0.4");  // to 0.2 m above the surface
  CHECK(c.host.news() == "0-ramp-0@16");
  std::int64_t now = 5017;
  CHECK(c.land(now, steady) == "-");
  CHECK(c.host.news().empty());
  CHECK(c.land(now + 249, steady) == "-");
  CHECK(c.land(now + 250, steady) == "-");  // steady counts from here on
  CHECK(c.land(now + 300, ended) == "-");   // unsteady
  CHECK(c.land(now + 549, steady) == "-");
  CHECK(c.land(now + 550, steady) == "-");
  // The second ramp is slower: 1.875 * 0.3 / (0.8 * 0.15) s. It is the same landing: no ramp begins.
  CHECK(c.land(now + 551, steady) == fmt::format("{}+4689 0.4 0.3", now + 567));
  CHECK(c.host.news().empty());
  now += 567 + 4689;
  CHECK(c.land(now, ended | c.w.pid_landed) == "done");
  CHECK(c.host.news() == "0-ramp-ended-0@" + std::to_string(now));
  c.enter(Kind::raise);
  CHECK(c.ramp() == fmt::format("{}+8751 0.7 -0.7", now + 16));

  Crane never;
  never.torque(1000);
  never.enter(Kind::lower);
  never.land(0, windy);
  CHECK(never.land(5017 + 2000, ended) == "-");
  CHECK(never.land(5017 + 2001, ended) == "-");  // the limit of waiting
  CHECK(never.land(5017 + 2002, ended) == "7035+4689 0.4 0.3");

  Crane down;
  down.torque(1000);
  down.steps.set_down(true);
  down.enter(Kind::lower);
  CHECK(down.land(0, windy) == "16+8751 0 0.7");  // an error wants it set down: in one ramp

  Crane near(0.2);
  near.torque(1000);
  near.enter(Kind::lower);
  CHECK(near.land(0, windy) == "16+3752 0 0.3");  // 0.2 + 0.1 is more than 0.3
}

TEST_CASE("before PID has taken the pose the wind at power-on counts, not what torque compensation says") {
  Crane windy(0.6, true), calm(0.6, false);
  windy.torque(0);
  calm.torque(0, true);
  CHECK(windy.steps.too_windy());
  CHECK_FALSE(calm.steps.too_windy());
  for (Crane* c : {&windy, &calm}) {
    c->host.now = 8;
    c->torque(0, !c->steps.too_windy());  // of refresh 9, not yet finished when PID is
    c->pid(9, 0);
  }
  CHECK(windy.steps.too_windy());
  CHECK_FALSE(calm.steps.too_windy());
  windy.torque(0);
  calm.torque(0, true);
  CHECK_FALSE(windy.steps.too_windy());
  CHECK(calm.steps.too_windy());
}

TEST_CASE("with too much wind an empty spreader waits above a container") {
  Crane c;
  c.pid(0, 0);
  c.torque(1000, true);
  CHECK(c.steps.too_windy());
  c.enter(Kind::lower);
  CHECK(c.steps.waits_for_wind());
  CHECK(c.land(0, 0) == "-");
  CHECK(c.land(1, c.w.pid_locked) == "17+8751 0 0.7");  // with a container it continues
  CHECK_FALSE(c.steps.waits_for_wind());

  Crane calmer;
  calmer.pid(0, 0);
  calmer.torque(1000, true);
  calmer.enter(Kind::lower);
  CHECK(calmer.land(0, 0) == "-");
  calmer.torque(1000);
  CHECK_FALSE(calmer.steps.waits_for_wind());
  CHECK(calmer.land(1, 0) == "17+8751 0 0.7");

  Crane set_down;
  set_down.pid(0, 0);
  set_down.torque(1000, true);
  set_down.steps.set_down(true);
  set_down.enter(Kind::lower);
  CHECK(set_down.land(0, 0) == "16+8751 0 0.7");
  set_down.drive(2);
  std::int64_t now = 16 + 8751;
  for (int probes = 0; probes < 5; ++probes, now += 1002 + 16 + 1251) {
    CHECK(set_down.land(now + 1001, set_down.w.pid_ramp_done) == "-");
    CHECK(set_down.land(now + 1002, set_down.w.pid_ramp_done) != "-");
  }
  set_down.host.news();
  CHECK(set_down.land(now + 1001, set_down.w.pid_ramp_done) == "-");
  CHECK(set_down.steps.gave_up());  // it is not lifted again
  CHECK(set_down.host.news() == "0-ramp-ended-0@" + std::to_string(now + 1001));
}
