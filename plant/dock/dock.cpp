#include "plant/dock/dock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plant/dock/dock_core.hpp"
#include "plant/dock/sensors.hpp"
#include "plant/dock/state_hash.hpp"
#include "plant/numerics/math.hpp"
#include "plant/parameters/check.hpp"
#include "state/visitor.hpp"

namespace plant {
namespace {

void require(bool good, const char* what) {
  if (!good) throw std::invalid_argument(fmt::format("plant: {}", what));
}

void set_bit(std::uint32_t& mask, std::size_t i, bool on) { mask = on ? mask | 1U << i : mask & ~(1U << i); }

std::int32_t rounded(double value) { return static_cast<std::int32_t>(std::floor(value + 0.5)); }

}  // namespace

const char* name(HandoverPhase phase) {
  switch (phase) {
    case HandoverPhase::free: return "free";
    case HandoverPhase::align: return "align";
    case HandoverPhase::landed: return "landed";
    case HandoverPhase::lock: return "lock";
    case HandoverPhase::tension: return "tension";
    case HandoverPhase::lift: return "lift";
  }
  return "unknown";
}

struct Dock::Implementation {
  DockCore core;
  Time called{0};  // latest t of a call

  explicit Implementation(const DockConfig& c) : core(c) {}

  void advance(Time t) {
    if (t < called)
      throw std::invalid_argument(fmt::format(
          "plant: a call at {} ps after one at {} ps; calls come in nondecreasing time", t.count(), called.count()));
    called = t;
    while (core.now() + latch_period <= t) core.step();
  }
  // Cubic Hermite interpolation over the latch interval, from positions and speeds at its ends.
  double joint_at(int joint, Time t) {
    advance(t);
    const auto j = check_joint(joint);
    const CraneState& a = core.state.crane;
    if (t == core.now()) return core.drum(a, j);
    const CraneState& b = core.ahead();
    const auto k = coordinate_of(j);
    const double u = static_cast<double>((t - core.now()).count()) / static_cast<double>(latch_period.count());
    const double w = 1.0 - u;
    return core.drum(a, j) * (w * w * (1.0 + 2.0 * u)) + core.drum(b, j) * (u * u * (3.0 - 2.0 * u)) +
           latch_seconds * (a.qd[k] * (u * w * w) - b.qd[k] * (u * u * w));
  }
  static std::size_t check_joint(int joint) {
    require(joint >= 0 && joint < joint_count, "joint must be 0..4");
    return static_cast<std::size_t>(joint);
  }
  AgvState& agv(int i) {
    require(i >= 0 && static_cast<std::size_t>(i) < core.state.agvs.size(), "there is no AGV of that number");
    return core.state.agvs[static_cast<std::size_t>(i)];
  }
  void push(int i, const AgvSetPoint& point, Time t) {
    AgvState& to = agv_at(i, t);
    if (!to.bumped && !AgvMotion::push(to, point)) core.report(t, EventKind::agv_overflow, i);
  }
  AgvState& agv_at(int i, Time t) {
    advance(t);
    return agv(i);
  }
};

Dock::Dock(const DockConfig& config) {
  check(config);
  self_ = std::make_unique<Implementation>(config);
}
Dock::~Dock() = default;

void Dock::advance_to(Time t) { self_->advance(t); }
Time Dock::time() const { return std::max(self_->called, self_->core.now()); }
Time Dock::next_event() const { return self_->core.now() + latch_period; }
const DockConfig& Dock::config() const { return self_->core.config; }

void Dock::set_torque_code(int joint, int code, Time t) {
  self_->advance(t);
  const std::size_t j = Implementation::check_joint(joint);
  self_->core.state.shadow[j] = std::clamp(code, -largest_torque_code - 1, largest_torque_code);
  self_->core.state.updated[j] = self_->core.state.latch;
}

void Dock::enable_drives(std::uint32_t mask, Time t) {
  self_->advance(t);
  DockState& state = self_->core.state;
  const std::uint32_t asked = mask & ((1U << joint_count) - 1U);
  // The time-out of a drive that has had no code yet begins here.
  for (std::size_t j = 0; j < joint_count; ++j)
    if (bit(asked & ~state.shadow_enable, j) && state.updated[j] == 0 && state.shadow[j] == 0)
      state.updated[j] = state.latch;
  state.shadow_enable = asked;
}

void Dock::fail_drive(int joint, bool failed, Time t) {
  self_->advance(t);
  set_bit(self_->core.state.failed_drives, Implementation::check_joint(joint), failed);
}

void Dock::fail_encoder(int joint, bool failed, Time t) {
  const std::int64_t shown = encoder_total(joint, t);
  const auto j = static_cast<std::size_t>(joint);
  self_->core.state.stuck_count[j] = shown;
  set_bit(self_->core.state.stuck_encoders, j, failed);
}

void Dock::fail_sway(int axis, bool failed, Time t) {
  sway(axis, t);
  set_bit(self_->core.state.stuck_sways, static_cast<std::size_t>(axis), failed);
}

std::int64_t Dock::encoder_total(int joint, Time t) {
  const double q = self_->joint_at(joint, t);
  const DockState& state = self_->core.state;
  if ((state.stuck_encoders >> joint & 1U) != 0) return state.stuck_count[static_cast<std::size_t>(joint)];
  return encoder_counts(q, self_->core.config.crane.drives[static_cast<std::size_t>(joint)]);
}

std::uint32_t Dock::encoder(int joint, Time t) {
  return static_cast<std::uint32_t>(encoder_total(joint, t)) & ((1U << encoder_bits) - 1U);
}

std::int32_t Dock::sway(int axis, Time t) {
  require(axis == 0 || axis == 1, "sway axis must be 0 or 1");
  self_->advance(t);
  return self_->core.state.sway_shown[static_cast<std::size_t>(axis)];
}

// ---- instruments

std::uint32_t Dock::drive_status(int joint, Time t) {
  self_->advance(t);
  return self_->core.drive_status(Implementation::check_joint(joint));
}

std::int32_t Dock::drive_speed(int joint, Time t) {
  self_->advance(t);
  return self_->core.drive_speed(Implementation::check_joint(joint));
}

std::uint32_t Dock::drive_trip(int joint, Time t) {
  self_->advance(t);
  return self_->core.drive_trip(Implementation::check_joint(joint));
}

std::int32_t Dock::drive_heat(int joint, Time t) {
  self_->advance(t);
  return self_->core.drive_heat(Implementation::check_joint(joint));
}

std::int32_t Dock::load_cell(Time t) {
  self_->advance(t);
  return self_->core.state.instruments.load_shown;
}

std::int32_t Dock::second_sway(int axis, Time t) {
  require(axis == 0 || axis == 1, "sway axis must be 0 or 1");
  require(config().sensors.second_sway, "this dock has one sway sensor");
  self_->advance(t);
  return self_->core.state.instruments.sway_shown[static_cast<std::size_t>(axis)];
}

std::int32_t Dock::wind_mean(Time t) {
  self_->advance(t);
  return self_->core.wind_mean(static_cast<double>(t.count()) * 1e-12);
}

void Dock::fail_drive_status(int joint, bool failed, Time t) {
  const std::uint32_t shown = drive_status(joint, t);
  const auto j = static_cast<std::size_t>(joint);
  self_->core.state.instruments.held_status[j] = failed ? shown : 0U;
  set_bit(self_->core.state.instruments.stuck_status, j, failed);
}

void Dock::fail_drive_speed(int joint, bool failed, Time t) {
  const std::int32_t shown = drive_speed(joint, t);
  const auto j = static_cast<std::size_t>(joint);
  self_->core.state.instruments.held_speed[j] = failed ? shown : 0;
  set_bit(self_->core.state.instruments.stuck_speeds, j, failed);
}

void Dock::fail_load_cell(bool failed, Time t) {
  self_->advance(t);
  self_->core.state.instruments.stuck_load = failed;
}

void Dock::fail_second_sway(int axis, bool failed, Time t) {
  second_sway(axis, t);
  set_bit(self_->core.state.instruments.stuck_sways, static_cast<std::size_t>(axis), failed);
}

void Dock::fail_anemometer(bool failed, Time t) {
  const std::int32_t shown = wind_mean(t);
  self_->core.state.instruments.held_wind = failed ? shown : 0;
  self_->core.state.instruments.stuck_wind = failed;
}

void Dock::spreader_command(std::uint32_t command, Time t) {
  self_->advance(t);
  self_->core.state.spreader_command = command & 1U;
}

std::uint32_t Dock::spreader_status(Time t) {
  self_->advance(t);
  const DockState& s = self_->core.state;
  const unsigned corners = s.landing.active && self_->core.accepted() ? s.landing.corners : 0U;
  return corners | (s.lock == Lock::locked ? spreader_locked : 0U) | (s.lock == Lock::open ? spreader_open : 0U);
}

// ---- scanner

std::int32_t Dock::scan_rows() const { return static_cast<std::int32_t>(config().layout.rows.size()); }

void Dock::select_row(std::int32_t row, Time t) {
  self_->advance(t);
  self_->core.state.row = std::clamp(row, 0, scan_rows() - 1);
}

std::int32_t Dock::scan_y(Time t) {
  self_->advance(t);
  return rounded(1e3 * config().layout.rows[static_cast<std::size_t>(self_->core.state.row)]);
}

std::int32_t Dock::scan_x0() const { return rounded(1e3 * config().layout.scan_x0); }
std::int32_t Dock::scan_dx() const { return rounded(1e3 * config().layout.scan_dx); }
std::int32_t Dock::scan_deck() const { return rounded(1e3 * config().layout.deck); }

std::int32_t Dock::profile(int i, Time t) {
  require(i >= 0 && i < scan_count, "the profile has samples 0..127");
  self_->advance(t);
  const DockCore& core = self_->core;
  const Layout& layout = core.config.layout;
  const double x = layout.scan_x0 + i * layout.scan_dx;
  const double z = bay_height(core.config, core.state, x - 0.5 * layout.scan_dx, x + 0.5 * layout.scan_dx,
                              layout.rows[static_cast<std::size_t>(core.state.row)]);
  return static_cast<std::int32_t>(std::floor(1e3 * z / scan_quantum)) * scan_quantum;
}

// ---- AGVs

int Dock::agv_count() const { return static_cast<int>(self_->core.state.agvs.size()); }
std::int32_t Dock::agv_x(int i, Time t) { return rounded(1e3 * self_->agv_at(i, t).y[A_X]); }
std::int32_t Dock::agv_y(int i, Time t) { return rounded(1e3 * self_->agv_at(i, t).y[A_Y]); }
std::int32_t Dock::agv_heading(int i, Time t) { return rounded(1e6 * wrap_angle(self_->agv_at(i, t).y[A_HEADING])); }
std::int32_t Dock::agv_speed(int i, Time t) { return rounded(1e3 * self_->agv_at(i, t).y[A_SPEED]); }

std::uint32_t Dock::agv_status(int i, Time t) {
  const AgvState& agv = self_->agv_at(i, t);
  return static_cast<std::uint32_t>(agv.waiting) | (agv.standing ? agv_standing : 0U) |
         (agv.container >= 0 ? agv_loaded : 0U) | (agv.dry ? agv_ran_dry : 0U) | (agv.bumped ? agv_bumper : 0U);
}

std::int32_t Dock::range_mount() const { return rounded(500.0 * config().agv.length); }

std::uint32_t Dock::range_scan(int i, Time t) {
  self_->agv_at(i, t);
  return self_->core.scan_number(static_cast<std::size_t>(i));
}

std::int32_t Dock::range_way(int i, Time t) {
  const AgvState& agv = self_->agv_at(i, t);
  const double free = self_->core.traffic.free_way(agv, self_->core.scan(static_cast<std::size_t>(i)));
  return free >= 1e-3 * range_most ? range_most : static_cast<std::int32_t>(std::floor(1e3 * free));
}

std::int32_t Dock::agv_range(int i, int ray, Time t) {
  require(ray >= 0 && ray < range_rays, "the range sensor has rays 0..179");
  self_->agv_at(i, t);
  return self_->core.scan(static_cast<std::size_t>(i))[static_cast<std::size_t>(ray)];
}

void Dock::agv_period(int i, std::uint32_t microseconds, Time t) {
  __extension__ using Wide = __int128;
  constexpr Wide million = 1'000'000;
  AgvState& agv = self_->agv_at(i, t);  // the unit counts in its own clock
  const Wide period = Wide{std::max(microseconds, 1000U)} * million * million /
                      (million + self_->core.unit_clock(static_cast<std::size_t>(i)).ppm);
  agv.period = Time{static_cast<std::int64_t>(period)};
}

void Dock::agv_push(int i, std::int32_t speed, std::int32_t front, std::int32_t rear, Time t) {
  const AgvParameters& p = config().agv;
  const auto steer = [&p](std::int32_t microradians) {
    return std::clamp(1e-6 * microradians, -p.steer_limit, p.steer_limit);
  };
  AgvSetPoint point{1e-3 * speed, steer(front), steer(rear)};
  if (p.drive == AgvDrive::differential) {
    const auto [sf, cf] = sin_cos(point.front);
    const auto [sr, cr] = sin_cos(point.rear);
    point.turn = point.speed * (sf / cf - sr / cr) / (p.front + p.rear);
  }
  self_->push(i, point, t);
}

void Dock::agv_push_wheels(int i, std::int32_t left, std::int32_t right, Time t) {
  require(config().agv.drive == AgvDrive::differential, "only AGVs with differential drive take wheel speeds");
  const double l = left, r = right;  // their sum may exceed 32 bits
  self_->push(i, {0.5e-3 * (l + r), 0.0, 0.0, 1e-3 * (r - l) / config().agv.track}, t);
}

void Dock::agv_reset_bumper(int i, Time t) { self_->agv_at(i, t).bumped = false; }

// ---- observers

const std::vector<Event>& Dock::events() const { return self_->core.events; }

std::vector<ContainerStatus> Dock::containers() const {
  const DockCore& core = self_->core;
  std::vector<ContainerStatus> all;
  const ShipPose ship = ship_at(core.config, core.state.containers, core.state.seconds());
  for (const ContainerData& c : core.state.containers) {
    const Solid solid = solid_of(c, -1, core.state.agvs, ship);
    all.push_back({c.state, c.agv, solid.x, solid.y, solid.top, solid.yaw, solid.tilt.axis(2), c.mass});
  }
  if (core.state.carried >= 0) {
    const Signal s = core.make_signal();
    auto& carried = all[static_cast<std::size_t>(core.state.carried)];
    carried.x = s.payload[0];
    carried.y = s.payload[1];
    carried.z = s.payload[2] + core.state.grip.top;
    carried.yaw = wrap_angle(s.yaw + core.state.grip.yaw);
    if (core.state.landing.active) carried.up = Frame(core.state.landing.body.turn).axis(2);
  }
  return all;
}

AgvSignal Dock::agv(int i) const {
  self_->agv(i);
  return self_->core.make_agv_signal(static_cast<std::size_t>(i));
}

Signal Dock::signal() const { return self_->core.make_signal(); }
Attitude Dock::attitude() const {
  const DockCore& core = self_->core;
  const ShipPose ship = ship_at(core.config, core.state.containers, core.state.seconds());
  return {core.state.landing.active ? Frame(core.state.landing.body.turn).axis(2) : Vector3{0.0, 0.0, 1.0}, ship.shift,
          ship.turn.axis(2)};
}
Place Dock::place() const { return self_->core.make_place(); }
const std::vector<Signal>& Dock::signals() const { return self_->core.signals; }
const std::vector<std::vector<AgvSignal>>& Dock::agv_signals() const { return self_->core.agv_signals; }
int Dock::delivered() const { return self_->core.state.delivered; }
bool Dock::faulted() const { return self_->core.state.faulted; }
std::uint32_t Dock::drives_on() const { return self_->core.state.enabled; }
bool Dock::braked() const { return drives_on() == 0; }
double Dock::payload_mass() const { return self_->core.landing.payload(self_->core.state).mass; }
Handover Dock::handover() const {
  const DockState& s = self_->core.state;
  const bool after = s.handover.phase == HandoverPhase::tension || s.handover.phase == HandoverPhase::lift;
  return {s.handover.phase, (s.carried >= 0) != after, s.handover.attempts};
}
const std::vector<PayloadChange>& Dock::switches() const { return self_->core.switches; }
double Dock::energy() const { return self_->core.energy(); }
void Dock::on_latch(std::function<void(Time, std::span<const int>)> f) { self_->core.on_latch = std::move(f); }
void Dock::on_event(std::function<void(const Event&)> f) { self_->core.on_event = std::move(f); }

// ---- state

std::shared_ptr<const DockState> Dock::snapshot() const { return std::make_shared<const DockState>(self_->core.state); }

void Dock::restore(const DockState& state) {
  const DockState& now = self_->core.state;
  if (state.agvs.size() != now.agvs.size() || state.containers.size() != now.containers.size() ||
      state.scans.size() != now.scans.size() || state.underway.size() != now.underway.size())
    throw std::invalid_argument(
        "plant: the snapshot is of a dock with other AGVs or containers, range sensors or delay of the drives");
  self_->core.state = state;
  self_->core.forget_ahead();
  self_->core.forget_scans();
  self_->called = self_->core.now();
}

void Dock::list_state(state::Visitor& list) {
  DockState state = self_->core.state;
  list("state", state);
  if (list.loads()) restore(state);
  list("called", self_->called);
  self_->core.list_records(list);
}

std::array<std::uint64_t, 2> Dock::state_hash() const { return hash(self_->core.state); }

}  // namespace plant
