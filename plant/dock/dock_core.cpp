#include "plant/dock/dock_core.hpp"

#include <cmath>

#include "plant/dock/sensors.hpp"
#include "plant/numerics/math.hpp"
#include "state/visitor.hpp"

namespace plant {
namespace {

template <class Row>
void keep_each_second(std::vector<Row>& rows) {
  for (std::size_t i = 0; 2 * i < rows.size(); ++i) rows[i] = rows[2 * i];
  rows.resize((rows.size() + 1) / 2);
}

}  // namespace
DockCore::DockCore(const DockConfig& c)
    : config(c),
      crane(c.crane, {c.method, 3, c.tolerance}),
      agv_motion(c.agv, c.tolerance * 10.0),
      traffic(c),
      landing(c),
      wind(c.wind) {
  state.crane.q = inverse_kinematics(config.crane, config.home);
  for (const ContainerPlace& place : config.layout.containers) {
    const bool on_ship = stands_on_ship(config.layout, place);
    state.containers.push_back({on_ship ? ContainerState::on_ship : ContainerState::on_ground, -1, place.x, place.y,
                                place.z, place.yaw, place.mass, on_ship});
  }
  for (int i = 0; i < config.agv_count; ++i) {
    const Pose at = start_of_agv(config.layout, i);
    AgvState agv;
    agv.y[A_X] = at.x;
    agv.y[A_Y] = at.y;
    agv.y[A_HEADING] = at.heading;
    state.agvs.push_back(agv);
  }
  state.underway.resize(static_cast<std::size_t>(config.drive_delay));
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
  state.instruments.sway_shown = state.instruments.sway_sampled;
  state.instruments.load_shown = state.instruments.load_sampled;
  begin_latch();
}

const CraneState& DockCore::ahead() {
  if (!ahead_) {
    Ahead& ahead = ahead_.emplace();
    ahead.crane = state.crane, ahead.inputs = state.inputs, ahead.modes = state.modes;
    crane_events_.clear();
    advance_with_events(crane, ahead.crane, ahead.inputs, ahead.modes, latch_seconds, crane_events_);
  }
  return ahead_->crane;
}

void DockCore::step() {
  ahead();
  state.crane = ahead_->crane;
  state.inputs = ahead_->inputs;
  state.modes = ahead_->modes;
  ahead_.reset();
  meet_crane_events();
  ++state.latch;
  if (state.latch % agv_latches == 0) move_agvs();
  const SampleClock& sway_clock = config.sensors.sway_clock;
  if (ticks_until(sway_clock, state.latch, tick_latches) > ticks_until(sway_clock, state.latch - 1, tick_latches))
    sample_sway();
  begin_latch();
}

void DockCore::meet_crane_events() {
  for (const CraneEvent& event : crane_events_) {
    const Time time = now() + Time{std::llround(event.at * 1e12)};
    switch (event.kind) {
      case CraneEvent::Kind::limit: report(time, EventKind::joint_limit, event.joint); break;
      case CraneEvent::Kind::stuck: report(time, EventKind::joint_stuck, event.joint); break;
      case CraneEvent::Kind::slipped: report(time, EventKind::joint_slipped, event.joint); break;
      case CraneEvent::Kind::swung_out:
        if (state.faulted) break;
        state.faulted = true;
        report(time, EventKind::fault, -1, state.crane.q[Q_ALPHA], state.crane.q[Q_BETA]);
        break;
      case CraneEvent::Kind::slack: break;  // the payload becomes a body then
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
  record_signals();
  if (on_latch) on_latch(now(), state.code);
}

void DockCore::record_signals() {
  if (config.signal_decimation == 0 || state.latch % (config.signal_decimation * signals_thinned_) != 0) return;
  if (signals.size() >= static_cast<std::size_t>(config.signal_rows_max)) {
    signals_thinned_ *= 2;
    keep_each_second(signals);
    for (auto& rows : agv_signals) keep_each_second(rows);
    if (state.latch % (config.signal_decimation * signals_thinned_) != 0) return;
  }
  signals.push_back(make_signal());
  for (std::size_t i = 0; i < agv_signals.size(); ++i) agv_signals[i].push_back(make_agv_signal(i));
}

void DockCore::list_records(state::Visitor& list) {
  list("events", events);
  list("switches", switches);
  list("signals", signals);
  list("agv_signals", agv_signals);
  list("signals_thinned", signals_thinned_);
}

void DockCore::report(Time time, EventKind kind, int index, double first, double second) {
  events.push_back({time, kind, index, {first, second}});
  if (on_event) on_event(events.back());
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
  const std::int64_t sample = ticks_until(config.sensors.sway_clock, state.latch, tick_latches);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (bit(state.stuck_sways, axis)) continue;
    state.sway_shown[axis] = state.sway_sampled[axis];
    state.sway_sampled[axis] =
        sway_code(angles[axis], config.sensors, axis == 0 ? Stream::sway_radial : Stream::sway_tangential, sample);
  }
  sample_instruments(sample);
}

double DockCore::drum(const CraneState& c, std::size_t joint) const {
  const double q = c.q[coordinate_of(joint)];
  return joint == static_cast<std::size_t>(Joint::hoist) ? q - state.stretch : q;
}

Place DockCore::make_place() const {
  const CraneState& c = state.crane;
  const auto angles = sway();
  Place place{{},
              angles[0],
              angles[1],
              state.landing.active ? landing.payload_position(state) : crane.crane().payload_position(c.q)};
  for (std::size_t j = 0; j < joint_count; ++j) place.q[j] = drum(c, j);
  return place;
}

Signal DockCore::make_signal() const {
  Signal row{};
  const CraneState& c = state.crane;
  const Place place = make_place();
  row.time = now();
  row.q = place.q;
  for (std::size_t j = 0; j < joint_count; ++j) row.qd[j] = c.qd[coordinate_of(j)];
  row.torque = c.torque;
  row.code = state.code;
  row.alpha = place.alpha;
  row.beta = place.beta;
  row.tip = crane.crane().tip(c.q);
  row.payload = place.payload;
  if (state.landing.active) {
    row.yaw = landing.payload_yaw(state);
    row.contact = state.landing.contacts > 0;
  } else {
    row.yaw = c.q[Q_PSI] + c.q[Q_KAPPA];
  }
  row.tension = tension();
  return row;
}

double DockCore::tension() const {
  if (state.landing.active) return state.landing.tension;
  const CraneState& c = state.crane;
  return crane.crane().tension(c.q, c.qd, crane.acceleration(c, state.inputs), state.inputs.payload.mass);
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
  Momentum sum{load.mass * velocity, load.inertia * (near.active ? near.body.spin[2] : c.qd[Q_PSI] + c.qd[Q_KAPPA]),
               0.0, 0.0};
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
