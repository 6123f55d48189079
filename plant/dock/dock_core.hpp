#pragma once
// The actions at each latch: dock_core.cpp has their order; dock_drives.cpp, dock_payload.cpp and dock_agvs.cpp have
// one part each. Private to the dock.
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "plant/dock/dock.hpp"
#include "plant/dock/state.hpp"
#include "plant/landing/landing.hpp"
#include "plant/scene/wind.hpp"
#include "plant/vehicles/traffic.hpp"

namespace plant {

inline bool bit(std::uint32_t mask, std::size_t i) { return (mask >> i & 1U) != 0; }

class DockCore {
 public:
  explicit DockCore(const DockConfig&);

  void step();                // to the next latch
  const CraneState& ahead();  // the crane at the next latch, integrated at the first call
  void meet_crane_events();   // the events of the interval that ends
  void report(Time, EventKind, int index = -1, double first = 0.0, double second = 0.0);
  void forget_ahead() { ahead_.reset(); }
  // The present scan of an AGV's range sensor.
  const Geometry::Scan& scan(std::size_t agv);
  void forget_scans() { fresh_.clear(); }
  std::uint32_t scan_number(std::size_t agv) const;
  SampleClock unit_clock(std::size_t agv) const {
    return agv < config.unit_clocks.size() ? config.unit_clocks[agv] : SampleClock{};
  }
  void list_records(state::Visitor& list);  // the records: they do not affect the dock
  Time now() const { return state.latch * latch_period; }
  Place make_place() const;
  Signal make_signal() const;
  AgvSignal make_agv_signal(std::size_t index) const;
  double energy() const;
  Momentum momentum() const;
  bool accepted() const { return !config.landing.strict || state.handover.accepted; }  // the landing's corners count
  double drum(const CraneState&, std::size_t joint) const;  // joint position as its encoder sees it
  // The instruments (dock_instruments.cpp) at the last latch.
  std::uint32_t drive_status(std::size_t joint) const;
  std::int32_t drive_speed(std::size_t joint) const;
  std::uint32_t drive_trip(std::size_t joint) const;  // dock_trips.cpp
  std::int32_t drive_heat(std::size_t joint) const;
  std::int32_t wind_mean(double seconds) const;

  DockConfig config;
  CraneMotion crane;
  AgvMotion agv_motion;
  Traffic traffic;
  Landing landing;
  mutable Wind wind;  // its cache changes no value
  DockState state;
  std::vector<Event> events;
  std::vector<PayloadChange> switches;
  std::vector<Signal> signals;
  std::vector<std::vector<AgvSignal>> agv_signals;
  std::function<void(Time, std::span<const int>)> on_latch;
  std::function<void(const Event&)> on_event;

 private:
  void begin_latch();  // everything that happens at the present latch
  void record_signals();
  void take_codes();
  void watch_updates();
  void protect_drives();  // dock_trips.cpp
  bool count_swings(std::size_t joint, bool on);
  void trip(std::size_t joint, Trip);
  void apply_brakes();
  void check_limits();
  void check_fault();
  void watch_free_payload();
  void move_payload();
  void blow();
  Vector3 wind_force() const;  // N on the load, as it is now
  void turn_locks();
  void watch_handover(bool turned);
  template <class Change>
  auto booked(EventKind, int container, Change);  // a change of the payload, with its effect on energy and momentum
  void move_agvs();
  void look(std::size_t agv);
  SampleClock range_clock(std::size_t agv) const {
    return agv < config.sensors.range_clocks.size() ? config.sensors.range_clocks[agv] : SampleClock{};
  }
  std::int64_t range_ticks(std::size_t agv, std::int64_t latch) const;  // scans of its range sensor until then
  void serve_warehouse(std::size_t agv);
  void sample_sway();
  void sample_instruments(std::int64_t sample);  // with the first sway sensor's
  std::array<double, 2> sway() const;
  double tension() const;  // N, sum of the falls
  void report(EventKind kind, int index = -1, double first = 0.0, double second = 0.0) {
    report(now(), kind, index, first, second);
  }

  // The crane at the next latch, and its events until then.
  struct Ahead {
    CraneState crane;
    CraneInputs inputs;
    CraneModes modes;
  };
  std::optional<Ahead> ahead_;
  std::vector<CraneEvent> crane_events_;
  // The scans of this latch that were computed, so that 180 reads cost one scan.
  struct Fresh {
    std::int64_t latch = -1;
    Geometry::Scan codes{};
  };
  std::vector<Fresh> fresh_;
  std::vector<Solid> solids_;
  std::int64_t signals_thinned_ = 1;  // the interval between two rows, in units of config.signal_decimation
};

}  // namespace plant
