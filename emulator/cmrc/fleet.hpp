#pragma once
// The AGVs' processes: 5 to the warehouse, 6 to the dock, 8 to the initial state; and who stands where (ruling 11).
//
// One-way traffic: the loading spot under the crane is slot 0, slots 1.. wait behind it. Process 6 ends in the loading spot; an AGV that
// has to wait in a slot moves up as slots become free, which belongs to process 6.
#include <cstdint>
#include <optional>
#include <vector>

#include "cmrc/chain.hpp"
#include "cmrc/consents.hpp"
#include "cmrc/crane.hpp"
#include "cmrc/desk.hpp"

namespace cmrc {

/// A piece of lane: a line or an arc, driven forward.
struct Lane {
  double x, y, heading, length, curvature, speed;
};

struct FleetJob {
  unsigned agvs = 1;
  std::vector<Lane> to_warehouse;   ///< from the loading spot
  std::vector<Lane> to_spot;        ///< from the warehouse to the loading spot
  double spot_x = 22, spot_y = 8, spot_heading = 0;
  double slot_spacing = 18;         ///< m
  double move_up_speed = 1.5;       ///< m/s
  double warehouse_take = 10;       ///< s
  double point_frequency = 50;      ///< f_a
  double refresh_frequency = 8000;
  std::int64_t interval = 160;      ///< N^_a at the start
  std::int64_t buffer_points = 2;
  bool avoidance = false;           ///< each AGV loads a block of sub-process 5 per planning point
  std::int64_t avoidance_cycles = 0;  ///< what a synthetic one is told
};

class Fleet : public Berth {
 public:
  Fleet(const FleetJob& job, const Words& words, Consents& consents);

  /// The AGVs stand in slots 0, 1, ...: the first one has consented to be loaded (item 15).
  void start(Desk& desk);
  void finished(const Task& task, Word result, Word notify, Desk& desk);
  void dropped(const Task& task);
  /// Process 4 has put a container on this AGV: it must go (process 5).
  void loaded(unsigned agv) { agvs_.at(agv).must_go = true; }
  void refresh(Desk& desk, bool crane_holds_container, std::optional<unsigned> loading);

  std::optional<unsigned> agv_in_spot() const override;
  unsigned size() const { return static_cast<unsigned>(agvs_.size()); }
  /// N^_a of an AGV, adapted by learning from its next leg on.
  std::int64_t interval(unsigned agv) const { return agvs_.at(agv).interval; }
  void set_interval(unsigned agv, std::int64_t interval) { agvs_.at(agv).next_interval = interval; }
  bool all_home() const;
  const PointChain& chain(unsigned agv) const { return agvs_.at(agv).chain; }

 private:
  enum class Motion { standing, to_warehouse, unloading, to_slot, home_plan, going_home, home };
  struct Agv {
    PointChain chain;
    Motion motion = Motion::standing;
    unsigned slot = 0;               // where it stands or is going; meaningless on the way to the warehouse
    std::int64_t interval = 160;
    std::int64_t next_interval = 160;
    std::int64_t until = 0;          // refresh at which the warehouse has taken the container
    bool must_go = false;            // loaded by process 4
    bool in_process_6 = false;
    bool want_home = false;
    std::int64_t avoidance_at = 0;   // next refresh at which an avoidance block is due
    bool avoidance_out = false;
  };

  void write_leg(unsigned agv, Word leg, std::span<const Lane> lanes, Desk& desk);
  void begin_leg(unsigned agv, Word leg, std::span<const Lane> lanes, Motion next, Desk& desk);
  void depart(unsigned agv, Desk& desk);
  void to_dock(unsigned agv, Desk& desk);
  void move_up(unsigned agv, Desk& desk);
  void arrived(unsigned agv, Desk& desk);
  bool goes_home(unsigned agv, bool crane_holds_container, std::optional<unsigned> loading) const;
  void go_home(unsigned agv, Desk& desk);
  static bool queued(const Agv& agv);
  bool slot_taken(unsigned slot) const;
  unsigned first_free_slot() const;
  std::vector<Lane> lanes_to_slot(unsigned slot) const;
  void avoidance(unsigned agv, Desk& desk);

  FleetJob job_;
  const Words& words_;
  Consents& consents_;
  std::vector<Agv> agvs_;
};

}  // namespace cmrc
