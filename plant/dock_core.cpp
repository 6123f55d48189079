#include "plant/dock_core.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plant/math.hpp"
#include "plant/sensors.hpp"
#include "plant/wind.hpp"

namespace plant {
namespace {

constexpr double seconds_per_latch = 125e-6;
constexpr std::int64_t clearance_latches = 8;  // how often the payload looks for what is below it

std::size_t coordinate_of(std::size_t joint) { return static_cast<std::size_t>(joint_coordinate[joint]); }

constexpr std::uint32_t slew_bit = 1U << static_cast<unsigned>(Joint::slew);

bool bit(std::uint32_t mask, std::size_t i) { return (mask >> i & 1U) != 0; }

}  // namespace

DockCore::DockCore(const DockConfig& c)
    : config(c), crane(c.crane, {c.method, 3, c.tolerance}), agv_motion(c.agv, c.tolerance * 10.0), traffic(c), landing(c) {
  state.crane.q = inverse_kinematics(config.crane, config.home);
  for (const ContainerPlace& place : config.layout.containers)
    state.containers.push_back({ContainerState::on_ship, -1, place.x, place.y, place.z, place.yaw, place.mass});
  for (int i = 0; i < config.agv_count; ++i) {
    const Pose at = start_of_agv(config.layout, i);
    AgvState agv;
    agv.y[A_X] = at.x;
    agv.y[A_Y] = at.y;
    agv.y[A_HEADING] = at.heading;
    state.agvs.push_back(agv);
  }
  agv_signals.resize(state.agvs.size());
  if (config.sensors.range_rate > 0.0) {
    state.scans.resize(state.agvs.size());
    for (std::size_t i = 0; i < state.agvs.size(); ++i) look(i);
  }
  state.inputs.payload = landing.payload(state);
  for (std::size_t j = 0; j < joint_count; ++j) state.inputs.locked |= 1U << coordinate_of(j);
  if (config.rigid) state.inputs.locked |= sway_coordinates;
  sample_sway();
  state.sway_shown = state.sway_sampled;
  begin_latch();
}

const CraneState& DockCore::ahead() {
  if (!ahead_) {
    ahead_ = {state.crane, state.inputs, state.modes};
    happenings_.clear();
    advance_with_events(crane, ahead_->crane, ahead_->inputs, ahead_->modes, seconds_per_latch, happenings_);
  }
  return ahead_->crane;
}

void DockCore::step() {
  ahead();
  state.crane = ahead_->crane;
  state.inputs = ahead_->inputs;
  state.modes = ahead_->modes;
  ahead_.reset();
  meet_happenings();
  ++state.latch;
  if (state.latch % agv_latches == 0) move_agvs();
  if (state.latch % tick_latches == 0) sample_sway();
  begin_latch();
}

void DockCore::meet_happenings() {
  for (const CraneHappening& happening : happenings_) {
    const Time time = now() + Time{std::llround(happening.at * 1e12)};
    switch (happening.kind) {
      case CraneHappening::Kind::limit: report(time, EventKind::joint_limit, happening.joint); break;
      case CraneHappening::Kind::stuck: report(time, EventKind::joint_stuck, happening.joint); break;
      case CraneHappening::Kind::slipped: report(time, EventKind::joint_slipped, happening.joint); break;
      case CraneHappening::Kind::swung_out:
        if (state.faulted) break;
        state.faulted = true;
        report(time, EventKind::fault, -1, state.crane.q[Q_ALPHA], state.crane.q[Q_BETA]);
        break;
      case CraneHappening::Kind::slack: break;  // the payload becomes a body then
    }
  }
}

void DockCore::begin_latch() {
  take_codes();
  check_limits();
  if (state.enabled != (1U << joint_count) - 1U) apply_brakes();
  check_fault();
  turn_locks();
  move_payload();
  if (state.landing.active || state.handover.phase != HandoverPhase::free) watch_handover(false);
  blow();
  if (config.signal_decimation > 0 && state.latch % config.signal_decimation == 0) {
    signals.push_back(make_signal());
    for (std::size_t i = 0; i < agv_signals.size(); ++i) agv_signals[i].push_back(make_agv_signal(i));
  }
  if (on_latch) on_latch(now(), state.code);
}

void DockCore::report(Time time, EventKind kind, int index, double first, double second) {
  events.push_back({time, kind, index, {first, second}});
  if (on_event) on_event(events.back());
}

// ---- drives

void DockCore::take_codes() {
  state.code = state.shadow;
  watch_updates();
  std::uint32_t enable = state.faulted ? 0U : state.shadow_enable & ~state.stopped & ~state.failed_drives;
  if (config.crane.machine == Machine::gantry) enable &= ~slew_bit;  // it does not slew
  for (std::size_t j = 0; j < joint_count; ++j) {
    const bool on = bit(enable, j);
    if (on && !bit(state.enabled, j)) {
      state.inputs.braked[j] = false;
      state.inputs.locked &= ~(1U << coordinate_of(j));
      state.modes.stuck &= ~(1U << j);
    } else if (!on && bit(state.enabled, j)) {
      state.inputs.braked[j] = true;
      state.inputs.sliding[j] = 0;
      state.modes.stuck &= ~(1U << j);  // what dry friction held, the brake holds from now on
    }
    state.inputs.command[j] = on ? state.code[j] / 2047.0 * config.crane.drives[j].maximum_torque() : 0.0;
  }
  state.enabled = enable;
}

// A drive that gets no torque code any more must not go on pushing with the last one.
void DockCore::watch_updates() {
  if (config.drive_timeout <= 0.0) return;
  const auto timeout = static_cast<std::int64_t>(std::llround(config.drive_timeout / seconds_per_latch));
  for (std::size_t j = 0; j < joint_count; ++j) {
    const bool silent = bit(state.shadow_enable, j) && state.latch - state.updated[j] > timeout;
    if (silent == bit(state.stopped, j)) continue;
    state.stopped ^= 1U << j;
    report(silent ? EventKind::drive_stopped : EventKind::drive_resumed, static_cast<int>(j));
  }
}

// A closed brake slips until the joint is almost still, then holds; too great a load makes it slip again.
void DockCore::apply_brakes() {
  CraneVector holding{};
  bool asked = false;
  // A gantry's psi is held by its build, not by a brake that could slip.
  const std::uint32_t unbraked = config.crane.machine == Machine::gantry ? state.enabled | slew_bit : state.enabled;
  for (std::size_t j = 0; j < joint_count; ++j) {
    if (bit(unbraked, j)) continue;
    const std::size_t k = coordinate_of(j);
    const DriveParameters& drive = config.crane.drives[j];
    if (!bit(state.inputs.locked, k)) {
      if (std::fabs(state.crane.qd[k]) > 1e-3 * drive.rated_joint_speed()) continue;
      crane.stop(state.crane, state.inputs, k);
      state.inputs.braked[j] = false;
      state.inputs.locked |= 1U << k;
      continue;
    }
    if (!asked) holding = crane.holding_force(state.crane, state.inputs);
    asked = true;
    if (std::fabs(holding[k]) > drive.brake * drive.rated_force()) {
      state.inputs.locked &= ~(1U << k);
      state.inputs.braked[j] = true;
    }
  }
}

void DockCore::check_limits() {
  for (std::size_t j = 0; j < joint_count; ++j) {
    const std::size_t k = coordinate_of(j);
    const double low = config.crane.lower[j];
    const double high = config.crane.upper[j];
    double& q = state.crane.q[k];
    if (q > low && q < high) {
      state.modes.at_limit &= ~(1U << j);
      continue;
    }
    if (!bit(state.modes.at_limit, j)) report(EventKind::joint_limit, static_cast<int>(j));
    state.modes.at_limit |= 1U << j;
    q = std::clamp(q, low, high);
    const double speed = state.crane.qd[k];
    if ((q <= low && speed < 0.0) || (q >= high && speed > 0.0)) crane.stop(state.crane, state.inputs, k);
  }
}

void DockCore::check_fault() {
  const auto& q = state.crane.q;
  if (state.faulted || state.landing.active || std::max(std::fabs(q[Q_ALPHA]), std::fabs(q[Q_BETA])) < widest_sway) return;
  state.faulted = true;
  report(EventKind::fault, -1, q[Q_ALPHA], q[Q_BETA]);
}

// ---- payload

// Near contact the landing puts the wind on the body itself.
void DockCore::blow() {
  if (!config.wind.blows() || state.landing.active) return;
  state.inputs.external = crane.crane().at_payload(state.crane.q, wind_force(config.wind, state.seconds()));
}

template <class Change>
auto DockCore::booked(EventKind kind, int container, Change change) {
  Switch entry{now(), kind, container, energy(), 0.0, momentum(), {}};
  const auto result = change();
  entry.energy_after = energy();
  entry.after = momentum();
  switches.push_back(entry);
  return result;
}

// The ideal rope holds only while it is taut and nothing is near.
void DockCore::watch_free_payload() {
  const double clearance = landing.clearance(state, crane.crane());
  if (clearance > config.landing.near) {
    const CraneVector qdd = crane.acceleration(state.crane, state.inputs);
    if (crane.crane().tension(state.crane.q, state.crane.qd, qdd, state.inputs.payload.mass) > 0.0) return;
  }
  const double jump = booked(EventKind::near_contact, state.carried, [this] { return landing.begin(state, crane); });
  report(EventKind::near_contact, -1, clearance, jump);
}

void DockCore::move_payload() {
  LandingState& near = state.landing;
  if (!near.active && state.latch % clearance_latches == 0) watch_free_payload();
  if (!near.active || state.latch < near.next) return;
  if (near.clear && state.latch % clearance_latches == 0) {
    const double clearance = landing.clearance(state, crane.crane());
    if (clearance > config.landing.away) {
      const double jump = booked(EventKind::free_again, state.carried, [this] { return landing.end(state, crane.crane()); });
      report(EventKind::free_again, -1, clearance, jump);
      return;
    }
  }
  const int latches = landing.latches_per_step(state, crane.crane());
  const Landing::Outcome outcome = landing.step(state, crane.crane(), latches * seconds_per_latch);
  near.next = state.latch + latches;
  near.clear = outcome.clear;
  if (outcome.touched) {
    report(EventKind::touch, -1, outcome.vertical, outcome.horizontal);
    const bool hard = outcome.vertical > config.landing.touch_speed || outcome.horizontal > config.landing.touch_sway;
    if (hard) report(EventKind::hard_landing, -1, outcome.vertical, outcome.horizontal);
    if (config.landing.strict) state.handover.accepted = !hard && std::fabs(landing.landing_error(state)[1]) <= config.landing.yaw_error;
  }
  if (near.corners == 0xF && accepted() && !near.landed) {
    near.landed = true;
    report(EventKind::landed);
  } else if (near.corners == 0 && near.landed && near.contacts == 0) {
    near.landed = near.touched = false;
    report(EventKind::lifted);
  }
}

void DockCore::watch_handover(bool turned) {
  const LandingState& near = state.landing;
  HandoverView view;
  view.body = near.active;
  view.contacts = near.contacts;
  view.seated = near.corners == 0xF && accepted();
  view.turning = state.lock == Lock::locking || state.lock == Lock::opening;
  view.turned = turned;
  // The clearance is asked for only where it decides: once a touch has let go.
  if (state.handover.touching && near.contacts == 0) view.clearance = landing.clearance(state, crane.crane());
  if (!watch(state.handover, view)) return;
  state.landing.touched = false;  // the next touch is one of its own
  const auto [distance, yaw] = landing.landing_error(state);
  report(EventKind::missed, state.handover.attempts, distance, yaw);
}

void DockCore::turn_locks() {
  const bool landed = state.landing.active && state.landing.corners == 0xF && accepted();
  const bool wants_lock = (state.spreader_command & 1U) != 0;
  const auto duration = static_cast<std::int64_t>(std::llround(config.landing.lock_time / seconds_per_latch));
  switch (state.lock) {
    case Lock::open:
    case Lock::locked:
      if (wants_lock == (state.lock == Lock::locked) || !landed) return;
      state.lock = wants_lock ? Lock::locking : Lock::opening;
      state.lock_done = state.latch + duration;
      return;
    case Lock::locking:
    case Lock::opening: break;
  }
  const bool locking = state.lock == Lock::locking;
  if (!landed || wants_lock != locking) {
    state.lock = locking ? Lock::open : Lock::locked;
    report(EventKind::refused);
    return;
  }
  if (state.latch < state.lock_done || state.latch < state.landing.next) return;
  if (locking) {
    state.lock = Lock::locked;
    const int taken = booked(EventKind::locked, state.carried, [this] { return landing.take(state); });
    switches.back().container = taken;
    report(EventKind::locked, taken);
    watch_handover(true);
    return;
  }
  state.lock = Lock::open;
  const int container = booked(EventKind::opened, state.carried, [this] { return landing.release(state); });
  watch_handover(true);
  report(EventKind::opened, container);
  if (container >= 0 && state.containers[static_cast<std::size_t>(container)].state == ContainerState::on_agv)
    report(EventKind::set_on_agv, container, state.containers[static_cast<std::size_t>(container)].agv);
}

// ---- AGVs

void DockCore::move_agvs() {
  for (AgvState& agv : state.agvs) agv_motion.advance(agv, agv_latches * seconds_per_latch);
  if (config.collisions) {
    collect_solids(config, state, -1, solids_);
    std::erase_if(solids_, [](const Solid& s) { return s.bottom >= 1.5; });  // above every vehicle, or carried by one
    traffic.collide(state.agvs, solids_, [this](std::size_t agv, int other, double speed) {
      report(EventKind::collision, static_cast<int>(agv), speed, other);
    });
  }
  for (std::size_t i = 0; i < state.agvs.size(); ++i) {
    AgvState& agv = state.agvs[i];
    if (state.latch % range_latches() == 0) look(i);
    if (AgvMotion::take_set_point(agv, now())) report(EventKind::agv_dry, static_cast<int>(i));
    if (state.latch % tick_latches == 0) {
      const double allowed = config.agv.protective_field ? traffic.allowed_speed(agv, scan(i)) : std::numeric_limits<double>::infinity();
      agv_motion.drive_tick(agv, allowed);
      serve_warehouse(i);
    }
  }
}

std::int64_t DockCore::range_latches() const {
  if (config.sensors.range_rate <= 0.0) return agv_latches;
  return std::max<std::int64_t>(1, std::llround(1.0 / (config.sensors.range_rate * agv_latches * seconds_per_latch))) * agv_latches;
}

const Geometry::Scan& DockCore::scan(std::size_t agv) {
  if (!state.scans.empty()) return state.scans[agv];
  fresh_.resize(state.agvs.size());
  Fresh& fresh = fresh_[agv];
  if (fresh.latch != state.latch) {
    collect_solids(config, state, state.agvs[agv].container, solids_);
    fresh = {state.latch, traffic.scan(state.agvs[agv], agv, solids_)};
  }
  return fresh.codes;
}

// A range sensor with a rate of its own samples; some rays bring nothing back.
void DockCore::look(std::size_t agv) {
  if (state.scans.empty()) return;
  collect_solids(config, state, state.agvs[agv].container, solids_);
  Geometry::Scan codes = traffic.scan(state.agvs[agv], agv, solids_);
  const std::int64_t number = state.latch / range_latches();
  for (std::size_t ray = 0; ray < codes.size(); ++ray)
    if (drops(config.sensors, agv, number * range_rays + static_cast<std::int64_t>(ray))) codes[ray] = 0;
  state.scans[agv] = codes;
}

void DockCore::serve_warehouse(std::size_t index) {
  AgvState& agv = state.agvs[index];
  const Layout& layout = config.layout;
  const double dx = agv.y[A_X] - layout.warehouse.x;
  const double dy = agv.y[A_Y] - layout.warehouse.y;
  const bool there = dx * dx + dy * dy <= layout.warehouse_radius * layout.warehouse_radius;
  if (!agv.standing || agv.container < 0 || !there) {
    agv.served_since = Time{-1};
    return;
  }
  if (agv.served_since.count() < 0) {
    agv.served_since = now();
    report(EventKind::agv_arrived, static_cast<int>(index));
  }
  if (now() - agv.served_since < Time{std::llround(layout.warehouse_take * 1e12)}) return;
  ContainerData& container = state.containers[static_cast<std::size_t>(agv.container)];
  container.state = ContainerState::delivered;
  container.agv = -1;
  ++state.delivered;
  report(EventKind::delivered, agv.container, static_cast<double>(index));
  agv.container = -1;
  agv.load_mass = agv.load_inertia = 0.0;
  agv.served_since = Time{-1};
}

// ---- sensors and observers

std::array<double, 2> DockCore::sway() const {
  const CraneVector& q = state.crane.q;
  if (!state.landing.active) return {q[Q_ALPHA], q[Q_BETA]};
  const Vector3 hang = landing.payload_position(state) - crane.crane().tip(q);
  const auto [s, c] = sin_cos(q[Q_PSI]);
  const double radial = c * hang[0] + s * hang[1];
  return {atan2(radial, -hang[2]), atan2(-s * hang[0] + c * hang[1], std::sqrt(radial * radial + hang[2] * hang[2]))};
}

void DockCore::sample_sway() {
  const auto angles = sway();
  const std::int64_t sample = state.latch / tick_latches;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (bit(state.stuck_sways, axis)) continue;
    state.sway_shown[axis] = state.sway_sampled[axis];
    state.sway_sampled[axis] = sway_code(angles[axis], config.sensors, static_cast<int>(axis), sample);
  }
}

