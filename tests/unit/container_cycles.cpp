// Cycle times and learning (plant-and-bus.md 4.7), against timelines made by hand; seconds.
#include "cmrc/processes/container_cycles.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "cmrc/configuration/rows/process_table.hpp"

namespace {

report::Time seconds(double s) { return report::Time{std::llround(s * 1e12)}; }

/// As cmrc::ContainerCycles, with processes by their numbers and times in seconds.
class Cycles {
 public:
  void begins(unsigned number, unsigned robot, double at) { process(number, true, robot, at); }
  void ends(unsigned number, unsigned robot, double at) { process(number, false, robot, at); }
  void agv_waits(unsigned agv, bool waits, double at) { cycles_.agv_waits(agv, waits, seconds(at)); }
  const report::CycleReport& operator[](std::size_t n) const { return cycles_.cycles().at(n); }
  std::size_t size() const { return cycles_.cycles().size(); }
  unsigned completed() const { return cycles_.completed(); }

 private:
  void process(unsigned number, bool started, unsigned robot, double at) {
    cycles_.process(cmrc::built_in_processes().find(number)->account, started, robot, seconds(at));
  }
  cmrc::ContainerCycles cycles_;
};

double in_seconds(const std::optional<report::Time>& time) {
  REQUIRE(time.has_value());
  return static_cast<double>(time->count()) * 1e-12;
}

}  // namespace

TEST_CASE("a cycle has its AGV from the start of t_4 on") {
  Cycles run;
  run.begins(3, 0, 1);
  CHECK(!run[0].agv);
  run.ends(3, 0, 5);
  CHECK(!run[0].agv);
  run.begins(4, 2, 6);
  CHECK(run[0].agv == 1U);
}

TEST_CASE("cycle times of one crane and one AGV") {
  // Crane: 3 in 0..70, 4 in 75..85 (the AGV came at 75), next 3 in 85..160. AGV 0: 5 in 85..120, 6 in 120..150, loaded
  // again from 160 to 172.
  Cycles cycles;
  cycles.begins(3, 0, 0);
  cycles.ends(3, 0, 70);
  cycles.begins(4, 1, 75);
  cycles.ends(4, 1, 85);
  cycles.begins(3, 0, 85);
  cycles.begins(5, 1, 85);
  cycles.ends(5, 1, 120);
  cycles.begins(6, 1, 120);
  cycles.ends(6, 1, 150);
  cycles.ends(3, 0, 160);
  cycles.begins(4, 1, 160);
  cycles.ends(4, 1, 172);
  const report::CycleReport& first = cycles[0];
  CHECK(in_seconds(first.t3) == 70);
  CHECK(in_seconds(first.t_v) == 5);
  CHECK(in_seconds(first.t4) == 10);
  CHECK(in_seconds(first.T_g) == 85);
  CHECK(in_seconds(first.t5) == 35);
  CHECK(in_seconds(first.t6) == 30);
  CHECK(in_seconds(first.t_w) == 10);
  CHECK(in_seconds(first.t_wait) == 22);
  CHECK(in_seconds(first.T_a) == 172 - 85);
  CHECK(cycles.completed() == 1);
  CHECK(in_seconds(cycles[1].t_v) == 0);
}

