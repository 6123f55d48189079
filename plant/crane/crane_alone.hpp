#pragma once
// A crane without a dock, codes and latches. Motor torques in N m are held during a step; for controllers with their
// own loop.
#include <array>
#include <cstdint>
#include <vector>

#include "plant/crane/crane_events.hpp"
#include "plant/scene/wind.hpp"

namespace plant {

struct CraneAloneConfig {
  CraneParameters crane;
  CranePose home = {0.0, 12.0, 16.0, 14.0, 0.0};
  Payload load = {0.0, 0.0};  // in addition to the spreader: kg, kg m2
  bool rigid = false;         // level L0
  double tolerance = 1e-6;    // with order 4 a hundredth of an encoder count (docs/plant-python.md)
  Method method = Method::erk;
  int order = 4;             // of ERKStep, 3 to 5
  bool bookkeeping = false;  // State::work is computed: more states to integrate, so different bits
  SensorParameters sensors;
  WindParameters wind;
};

// Derivatives of the coordinates and speeds by the payload's mass (per kg) and by the rope's length at the start (per
// m).
struct CraneSensitivity {
  CraneVector q_by_mass, qd_by_mass, q_by_length, qd_by_length;
};

class CraneAlone {
 public:
  struct State {
    std::int64_t time = 0;  // ps
    CraneState crane;
    CraneInputs inputs;
    CraneModes modes;
    std::uint32_t faulted = 0;  // drives that were given a torque that is no number
    bool swung_out = false;     // a sway angle exceeded 40 degrees: all drives are off
    Work work;                  // since the last reset, with bookkeeping
  };
  struct Event {
    std::int64_t time;  // ps
    CraneEvent::Kind kind;
    int joint;
  };
  static constexpr double longest_step = 60.0;  // s

  explicit CraneAlone(const CraneAloneConfig&);
  // Advances by `seconds`, 0 to longest_step (0 changes nothing except a drive's fault). Torques beyond 1.5 x rated
  // saturate; a torque that is not finite faults its drive, whose brake closes until reset.
  void step(const Joints& torque, double seconds);
  void set_load(const Payload& load);  // in addition to the spreader; positions and speeds stay
  void reset(const CraneVector& q, const CraneVector& qd,
             const Joints& torque);  // the motors' torques, within their limits

  const State& state() const { return state_; }
  void restore(const State& state);
  const CraneAloneConfig& config() const { return config_; }
  const Crane& crane() const { return motion_.crane(); }
  CraneVector acceleration() const { return motion_.acceleration(state_.crane, state_.inputs); }
  const std::vector<Event>& events() const { return events_; }  // since the start or the last reset or restore
  double energy() const;                                        // J
  std::array<std::uint32_t, joint_count> encoders() const;      // 24-bit counters
  std::array<std::int32_t, 2> sway() const;                     // codes, 2048 = 10 degrees; of this instant
  // `state` may be the state of another crane with the same config. Throws std::invalid_argument in wind.
  CraneMotion::Slope linearize(const State& state) const;
  // By CVODES, over `seconds` from the present state with the torques held; the state does not change. Throws
  // std::invalid_argument in wind, without all drives, and when a joint reaches its end stop, sticks or breaks away
  // within this time.
  CraneSensitivity sensitivity(const Joints& torque, double seconds) const;

 private:
  void piece(double at, double seconds);
  void brake_off_drives();
  void refuse_wind() const;
  void refuse_events(const Joints& torque, double seconds) const;

  CraneAloneConfig config_;
  CraneMotion motion_;
  Wind wind_;
  State state_;
  std::vector<Event> events_;
  std::vector<CraneEvent> crane_events_;  // scratch
};

}  // namespace plant