double DockCore::drum(const CraneState& c, std::size_t joint) const {
  const double q = c.q[coordinate_of(joint)];
  return joint == static_cast<std::size_t>(Joint::hoist) ? q - state.stretch : q;
}

Signal DockCore::make_signal() const {
  Signal row{};
  const CraneState& c = state.crane;
  row.time = now();
  for (std::size_t j = 0; j < joint_count; ++j) {
    row.q[j] = drum(c, j);
    row.qd[j] = c.qd[coordinate_of(j)];
  }
  row.torque = c.torque;
  row.code = state.code;
  const auto angles = sway();
  row.alpha = angles[0];
  row.beta = angles[1];
  row.tip = crane.crane().tip(c.q);
  if (state.landing.active) {
    row.payload = landing.payload_position(state);
    row.yaw = landing.payload_yaw(state);
    row.tension = state.landing.tension;
    row.contact = state.landing.contacts > 0;
  } else {
    row.payload = crane.crane().payload_position(c.q);
    row.yaw = c.q[Q_PSI] + c.q[Q_KAPPA];
    row.tension = crane.crane().tension(c.q, c.qd, crane.acceleration(c, state.inputs), state.inputs.payload.mass);
  }
  return row;
}

AgvSignal DockCore::make_agv_signal(std::size_t index) const {
  const AgvState& a = state.agvs[index];
  const auto& y = a.y;
  return {y[A_X], y[A_Y], wrap_angle(y[A_HEADING]), y[A_SPEED], y[A_YAW_RATE], y[A_FRONT], y[A_REAR], a.current.speed};
}

