#pragma once
// The AGVs' steps of processes: legs, the queue at the dock, and the place of each AGV (ruling 11).
//
// One-way traffic: the loading spot under the crane is slot 0, slots 1.. are the queue behind it. The step "queue" ends
// in the loading spot; an AGV in a slot moves up as slots become free, as part of this step.
#include <cstdint>
#include <vector>

#include "cmrc/configuration/rows/process_table.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/point_chain.hpp"

namespace cmrc {

/// A piece of lane: a line or an arc, driven forward.
struct Lane {
  double x, y, heading, length, curvature, speed;
};

struct FleetJob {
  unsigned agvs = 1;
  std::vector<Lane> to_warehouse;  ///< from the loading spot
  std::vector<Lane> to_spot;       ///< from the warehouse to the loading spot
  double spot_x = 22, spot_y = 8, spot_heading = 0;
  double slot_spacing = 18;     ///< m
  double move_up_speed = 1.5;   ///< m/s
  double warehouse_take = 10;   ///< s
  double point_frequency = 50;  ///< f_a
  double refresh_frequency = 8000;
  std::int64_t interval = 160;  ///< N^_a at the start
  std::int64_t buffer_points = 2;
  bool driving = false;               ///< all AGVs begin with an empty round
  bool parked = false;                ///< avoidance is also loaded for vehicles that stand
  bool avoidance = false;             ///< obstacle avoidance is loaded
  std::int64_t avoidance_cycles = 0;  ///< length of a synthetic one
};

/// The empty round of the vehicle in `slot`, as one leg.
std::vector<Lane> round_from(const FleetJob& job, unsigned slot);

class Fleet {
 public:
  Fleet(const FleetJob& job, const Words& words);

  /// The AGVs start in slots 0, 1, ...
  void start(HostServices& services);
  /// Sends an AGV from its slot past the warehouse and back, at the speed of the slowest lane, so that vehicles keep
  /// their distances.
  void send_round(unsigned agv, HostServices& services);
  /// Begins a step; for "task" it only prepares what the block reads.
  void enter(unsigned agv, const Step& step, HostServices& services);
  /// Continues the step that was entered last: true when it is finished.
  bool done(unsigned agv, const Step& step, HostServices& services);
  /// A block of sub-processes 1 and 2 has ended.
  void finished(const Task& task, Word result, Word notify, HostServices& services);
  void dropped(const Task& task);
  void abandon(unsigned agv) { agvs_.at(agv).chain.abandon(); }
  void resume(unsigned agv) { agvs_.at(agv).chain.resume(); }
  void refresh(unsigned agv, HostServices& services) { agvs_.at(agv).chain.refresh(services); }

  /// The AGV is in a slot of the queue, or on its way to one.
  bool queued(unsigned agv) const { return !agvs_.at(agv).away; }
  unsigned slot(unsigned agv) const { return agvs_.at(agv).slot; }
  bool on_leg(unsigned agv, std::int64_t tick) const { return agvs_.at(agv).chain.under_way(tick); }
  bool moving_up(unsigned agv) const { return agvs_.at(agv).moving; }
  unsigned size() const { return static_cast<unsigned>(agvs_.size()); }
  const FleetJob& job() const { return job_; }
  /// N^_a of an AGV; learning changes it from the AGV's next leg on.
  std::int64_t interval(unsigned agv) const { return agvs_.at(agv).interval; }
  void set_interval(unsigned agv, std::int64_t interval) { agvs_.at(agv).next_interval = interval; }
  void list_state(state::Visitor& list);

 private:
  struct Agv {
    PointChain chain;
    unsigned slot = 0;    // its slot or destination; without meaning while away
    bool away = false;    // it has left the queue
    bool moving = false;  // within the step "queue": on its way to its slot
    std::int64_t interval = 160;
    std::int64_t next_interval = 160;
    std::int64_t until = 0;  // refresh at which the present step has lasted long enough
  };

  void write_leg(unsigned agv, Word leg, std::span<const Lane> lanes, HostServices& services);
  void begin_leg(unsigned agv, Word leg, std::span<const Lane> lanes, HostServices& services);
  void take_slot(unsigned agv);
  void move_up(unsigned agv, HostServices& services);
  bool in_spot(unsigned agv, HostServices& services);
  bool slot_taken(unsigned slot) const;
  unsigned first_free_slot() const;
  std::vector<Lane> lanes_to_slot(unsigned slot) const;

  FleetJob job_;
  const Words& words_;
  std::vector<Agv> agvs_;
};

}  // namespace cmrc
