#pragma once
// The dock in time: crane, AGVs, containers, their drives and sensors. It knows no controller.
//
// The dock advances lazily. Its grid is the drives' 8-kHz latch; its state depends on that grid and on what was
// written, never on the time of a read. Calls come in nondecreasing t. A write takes effect at the first latch strictly
// after its t; a read at t gives the sensor's value at t (encoders: interpolated to the instant and floored; sway: its
// own 100-Hz sample, 10 ms late).
//
// Inaccuracies: docs/plant.md, last section.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "plant/dock/dock_event.hpp"
#include "plant/dock/dock_values.hpp"
#include "plant/parameters/config.hpp"
#include "plant/parameters/device_codes.hpp"

namespace state {
class Visitor;
}

namespace plant {

struct DockState;  // everything that the dock's future depends on; plant/dock/state.hpp

class Dock {
 public:
  explicit Dock(const DockConfig&);  // throws std::invalid_argument saying which value is wrong
  ~Dock();
  Dock(const Dock&) = delete;
  Dock& operator=(const Dock&) = delete;

  void advance_to(Time);
  Time time() const;        // the time to which the dock has advanced
  Time next_event() const;  // its next latch
  const DockConfig& config() const;

  // ---- crane drives and sensors (units: c40_programs/include/devices.inc)
  void set_torque_code(int joint, int code,
                       Time);  // of torque_bits (clamped); largest_torque_code = the drive's maximum_torque()
  void enable_drives(std::uint32_t mask, Time);  // bit j; a disabled drive has no torque and its brake holds
  std::uint32_t encoder(int joint, Time);        // encoder_bits of encoder_total
  // A failed drive has no torque and its brake holds, whatever codes are written.
  void fail_drive(int joint, bool failed, Time);
  // A failed sensor keeps its value of this time.
  void fail_encoder(int joint, bool failed, Time);
  void fail_sway(int axis, bool failed, Time);
  std::int64_t encoder_total(int joint, Time);  // the same count since joint zero, without wrapping (for start-up)
  std::int32_t sway(int axis, Time);  // 0 alpha (radial), 1 beta (tangential); sway_codes = the sensor's range
  // Ready; fault (failed, tripped, or the dock's own fault); no torque code for drive_timeout; brake closed:
  // drive_ready ... drive_brake.
  std::uint32_t drive_status(int joint, Time);
  std::int32_t drive_speed(int joint, Time);  // the drive's own estimate of its motor's speed: rated_units = rated
  // The reason of its last trip, until the drive is switched on again: trip_overspeed, trip_saturation, trip_heat;
  // trip_warning: warmer than at rated torque.
  std::uint32_t drive_trip(int joint, Time);
  std::int32_t drive_heat(int joint, Time);  // its thermal model: rated_units is the heat at rated torque
  std::int32_t load_cell(Time);              // kg on the rope, in steps of 10; sampled with the sway
  std::int32_t second_sway(int axis, Time);  // as sway(), with its own noise
  std::int32_t wind_mean(Time);              // mm/s along the wind's direction, mean of the last 3 s
  void fail_drive_status(int joint, bool failed, Time);
  void fail_drive_speed(int joint, bool failed, Time);
  void fail_load_cell(bool failed, Time);
  void fail_second_sway(int axis, bool failed, Time);
  void fail_anemometer(bool failed, Time);
  void spreader_command(std::uint32_t, Time);  // 1 lock, 0 open
  std::uint32_t spreader_status(Time);         // spreader_corners, spreader_locked, spreader_open

  // ---- bay scanner, mm
  std::int32_t scan_rows() const;
  void select_row(std::int32_t row, Time);
  std::int32_t scan_y(Time);
  std::int32_t scan_x0() const;
  std::int32_t scan_dx() const;
  std::int32_t scan_deck() const;
  std::int32_t profile(
      int i,
      Time);  // 0 .. scan_count - 1: mean height of a cell scan_dx long of the selected row, floored to scan_quantum

  // ---- AGV units
  int agv_count() const;
  std::int32_t agv_x(int agv, Time);  // mm
  std::int32_t agv_y(int agv, Time);
  std::int32_t agv_heading(int agv, Time);  // microradians, -pi..pi
  std::int32_t agv_speed(int agv, Time);    // mm/s
  std::uint32_t agv_status(int agv, Time);  // agv_waiting ... agv_bumper
  // Range sensor in front of the vehicle, looking ahead in a horizontal plane: ray 0 .. range_rays - 1, from right to
  // left.
  std::int32_t agv_range(int agv, int ray,
                         Time);             // mm in steps of 8; range_most: nothing within range; 0: no valid echo
  std::uint32_t range_scan(int agv, Time);  // number of the scan that agv_range shows
  // mm from the vehicle's front to the nearest echo of that scan in its way, as the protective field computes it;
  // range_most: none.
  std::int32_t range_way(int agv, Time);
  std::int32_t range_mount() const;  // mm ahead of the vehicle's centre
  void agv_period(int agv, std::uint32_t microseconds, Time);
  // Speed mm/s, steering microradians; the machine keeps the first two registers and calls this at the write of the
  // third. A vehicle with differential drive makes the turn that these values would give a steered vehicle.
  void agv_push(int agv, std::int32_t speed, std::int32_t front, std::int32_t rear, Time);
  void agv_push_wheels(int agv, std::int32_t left, std::int32_t right, Time);  // mm/s, differential drive only
  // After a collision: resets the bumper; set-points are taken again.
  void agv_reset_bumper(int agv, Time);

  // ---- for observers (true values, no sensors)
  const std::vector<Event>& events() const;  // in order of time, since the start
  std::vector<ContainerStatus> containers() const;
  AgvSignal agv(int index) const;  // at the last latch
  Signal signal() const;           // at the last latch
  Place place() const;             // at the last latch
  Attitude attitude() const;       // at the last latch
  const std::vector<Signal>& signals()
      const;  // recorded each config.signal_decimation latches, in long runs less often
  const std::vector<std::vector<AgvSignal>>& agv_signals() const;  // same rows, per AGV
  int delivered() const;                                           // containers
  Handover handover() const;
  const std::vector<PayloadChange>& switches()
      const;  // records of every hand-over between levels and of every attach and detach
  bool faulted() const;
  std::uint32_t drives_on() const;  // bit j: drive j gives torque; else its brake is closed
  bool braked() const;              // no drive is on: brakes hold every joint, or stop it
  double payload_mass() const;      // kg on the rope, spreader included
  double energy() const;            // J, crane and payload, kinetic and potential
  void on_latch(std::function<void(Time, std::span<const int>)>);  // called after each latch, with the codes taken
  void on_event(std::function<void(const Event&)>);

  // ---- the complete state, at the last latch: restoring and continuing equals an uninterrupted run, bit for bit
  std::shared_ptr<const DockState> snapshot() const;
  void restore(const DockState&);  // of a dock with the same config
  // The same with the records so far: events, switches, signals. Loads into a dock with the same config.
  void list_state(state::Visitor& list);
  std::array<std::uint64_t, 2> state_hash() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

}  // namespace plant