Momentum DockCore::momentum() const {
  const CraneState& c = state.crane;
  const Crane& model = crane.crane();
  const Payload load = landing.payload(state);
  const LandingState& near = state.landing;
  const Vector3 velocity = near.active ? near.body.velocity : model.payload_velocity(c.q, c.qd);
  const Vector3 at = near.active ? landing.payload_position(state) : model.payload_position(c.q);
  const CraneMatrix bare = model.mass_matrix(c.q, {});
  Momentum sum{load.mass * velocity, load.inertia * (near.active ? near.body.spin[2] : c.qd[Q_PSI] + c.qd[Q_KAPPA]), 0.0, 0.0};
  for (std::size_t k = 0; k < crane_size; ++k) {
    sum.travel += bare[Q_S][k] * c.qd[k];
    sum.slewing += bare[Q_PSI][k] * c.qd[k];
  }
  sum.travel += sum.payload[0];
  sum.slewing += (at[0] - c.q[Q_S]) * sum.payload[1] - at[1] * sum.payload[0] + sum.spin;
  return sum;
}

double DockCore::energy() const {
  if (state.landing.active) return landing.energy(state, crane.crane());
  const CraneState& c = state.crane;
  return crane.crane().kinetic_energy(c.q, c.qd, state.inputs.payload) +
         crane.crane().potential_energy(c.q, state.inputs.payload);
}

}  // namespace plant
