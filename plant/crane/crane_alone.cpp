#include "plant/crane/crane_alone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "plant/dock/sensors.hpp"
#include "plant/numerics/math.hpp"
#include "plant/parameters/check.hpp"

namespace plant {
namespace {

// Interval, s, between two checks of brakes and end stops, and in wind; and the interval if none of these acts.
constexpr double short_piece = 1e-3, long_piece = 1e-2;
constexpr std::int64_t sway_sample = 10'000'000'000;  // ps

void check(const CraneAloneConfig& config) {
  plant::check(config.crane);
  plant::check(config.wind);
  plant::check(config.sensors);
  refuse(!(config.tolerance >= 1e-13 && config.tolerance <= 1e-3), "tolerance must be 1e-13 to 1e-3", config.tolerance);
  refuse(config.order < lowest_order || config.order > highest_order, "order must be 3, 4 or 5", config.order);
}

}  // namespace

CraneAlone::CraneAlone(const CraneAloneConfig& config)
    : config_((check(config), config)),
      motion_(config.crane, {config.method, config.order, config.tolerance}),
      wind_(config.wind) {
  reset(inverse_kinematics(config.crane, config.home), {}, {});
  set_load(config.load);
}

void CraneAlone::set_load(const Payload& load) {
  refuse(!(load.mass >= 0.0 && load.mass <= config_.crane.rated_load), "the load must be 0 kg up to rated_load",
         load.mass);
  refuse(!(std::isfinite(load.inertia) && load.inertia >= 0.0), "the load's inertia must not be negative",
         load.inertia);
  state_.inputs.payload = {config_.crane.spreader_mass + load.mass, config_.crane.spreader_inertia + load.inertia};
}

void CraneAlone::reset(const CraneVector& q, const CraneVector& qd, const Joints& torque) {
  for (std::size_t k = 0; k < crane_size; ++k)
    refuse(!std::isfinite(q[k]) || !std::isfinite(qd[k]), "positions and speeds must be numbers",
           std::isfinite(q[k]) ? qd[k] : q[k]);
  for (std::size_t j = 0; j < joint_count; ++j) {
    const double most = config_.crane.drives[j].maximum_torque();
    refuse(!(std::fabs(torque[j]) <= most),
           fmt::format("the torque of {} at the start must be within {} N m",
                       joint_names(config_.crane.machine)[j].name, most)
               .c_str(),
           torque[j]);
    const double at = q[coordinate_of(j)];
    if (at < config_.crane.lower[j] || at > config_.crane.upper[j])
      throw std::invalid_argument(fmt::format("plant: {} = {} is outside its limits {} to {}",
                                              joint_names(config_.crane.machine)[j].name, at, config_.crane.lower[j],
                                              config_.crane.upper[j]));
  }
  for (const Coordinate sway : {Q_ALPHA, Q_BETA}) {
    refuse(std::fabs(q[sway]) >= widest_sway, "sway angles must be within 40 degrees", q[sway]);
    refuse(config_.rigid && (q[sway] != 0.0 || qd[sway] != 0.0), "a rigid crane does not sway", q[sway]);
  }
  const Payload payload = state_.inputs.payload;
  state_ = {};
  state_.inputs.payload = payload;
  state_.inputs.locked = config_.rigid ? sway_coordinates : 0U;
  if (config_.crane.machine == CraneKind::gantry) {
    refuse(std::fabs(q[Q_PSI] - 0.5 * std::numbers::pi) > 1e-9 || qd[Q_PSI] != 0.0,
           "a gantry does not slew: psi must be pi/2", q[Q_PSI]);
    state_.inputs.locked |= 1U << Q_PSI;
  }
  state_.modes.watch_rope = true;
  state_.crane.q = q;
  state_.crane.qd = qd;
  state_.crane.torque = state_.inputs.command = torque;
  events_.clear();
}

void CraneAlone::restore(const State& state) {
  state_ = state;
  events_.clear();
}

void CraneAlone::step(const Joints& torque, double seconds) {
  refuse(!(seconds >= 0.0 && seconds <= longest_step), "a step must be 0 to 60 s", seconds);
  for (std::size_t j = 0; j < joint_count; ++j) {
    if (!std::isfinite(torque[j])) state_.faulted |= 1U << j;
    const double most = config_.crane.drives[j].maximum_torque();
    const bool on = (state_.faulted >> j & 1U) == 0 && !state_.swung_out;
    state_.inputs.command[j] = on ? std::clamp(torque[j], -most, most) : 0.0;
  }
  const double start = static_cast<double>(state_.time) * 1e-12;
  const auto coarse = static_cast<std::int64_t>(std::ceil(seconds / long_piece - 1e-9));
  const double most = seconds / static_cast<double>(coarse);
  for (std::int64_t i = 0; i < coarse; ++i) {
    const bool quiet = !config_.wind.blows() && state_.faulted == 0 && !state_.swung_out && state_.modes.at_limit == 0;
    const auto pieces = quiet ? 1 : static_cast<std::int64_t>(std::ceil(most / short_piece - 1e-9));
    const double each = most / static_cast<double>(pieces);
    for (std::int64_t k = 0; k < pieces; ++k)
      piece(start + static_cast<double>(i) * most + static_cast<double>(k) * each, each);
  }
  state_.time += std::llround(seconds * 1e12);
}

void CraneAlone::piece(double at, double seconds) {
  if (config_.wind.blows()) {
    const CraneState& c = state_.crane;
    const bool container = state_.inputs.payload.mass > config_.crane.spreader_mass;
    state_.inputs.external = crane().at_payload(
        c.q, wind_.force(at, crane().payload_velocity(c.q, c.qd), c.q[Q_PSI] + c.q[Q_KAPPA], container));
  }
  if (state_.faulted != 0 || state_.swung_out) brake_off_drives();
  crane_events_.clear();
  advance_with_events(motion_, state_.crane, state_.inputs, state_.modes, seconds, crane_events_,
                      config_.bookkeeping ? &state_.work : nullptr);
  for (const CraneEvent& event : crane_events_) {
    events_.push_back({std::llround((at + event.at) * 1e12), event.kind, event.joint});
    if (event.kind != CraneEvent::Kind::swung_out) continue;
    state_.swung_out = true;
    state_.inputs.command = {};
  }
  rest_in_stops(motion_, state_.crane, state_.inputs, state_.modes);
}

// A closed brake slips until its joint is almost still, then it holds.
void CraneAlone::brake_off_drives() {
  for (std::size_t j = 0; j < joint_count; ++j) {
    const std::size_t k = coordinate_of(j);
    if ((state_.faulted >> j & 1U) == 0 && !state_.swung_out) continue;
    state_.modes.stuck &= ~(1U << j);  // from now on the brake holds the joint instead of dry friction
    if ((state_.inputs.locked >> k & 1U) != 0) continue;
    state_.inputs.braked[j] = true;
    state_.inputs.sliding[j] = 0;
    if (std::fabs(state_.crane.qd[k]) > 1e-3 * config_.crane.drives[j].rated_joint_speed()) continue;
    motion_.stop(state_.crane, state_.inputs, k);
    state_.inputs.braked[j] = false;
    state_.inputs.locked |= 1U << k;
  }
}

double CraneAlone::energy() const {
  const CraneState& c = state_.crane;
  return crane().kinetic_energy(c.q, c.qd, state_.inputs.payload) +
         crane().potential_energy(c.q, state_.inputs.payload);
}

std::array<std::uint32_t, joint_count> CraneAlone::encoders() const {
  std::array<std::uint32_t, joint_count> counts{};
  for (std::size_t j = 0; j < joint_count; ++j)
    counts[j] = static_cast<std::uint32_t>(encoder_counts(state_.crane.q[coordinate_of(j)], config_.crane.drives[j])) &
                ((1U << encoder_bits) - 1U);
  return counts;
}

std::array<std::int32_t, 2> CraneAlone::sway() const {
  const std::int64_t sample = state_.time / sway_sample;
  return {sway_code(state_.crane.q[Q_ALPHA], config_.sensors, Stream::sway_radial, sample),
          sway_code(state_.crane.q[Q_BETA], config_.sensors, Stream::sway_tangential, sample)};
}

// Derivatives of the motion exist, and the right-hand side alone gives them, if nothing acts between its grid points.
void CraneAlone::refuse_wind() const {
  refuse(config_.wind.blows(), "derivatives leave the wind out: a crane without wind is expected", config_.wind.mean);
}

void CraneAlone::refuse_events(const Joints& torque, double seconds) const {
  if (state_.faulted != 0 || state_.swung_out)
    throw std::invalid_argument("plant: sensitivities need all drives, but one is off; reset the crane first");
  CraneAlone ahead(config_);
  ahead.restore(state_);
  ahead.step(torque, seconds);
  for (const Event& event : ahead.events()) {
    static constexpr std::array names{"reaches its end stop", "sticks", "breaks away", "", "swings out"};
    if (event.kind == CraneEvent::Kind::slack) continue;
    const bool load = event.kind == CraneEvent::Kind::swung_out;
    throw std::invalid_argument(
        fmt::format("plant: sensitivities need a motion without events, but {} {} after {:.3f} s; expected is a time "
                    "that ends before (got {} s)",
                    load ? "the load" : joint_names(config_.crane.machine)[static_cast<std::size_t>(event.joint)].name,
                    names.at(static_cast<std::size_t>(event.kind)),
                    static_cast<double>(event.time - state_.time) * 1e-12, seconds));
  }
  if (ahead.state().modes.at_limit != 0)
    throw std::invalid_argument("plant: sensitivities need joints that are free, but one rests in its end stop");
}

CraneMotion::Slope CraneAlone::linearize(const State& state) const {
  refuse_wind();
  return motion_.linearize(state.crane, state.inputs);
}

CraneSensitivity CraneAlone::sensitivity(const Joints& torque, double seconds) const {
  refuse(!(seconds > 0.0 && seconds <= longest_step), "sensitivities need a time of more than 0, at most 60 s",
         seconds);
  refuse_wind();
  CraneInputs inputs = state_.inputs;
  for (std::size_t j = 0; j < joint_count; ++j) {
    refuse(!std::isfinite(torque[j]), "torques must be numbers", torque[j]);
    const double most = config_.crane.drives[j].maximum_torque();
    inputs.command[j] = std::clamp(torque[j], -most, most);
  }
  refuse_events(torque, seconds);
  CraneSensitivity out{};
  const auto [by_mass, by_length] = motion_.sensitivity(state_.crane, inputs, seconds);
  std::copy_n(by_mass.begin(), crane_size, out.q_by_mass.begin());
  std::copy_n(by_mass.begin() + crane_size, crane_size, out.qd_by_mass.begin());
  std::copy_n(by_length.begin(), crane_size, out.q_by_length.begin());
  std::copy_n(by_length.begin() + crane_size, crane_size, out.qd_by_length.begin());
  return out;
}

}  // namespace plant