TEST_CASE("an AGV waits in its slot and in the spot until it has been loaded") {
  // AGV 0: loaded 80..90, out 90..120, back from 120, in a slot 140..145, in the spot from 150, loaded again 185..197.
  // AGV 1 stands in the way.
  Cycles cycles;
  cycles.begins(3, 0, 0);
  cycles.ends(3, 0, 80);
  cycles.begins(4, 1, 80);
  cycles.ends(4, 1, 90);
  cycles.begins(3, 0, 90);
  cycles.begins(5, 1, 90);
  cycles.ends(5, 1, 120);
  cycles.begins(6, 1, 120);
  cycles.agv_waits(0, true, 140);
  cycles.agv_waits(0, false, 145);
  cycles.agv_waits(0, true, 150);
  cycles.ends(6, 1, 150);
  CHECK(in_seconds(cycles[0].t6) == 30 - 5);  // moving up belongs to it, standing in the slot does not
  cycles.ends(3, 0, 185);
  cycles.begins(4, 1, 185);
  CHECK(in_seconds(cycles[0].t_w) == 5 + 35);
  CHECK_FALSE(cycles[0].T_a.has_value());
  cycles.ends(4, 1, 197);
  REQUIRE(cycles.size() == 2);
  // Equations (2) to (4): the whole way from 90, when it had been loaded, to 197.
  const report::CycleReport &first = cycles[0], &second = cycles[1];
  CHECK(in_seconds(first.t3) == 80);
  CHECK(in_seconds(first.t_v) == 0);
  CHECK(in_seconds(first.t4) == 10);
  CHECK(in_seconds(first.T_g) == 90);
  CHECK(in_seconds(first.t5) == 30);
  CHECK(in_seconds(first.t6) == 25);
  CHECK(in_seconds(first.t_w) == 40);
  CHECK(in_seconds(first.t_wait) == 52);
  CHECK(in_seconds(first.T_a) == 197 - 90);
  CHECK(in_seconds(second.t3) == 95);
  CHECK(in_seconds(second.t_v) == 0);
  CHECK(in_seconds(second.t4) == 12);
  CHECK(in_seconds(second.T_g) == 107);
}

TEST_CASE("the crane stands above the spot while an AGV that waited in a slot moves up") {
  // With two AGVs both may wait: AGV 1 in its slot from 30 to 60, then the crane from 65 until AGV 1 has come at 70.
  Cycles cycles;
  cycles.begins(3, 0, 0);
  cycles.ends(3, 0, 10);
  cycles.begins(4, 2, 10);
  cycles.ends(4, 2, 20);
  cycles.begins(3, 0, 20);
  cycles.begins(5, 2, 20);
  cycles.ends(5, 2, 22);
  cycles.begins(6, 2, 22);
  cycles.agv_waits(1, true, 30);
  cycles.agv_waits(1, false, 60);
  cycles.ends(3, 0, 65);
  cycles.agv_waits(1, true, 70);
  cycles.ends(6, 2, 70);
  cycles.begins(4, 2, 70);
  REQUIRE(cycles.size() == 2);
  CHECK(in_seconds(cycles[0].t_w) == 30);
  CHECK(in_seconds(cycles[0].t6) == 8 + 10);
  CHECK(in_seconds(cycles[1].t_v) == 5);
}

TEST_CASE("the interval of an AGV after a cycle") {
  using enum cmrc::Learning;
  struct Row {
    cmrc::Learning rule;
    std::int64_t present;
    unsigned agvs;
    double driving, t_w, t_v;
    std::int64_t expected;
  };
  const Row rows[] = {
      {off, 160, 1, 80, 40, 0, 160},
      {proportional, 160, 1, 80, 8, 0, 168},    // N* = 160 * 88 / 80 = 176, half the way: +8
      {proportional, 160, 1, 80, 40, 0, 176},   // +40 wanted, at most 10 %
      {proportional, 200, 1, 80, 0, 8, 190},    // N* = 200 * 72 / 80 = 180, half the way
      {proportional, 200, 2, 80, 0, 4, 190},    // two AGVs: t_v counts twice
      {proportional, 160, 1, 80, 0, 8, 160},    // not below N_a
      {proportional, 319, 1, 80, 40, 0, 320},   // not above N^_a,max
      {proportional, 160, 1, 80, 1.9, 0, 160},  // inside the dead band of 2 % of T_g = 100
      {unit, 160, 1, 80, 40, 0, 161},
      {unit, 170, 1, 80, 0, 40, 169},
  };
  for (const Row& row : rows) {
    CAPTURE(static_cast<int>(row.rule));
    CAPTURE(row.present);
    cmrc::Config::Scheduling scheduling;
    scheduling.learning = row.rule;
    const cmrc::AgvCycle cycle{0, seconds(row.driving), seconds(row.t_w), seconds(row.t_v), seconds(100)};
    CHECK(cmrc::learned_interval(scheduling, row.present, 160, row.agvs, cycle) == row.expected);
  }
}
