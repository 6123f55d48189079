#include "plant/dock/state_hash.hpp"

#include <bit>
#include <concepts>
#include <type_traits>

namespace plant {
namespace {

class Hash {
 public:
  template <class... Values>
  void operator()(const Values&... values) {
    (add(values), ...);
  }
  std::array<std::uint64_t, 2> result() const { return {a_, b_}; }

 private:
  void word(std::uint64_t x) {
    a_ = (a_ ^ x) * 0x100000001B3ULL;
    a_ ^= a_ >> 29;
    b_ = std::rotl(b_ + x * 0x9E3779B97F4A7C15ULL, 31) * 0xBF58476D1CE4E5B9ULL;
  }
  void add(double x) { word(std::bit_cast<std::uint64_t>(x)); }
  void add(std::integral auto x) { word(static_cast<std::uint64_t>(x)); }
  template <class E>
    requires std::is_enum_v<E>
  void add(E x) {
    word(static_cast<std::uint64_t>(x));
  }
  void add(Time t) { word(static_cast<std::uint64_t>(t.count())); }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& all) {
    for (const T& x : all) add(x);
  }
  template <class T>
  void add(const std::vector<T>& all) {
    word(all.size());
    for (const T& x : all) add(x);
  }
  void add(const CraneState& s) { (*this)(s.q, s.qd, s.torque, s.step); }
  void add(const CraneInputs& s) {
    (*this)(s.command, s.braked, s.locked, s.payload.mass, s.payload.inertia, s.external);
  }
  void add(const InstrumentState& s) {
    (*this)(s.sway_shown, s.sway_sampled, s.load_shown, s.load_sampled, s.stuck_status, s.stuck_speeds, s.stuck_sways,
            s.stuck_load, s.stuck_wind, s.held_status, s.held_speed, s.held_wind);
  }
  void add(const ProtectionState& s) {
    (*this)(s.fast, s.saturated, s.end, s.since_swing, s.swings, s.heat, s.causes, s.tripped, s.warm, s.asked);
  }
  void add(const BodyState& s) { (*this)(s.position, s.turn, s.velocity, s.spin); }
  void add(const Grip& s) { (*this)(s.x, s.y, s.yaw, s.top); }
  void add(const LandingState& s) {
    (*this)(s.active, s.body, s.slack, s.next, s.touched, s.contacts, s.clear, s.tension, s.corners, s.landed);
  }
  void add(const ContainerData& s) {
    (*this)(s.state, s.agv, s.x, s.y, s.z, s.yaw, s.mass);
    if (!s.from_ship) word(1);
  }
  void add(const AgvSetPoint& s) {
    (*this)(s.speed, s.front, s.rear);
    if (s.turn != 0.0) add(s.turn);
  }
  void add(const AgvState& s) {
    (*this)(s.y, s.step, s.container, s.load_mass, s.load_inertia, s.fifo, s.waiting, s.current, s.period, s.due,
            s.running, s.dry, s.standing, s.reference, s.integral, s.command, s.served_since);
    if (s.bumped) word(1);
  }

  std::uint64_t a_ = 0xCBF29CE484222325ULL, b_ = 0x94D049BB133111EBULL;
};

}  // namespace

std::array<std::uint64_t, 2> hash(const DockState& s) {
  Hash h;
  h(s.latch, s.crane, s.inputs, s.stretch, s.shadow, s.code, s.shadow_enable, s.enabled, s.updated, s.stopped,
    s.failed_drives, s.stuck_encoders, s.stuck_sways, s.stuck_count, s.protection, s.spreader_command, s.lock,
    s.lock_done, s.carried, s.grip, s.landing, s.sway_shown, s.sway_sampled, s.instruments, s.containers, s.agvs, s.row,
    s.modes.at_limit, s.faulted, s.delivered);
  // Values that only some docks have are hashed only there, so that a dock without them keeps its hash.
  if (s.modes.stuck != 0 || s.inputs.sliding != decltype(s.inputs.sliding){}) h(s.modes.stuck, s.inputs.sliding);
  if (!s.underway.empty()) h(s.underway);
  if (!s.scans.empty()) h(s.scans);
  if (s.handover.attempts > 1 || s.handover.accepted)
    h(s.handover.phase, s.handover.attempts, s.handover.touching, s.handover.accepted);
  return h.result();
}

}  // namespace plant
