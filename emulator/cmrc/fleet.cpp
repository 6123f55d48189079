#include "cmrc/fleet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cmrc/importance.hpp"
#include "cmrc/ti_float.hpp"

namespace cmrc {
namespace {

constexpr double taken_margin = 0.5;  // s, the AGV stands a little later than its planner thinks
constexpr std::size_t most_segments = 8;
constexpr Word segment_words = 8, leg_words = 64;

/// The lanes without their last `length` metres.
std::vector<Lane> shortened(std::vector<Lane> lanes, double length) {
  while (!lanes.empty() && length > 0) {
    if (lanes.back().length > length) {
      lanes.back().length -= length;
      return lanes;
    }
    length -= lanes.back().length;
    lanes.pop_back();
  }
  return lanes;
}

}  // namespace

Fleet::Fleet(const FleetJob& job, const Words& words, Consents& consents) : job_(job), words_(words), consents_(consents) {
  for (unsigned i = 0; i < job.agvs; ++i) {
    const Word area = words.agv_area(i);
    const Task trajectory{.x = task::trajectory, .y = robot_class::agv, .kind = words.kind_trajectory_agv, .robot = i + 1, .area = area};
    const Task inverse{.x = task::inverse, .y = robot_class::agv, .kind = words.kind_inverse_agv, .robot = i + 1, .area = area};
    Agv agv{.chain = PointChain(trajectory, inverse, job.buffer_points)};
    agv.slot = i;
    agv.interval = agv.next_interval = job.interval;
    agvs_.push_back(std::move(agv));
  }
}

void Fleet::start(Desk& desk) {
  for (unsigned i = 0; i < job_.agvs; ++i) {
    const Word area = words_.agv_area(i);
    desk.write(area + words_.ag_step_time, ti_float(1 / job_.point_frequency));
    desk.write(area + words_.ag_unit, words_.agv_unit + i * words_.agv_unit_words);
    consents_.give(5, 8, i);  // it is empty
    agvs_[i].avoidance_at = desk.tick() + job_.interval;  // all at once: the worst case (plant-and-bus.md 2.4)
  }
  consents_.give(6, 4, 0);
}

void Fleet::write_leg(unsigned index, Word leg, std::span<const Lane> lanes, Desk& desk) {
  Agv& agv = agvs_[index];
  const Word area = words_.agv_area(index);
  agv.interval = agv.next_interval;
  const double period_us = static_cast<double>(agv.interval) / job_.refresh_frequency * 1e6;
  const std::size_t count = std::min(lanes.size(), most_segments);
  for (std::size_t i = 0; i < count; ++i) {
    const Lane& lane = lanes[i];
    const std::array<Word, 6> words = {ti_float(lane.x), ti_float(lane.y), ti_float(lane.heading), ti_float(lane.length),
                                       ti_float(lane.curvature), ti_float(lane.speed)};
    desk.write(area + words_.ag_segment + (leg - 1) * leg_words + static_cast<Word>(i) * segment_words, words);
  }
  desk.write(area + words_.ag_segment_count + leg, static_cast<Word>(count));
  const std::array<Word, 2> period = {static_cast<Word>(agv.interval), static_cast<Word>(std::lround(period_us))};
  desk.write(area + words_.ag_point_ticks, period);
  const std::array<Word, 2> start = {leg, 0};  // AG_LEG, AG_PRODUCED
  desk.write(area + words_.ag_leg, start);
}

void Fleet::begin_leg(unsigned index, Word leg, std::span<const Lane> lanes, Motion next, Desk& desk) {
  write_leg(index, leg, lanes, desk);
  agvs_[index].chain.begin(0, agvs_[index].interval, desk.tick());
  agvs_[index].motion = next;
}

void Fleet::depart(unsigned index, Desk& desk) {
  agvs_[index].must_go = false;
  desk.process(5, true, index + 1);
  begin_leg(index, 1, job_.to_warehouse, Motion::to_warehouse, desk);
}

bool Fleet::queued(const Agv& agv) { return agv.motion != Motion::to_warehouse && agv.motion != Motion::unloading; }

std::vector<Lane> Fleet::lanes_to_slot(unsigned slot) const { return shortened(job_.to_spot, slot * job_.slot_spacing); }

bool Fleet::slot_taken(unsigned slot) const {
  return std::any_of(agvs_.begin(), agvs_.end(), [slot](const Agv& agv) { return queued(agv) && agv.slot == slot; });
}

unsigned Fleet::first_free_slot() const {
  // The queue has no gaps to overtake into: behind the last one.
  unsigned slot = 0;
  for (const Agv& agv : agvs_) {
    if (queued(agv)) slot = std::max(slot, agv.slot + 1);
  }
  return slot;
}

void Fleet::to_dock(unsigned index, Desk& desk) {
  Agv& agv = agvs_[index];
  agv.slot = first_free_slot();
  agv.in_process_6 = true;
  desk.process(6, true, index + 1);
  begin_leg(index, 2, lanes_to_slot(agv.slot), Motion::to_slot, desk);
}

void Fleet::move_up(unsigned index, Desk& desk) {
  Agv& agv = agvs_[index];
  const double behind = agv.slot * job_.slot_spacing;
  const Lane lane{job_.spot_x - behind * std::cos(job_.spot_heading), job_.spot_y - behind * std::sin(job_.spot_heading),
                  job_.spot_heading, job_.slot_spacing, 0, job_.move_up_speed};
  --agv.slot;
  begin_leg(index, 2, std::span(&lane, 1), Motion::to_slot, desk);
}

void Fleet::arrived(unsigned index, Desk& desk) {
  Agv& agv = agvs_[index];
  agv.motion = Motion::standing;
  if (agv.slot != 0) return;
  if (agv.in_process_6) desk.process(6, false, index + 1);
  agv.in_process_6 = false;
  consents_.give(6, 4, index);
}

bool Fleet::goes_home(unsigned index, bool crane_holds_container, std::optional<unsigned> loading) const {
  // Item 16: when the work is finished and the AGV is empty. A container in the crane still needs one.
  const Agv& agv = agvs_[index];
  if (!consents_.all(8, index) || crane_holds_container || loading || agv.must_go) return false;
  return agv.motion == Motion::standing;
}

void Fleet::go_home(unsigned index, Desk& desk) {
  Agv& agv = agvs_[index];
  consents_.consume(8, index);
  desk.process(8, true, index + 1);
  // Home is a place in the queue. The block cuts off what of the lane lies behind the AGV.
  if (agv.motion == Motion::unloading) agv.slot = first_free_slot();
  write_leg(index, 3, lanes_to_slot(agv.slot), desk);
  agv.want_home = true;
  agv.motion = Motion::home_plan;
}

void Fleet::finished(const Task& done, Word result, Word notify, Desk& desk) {
  if (done.robot == 0) return;
  Agv& agv = agvs_.at(done.robot - 1);
  if (done.kind == words_.kind_trajectory_agv) {
    agv.chain.trajectory_done((result & words_.end_of_leg) != 0, (notify & words_.must_inverse) != 0);
  } else if (done.kind == words_.kind_inverse_agv) {
    agv.chain.inverse_done();
    agv.chain.pushed(desk.tick());
  } else if (done.kind == words_.kind_home_agv) {
    agv.chain.begin(0, agv.interval, desk.tick());
    agv.motion = Motion::going_home;
  } else if (done.kind == words_.kind_avoidance) {
    agv.avoidance_out = false;
  }
}

void Fleet::dropped(const Task& lost) {
  if (lost.robot == 0) return;
  Agv& agv = agvs_.at(lost.robot - 1);
  if (lost.kind == words_.kind_trajectory_agv) agv.chain.lost_trajectory();
  else if (lost.kind == words_.kind_inverse_agv) agv.chain.lost_inverse();
  else if (lost.kind == words_.kind_home_agv) agv.want_home = true;
  else if (lost.kind == words_.kind_avoidance) agv.avoidance_out = false;
}

void Fleet::avoidance(unsigned index, Desk& desk) {
  Agv& agv = agvs_[index];
  if (!job_.avoidance || agv.motion == Motion::home || desk.tick() < agv.avoidance_at) return;
  if (agv.avoidance_out) return;
  agv.avoidance_at += agv.interval * ((desk.tick() - agv.avoidance_at) / agv.interval + 1);
  agv.avoidance_out = true;
  desk.load({.x = task::avoidance, .y = robot_class::agv, .kind = words_.kind_avoidance, .robot = index + 1,
             .area = words_.agv_area(index), .tick = static_cast<std::uint32_t>(desk.tick()),
             .argument = static_cast<std::uint32_t>(job_.avoidance_cycles)},
            desk.tick() + agv.interval);
}

void Fleet::refresh(Desk& desk, bool crane_holds_container, std::optional<unsigned> loading) {
  for (unsigned i = 0; i < agvs_.size(); ++i) {
    Agv& agv = agvs_[i];
    switch (agv.motion) {
      case Motion::standing:
        if (agv.must_go) depart(i, desk);
        else if (goes_home(i, crane_holds_container, loading)) go_home(i, desk);
        else if (agv.slot > 0 && !slot_taken(agv.slot - 1)) move_up(i, desk);
        break;
      case Motion::to_warehouse:
        if (!agv.chain.through(desk.tick())) break;
        agv.until = desk.tick() + static_cast<std::int64_t>(std::ceil((job_.warehouse_take + taken_margin) * job_.refresh_frequency));
        agv.motion = Motion::unloading;
        break;
      case Motion::unloading:
        if (desk.tick() < agv.until) break;
        desk.process(5, false, i + 1);
        consents_.give(5, 8, i);
        // Item 16: 8 replaces 6 when both may start.
        if (consents_.all(8, i) && !crane_holds_container && !loading) go_home(i, desk);
        else to_dock(i, desk);
        break;
      case Motion::to_slot:
        if (agv.chain.through(desk.tick())) arrived(i, desk);
        break;
      case Motion::home_plan:
        if (!agv.want_home) break;
        agv.want_home = false;
        desk.load({.x = task::home_agv, .y = robot_class::agv, .kind = words_.kind_home_agv, .robot = i + 1,
                   .area = words_.agv_area(i), .tick = static_cast<std::uint32_t>(desk.tick())}, std::nullopt);
        break;
      case Motion::going_home:
        if (!agv.chain.through(desk.tick())) break;
        desk.process(8, false, i + 1);
        agv.motion = Motion::home;
        break;
      case Motion::home: break;
    }
    if (agv.motion != Motion::standing && agv.motion != Motion::home) agv.chain.refresh(desk);
    avoidance(i, desk);
  }
}

std::optional<unsigned> Fleet::agv_in_spot() const {
  for (unsigned i = 0; i < agvs_.size(); ++i) {
    if (agvs_[i].motion == Motion::standing && agvs_[i].slot == 0 && !agvs_[i].must_go) return i;
  }
  return std::nullopt;
}

bool Fleet::all_home() const {
  return std::all_of(agvs_.begin(), agvs_.end(), [](const Agv& agv) { return agv.motion == Motion::home; });
}

}  // namespace cmrc
