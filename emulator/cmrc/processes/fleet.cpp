#include "cmrc/processes/fleet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "cmrc/tasks/importance.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "plant/numerics/math.hpp"
#include "state/visitor.hpp"

namespace cmrc {
namespace {

constexpr double taken_margin = 0.5;  // s: the AGV stops a little later than its planner assumes

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

std::vector<Lane> round_from(const FleetJob& job, unsigned slot) {
  std::vector<Lane> lanes = job.to_warehouse;
  const double behind = slot * job.slot_spacing;
  if (behind > 0) {
    lanes.insert(lanes.begin(),
                 {job.spot_x - behind * plant::cos(job.spot_heading),
                  job.spot_y - behind * plant::sin(job.spot_heading), job.spot_heading, behind, 0, job.move_up_speed});
  }
  for (const Lane& lane : shortened(job.to_spot, behind)) lanes.push_back(lane);
  double slowest = lanes.back().speed;
  for (const auto* leg : {&job.to_warehouse, &job.to_spot})
    for (const Lane& lane : *leg) slowest = std::min(slowest, lane.speed);
  for (Lane& lane : lanes) lane.speed = slowest;
  return lanes;
}

Fleet::Fleet(const FleetJob& job, const Words& words) : job_(job), words_(words) {
  for (unsigned i = 0; i < job.agvs; ++i) {
    const Task trajectory = task_of(JobKind::trajectory_agv, words, i + 1),
               inverse = task_of(JobKind::inverse_agv, words, i + 1);
    Agv agv{.chain = PointChain(trajectory, inverse, job.buffer_points)};
    agv.slot = i;
    agv.interval = agv.next_interval = job.interval;
    agvs_.push_back(std::move(agv));
  }
}

void Fleet::start(HostServices& services) {
  for (unsigned i = 0; i < job_.agvs; ++i) {
    const Word area = words_.agv_area(i);
    services.write(area + words_.ag_step_time, ti_float(1 / job_.point_frequency));
    services.write(area + words_.ag_unit, words_.agv_unit + i * words_.agv_unit_words);
  }
}

void Fleet::send_round(unsigned index, HostServices& services) {
  begin_leg(index, 2, round_from(job_, agvs_[index].slot), services);
  agvs_[index].moving = true;
}

// ---- steps ----

void Fleet::enter(unsigned index, const Step& step, HostServices& services) {
  Agv& agv = agvs_[index];
  const auto hold = [&](double seconds) {
    agv.until = services.tick() + static_cast<std::int64_t>(std::ceil(seconds * job_.refresh_frequency));
  };
  switch (step.kind) {
    case Step::Kind::task:
      // Home is a place in the queue. The block cuts off the part of the lane behind the AGV.
      if (step.task != "home.agv") break;
      if (agv.away) take_slot(index);
      write_leg(index, 3, lanes_to_slot(agv.slot), services);
      break;
    case Step::Kind::leg:
      if (step.leg == 1) {
        agv.away = true;
        begin_leg(index, 1, job_.to_warehouse, services);
        services.agv_sent(index, agv.interval);
      } else {
        agv.chain.begin(0, agv.interval, services.tick());
      }
      break;
    case Step::Kind::queue:
      take_slot(index);
      begin_leg(index, 2, lanes_to_slot(agv.slot), services);
      agv.moving = true;
      break;
    case Step::Kind::hand_over: hold(job_.warehouse_take + taken_margin); break;
    case Step::Kind::hold: hold(step.seconds); break;
    default: throw std::logic_error("Fleet: a step of another robot");
  }
}

bool Fleet::done(unsigned index, const Step& step, HostServices& services) {
  Agv& agv = agvs_[index];
  switch (step.kind) {
    case Step::Kind::leg: return agv.chain.ended(services);
    case Step::Kind::queue: return in_spot(index, services);
    case Step::Kind::hand_over:
    case Step::Kind::hold: return services.tick() >= agv.until;
    default: throw std::logic_error("Fleet: a step of another robot");
  }
}

bool Fleet::in_spot(unsigned index, HostServices& services) {
  Agv& agv = agvs_[index];
  if (agv.moving) {
    if (!agv.chain.ended(services)) return false;
    agv.moving = false;
    services.agv_waits(index, true);
    return agv.slot == 0;
  }
  if (agv.slot > 0 && !slot_taken(agv.slot - 1)) move_up(index, services);
  return false;
}

void Fleet::write_leg(unsigned index, Word leg, std::span<const Lane> lanes, HostServices& services) {
  Agv& agv = agvs_[index];
  const Word area = words_.agv_area(index);
  agv.interval = agv.next_interval;
  const double period_us = static_cast<double>(agv.interval) / job_.refresh_frequency * 1e6;
  // check_job and fleet_of have refused longer ones.
  if (lanes.size() > words_.segments_max) throw std::logic_error("Fleet: a leg has too many pieces of lane");
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const Lane& lane = lanes[i];
    const std::array<Word, 6> words = {ti_float(lane.x),      ti_float(lane.y),         ti_float(lane.heading),
                                       ti_float(lane.length), ti_float(lane.curvature), ti_float(lane.speed)};
    services.write(
        area + words_.ag_segment + (leg - 1) * words_.leg_words + static_cast<Word>(i) * words_.segment_words, words);
  }
  services.write(area + words_.ag_segment_count + leg, static_cast<Word>(lanes.size()));
  const std::array<Word, 2> period = {static_cast<Word>(agv.interval), static_cast<Word>(std::lround(period_us))};
  services.write(area + words_.ag_point_ticks, period);
  // Clears what avoidance and the shift kept from the leg before.
  services.write(area + words_.ag_avoid_limit, std::vector<Word>(words_.ag_avoid_beside + 1 - words_.ag_avoid_limit));
  const std::array<Word, 2> start = {leg, 0};  // AG_LEG, AG_PRODUCED
  services.write(area + words_.ag_leg, start);
}

void Fleet::begin_leg(unsigned index, Word leg, std::span<const Lane> lanes, HostServices& services) {
  write_leg(index, leg, lanes, services);
  agvs_[index].chain.begin(0, agvs_[index].interval, services.tick());
}

std::vector<Lane> Fleet::lanes_to_slot(unsigned slot) const {
  return shortened(job_.to_spot, slot * job_.slot_spacing);
}

bool Fleet::slot_taken(unsigned slot) const {
  return std::any_of(agvs_.begin(), agvs_.end(), [slot](const Agv& agv) { return !agv.away && agv.slot == slot; });
}

unsigned Fleet::first_free_slot() const {
  // The queue has no gaps to overtake into: behind its last AGV.
  unsigned slot = 0;
  for (const Agv& agv : agvs_) {
    if (!agv.away) slot = std::max(slot, agv.slot + 1);
  }
  return slot;
}

void Fleet::take_slot(unsigned index) {
  agvs_[index].away = true;
  agvs_[index].slot = first_free_slot();
  agvs_[index].away = false;
}

void Fleet::move_up(unsigned index, HostServices& services) {
  Agv& agv = agvs_[index];
  const double behind = agv.slot * job_.slot_spacing;
  const Lane lane{job_.spot_x - behind * plant::cos(job_.spot_heading),
                  job_.spot_y - behind * plant::sin(job_.spot_heading),
                  job_.spot_heading,
                  job_.slot_spacing,
                  0,
                  job_.move_up_speed};
  --agv.slot;
  services.agv_waits(index, false);
  begin_leg(index, 2, std::span(&lane, 1), services);
  agv.moving = true;
}

// ---- finished blocks ----

void Fleet::finished(const Task& done, Word result, Word notify, HostServices& services) {
  PointChain& chain = agvs_.at(done.robot - 1).chain;
  if (done.kind == words_.program(JobKind::trajectory_agv)) {
    chain.trajectory_done((result & words_.end_of_leg) != 0, (notify & words_.must_inverse) != 0,
                          (notify & words_.must_trajectory) != 0);
  } else if (done.kind == words_.program(JobKind::inverse_agv)) {
    chain.inverse_done();
    chain.pushed(services.tick());
  }
}

void Fleet::dropped(const Task& lost) {
  PointChain& chain = agvs_.at(lost.robot - 1).chain;
  if (lost.kind == words_.program(JobKind::trajectory_agv))
    chain.lost_trajectory();
  else if (lost.kind == words_.program(JobKind::inverse_agv))
    chain.lost_inverse();
}

void Fleet::list_state(state::Visitor& list) { list("agvs", agvs_); }

}  // namespace cmrc
