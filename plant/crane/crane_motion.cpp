#include "plant/crane/crane_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "plant/numerics/math.hpp"

namespace plant {
namespace {

// A tenth of the tolerance on positions and speeds in m and rad.
std::array<double, CraneMotion::size> tolerances(double relative) {
  std::array<double, CraneMotion::size> absolute{};
  absolute.fill(relative * 0.1);
  return absolute;
}

// Unlike ==, distinguishes 0 from -0, whose sines differ.
template <class Values>
bool same_bits(const Values& a, const Values& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): bits are compared
}

}  // namespace

CraneMotion::CraneMotion(const CraneParameters& parameters, const Integrator::Settings& settings)
    : crane_(parameters),
      settings_(settings),
      absolute_(tolerances(settings.relative)),
      integrator_(settings, absolute_, &CraneMotion::derivative) {}

const Crane::Dynamics& CraneMotion::dynamics(const CraneVector& q, const CraneVector& qd, const CraneInputs& in) const {
  const bool same = known_ && known_->dynamics.mass.locked == in.locked && same_bits(known_->q, q) &&
                    same_bits(known_->qd, qd) && same_bits(known_->payload, in.payload);
  if (!same) known_.emplace(crane_, q, qd, in);
  return known_->dynamics;
}

CraneVector CraneMotion::applied_force(const CraneVector& q, const CraneVector& qd, const Joints& torque,
                                       const CraneInputs& in, const Crane::Dynamics& dynamics) const {
  const auto& p = crane_.parameters();
  CraneVector force = in.external;
  const Joints drives = crane_.drive_forces(torque, qd, in.sliding, dynamics);
#pragma GCC unroll 5
  for (std::size_t j = 0; j < joint_count; ++j) {
    const auto k = coordinate_of(j);
    if ((in.locked >> k & 1U) != 0) continue;
    const auto& drive = p.drives[j];
    force[k] += drives[j];
    // A slipping brake: full force above a thousandth of rated speed; below, it counts as holding.
    if (in.braked[j]) force[k] -= drive.brake * drive.rated_force() * tanh(qd[k] / (1e-3 * drive.rated_joint_speed()));
  }
  if (in.payload.mass > 0.0 && p.sway_damping > 0.0) {
    const double damping = crane_.sway_damping(q[Q_L], in.payload.mass);
    force[Q_ALPHA] -= damping * qd[Q_ALPHA];
    force[Q_BETA] -= damping * qd[Q_BETA];
  }
  return force;
}

void CraneMotion::begin(const CraneState& state, const CraneInputs& inputs) {
  inputs_ = &inputs;
  torque_ = state.torque;
}

double CraneMotion::Decay::operator()(double exponent) {
  for (const Known& known : known_)
    if (known.exponent == exponent) return known.value;
  Known& known = known_[oldest_];
  oldest_ = (oldest_ + 1) % known_.size();
  return (known = {exponent, exp(exponent)}).value;
}

// The first-order lag under a held command.
Joints CraneMotion::torque_at(double t) const {
  Joints torque;
  double lag = 0.0, left = 1.0;
#pragma GCC unroll 5
  for (std::size_t j = 0; j < joint_count; ++j) {
    const double goal = inputs_->command[j];
    torque[j] = goal;
    if (torque_[j] == goal) continue;
    if (const double own = crane_.parameters().drives[j].torque_lag; own != lag) {
      lag = own;
      left = decay_(-t / lag);
    }
    torque[j] += (torque_[j] - goal) * left;
  }
  return torque;
}

void CraneMotion::derivative(void* data, double t, const double* y, double* yd) {
  const auto& self = *static_cast<const CraneMotion*>(data);
  const CraneInputs& in = *self.inputs_;
  CraneVector q;
  CraneVector qd;
  std::copy_n(y, crane_size, q.begin());
  std::copy_n(y + crane_size, crane_size, qd.begin());
  const Crane::Dynamics& dynamics = self.dynamics(q, qd, in);
  const CraneVector qdd = Crane::acceleration(dynamics, self.applied_force(q, qd, self.torque_at(t), in, dynamics));
  std::copy(qd.begin(), qd.end(), yd);
  std::copy(qdd.begin(), qdd.end(), yd + crane_size);
  if (in.locked == 0) return;
  for (std::size_t k = 0; k < crane_size; ++k)
    if ((in.locked >> k & 1U) != 0) yd[k] = 0.0;
}

CraneMotion::Packed CraneMotion::pack(const CraneState& state) {
  Packed y;
  std::copy(state.q.begin(), state.q.end(), y.begin());
  std::copy(state.qd.begin(), state.qd.end(), y.begin() + crane_size);
  return y;
}

void CraneMotion::unpack(std::span<const double> y, CraneState& state) {
  std::copy_n(y.begin(), crane_size, state.q.begin());
  std::copy_n(y.begin() + crane_size, crane_size, state.qd.begin());
}

void CraneMotion::advance(CraneState& state, const CraneInputs& inputs, double seconds) {
  begin(state, inputs);
  Packed y = pack(state);
  integrator_.advance(this, y, seconds, state.step);
  unpack(y, state);
  state.torque = torque_at(seconds);
}

void CraneMotion::advance_fixed(CraneState& state, const CraneInputs& inputs, double seconds, double step) {
  begin(state, inputs);
  Packed y = pack(state);
  integrator_.advance_fixed(this, y, seconds, step);
  unpack(y, state);
  state.torque = torque_at(seconds);
}

void CraneMotion::root_values(void* data, double t, const double* y, double* values) {
  const auto& self = *static_cast<const CraneMotion*>(data);
  CraneState state;
  unpack({y, size}, state);
  state.torque = self.torque_at(t);
  std::fill_n(values, most_roots, 1.0);
  for (std::size_t i = 0; i < self.roots_.size(); ++i) values[i] = self.value(self.roots_[i], state, *self.inputs_);
}

double CraneMotion::value(const CraneRoot& root, const CraneState& state, const CraneInputs& in) const {
  switch (root.kind) {
    case CraneRoot::Kind::position: return state.q[root.index] - root.level;
    case CraneRoot::Kind::speed: return state.qd[root.index] - root.level;
    case CraneRoot::Kind::sticking: return std::fabs(sticking_force(state, in, root.index)) - root.level;
    case CraneRoot::Kind::tension:
      return crane_.tension(state.q, state.qd, acceleration(state, in), in.payload.mass) - root.level;
  }
  return 1.0;
}

double CraneMotion::advance_to(CraneState& state, const CraneInputs& inputs, double seconds,
                               std::span<const CraneRoot> roots, int& which) {
  if (!finder_)
    finder_ = std::make_unique<Integrator>(settings_, absolute_, &CraneMotion::derivative, &CraneMotion::root_values,
                                           static_cast<int>(most_roots));
  begin(state, inputs);
  roots_ = roots;
  Packed y = pack(state);
  std::array<int, most_roots> found{};
  const double reached = finder_->advance_to_root(this, y, seconds, state.step, found);
  unpack(y, state);
  state.torque = torque_at(reached);
  const auto first = std::find_if(found.begin(), found.end(), [](int direction) { return direction != 0; });
  which = first == found.end() ? -1 : static_cast<int>(first - found.begin());
  return reached;
}

void CraneMotion::booked_derivative(void* data, double t, const double* y, double* yd) {
  derivative(data, t, y, yd);
  const auto& self = *static_cast<const CraneMotion*>(data);
  const CraneInputs& in = *self.inputs_;
  CraneState state;
  unpack({y, size}, state);
  state.torque = self.torque_at(t);
  double* const rate = yd + size;
  std::fill_n(rate, booked_size - size, 0.0);
  for (std::size_t j = 0; j < joint_count; ++j) {
    const auto k = coordinate_of(j);
    if ((in.locked >> k & 1U) != 0) continue;
    const auto& drive = self.crane_.parameters().drives[j];
    const double power = drive.gear * state.torque[j] * state.qd[k];
    rate[0] += power;
    rate[1] += power - self.crane_.gear_force(j, state.torque[j], state.qd[k]) * state.qd[k];
  }
  // The power lost in the joints: the difference between the forces with and without losses.
  const CraneVector force =
      self.applied_force(state.q, state.qd, state.torque, in, self.dynamics(state.q, state.qd, in));
  for (std::size_t k = 0; k < crane_size; ++k) {
    if ((in.locked >> k & 1U) != 0) continue;
    rate[4] += in.external[k] * state.qd[k];
    const double power = force[k] * state.qd[k];
    if (k == Q_ALPHA || k == Q_BETA)
      rate[3] -= power - in.external[k] * state.qd[k];
    else
      rate[2] -= power - in.external[k] * state.qd[k];
  }
  rate[2] += rate[0] - rate[1];
}

Work CraneMotion::advance_booked(CraneState& state, const CraneInputs& inputs, double seconds) {
  std::array<double, booked_size> y{};
  if (!booker_) {
    std::array<double, booked_size> absolute{};
    std::copy(absolute_.begin(), absolute_.end(), absolute.begin());
    std::fill(absolute.begin() + size, absolute.end(), settings_.relative * 1e4);
    booker_ = std::make_unique<Integrator>(settings_, absolute, &CraneMotion::booked_derivative);
  }
  begin(state, inputs);
  const Packed start = pack(state);
  std::copy(start.begin(), start.end(), y.begin());
  booker_->advance(this, y, seconds, state.step);
  unpack({y.data(), size}, state);
  state.torque = torque_at(seconds);
  return {y[size], y[size + 1], y[size + 2], y[size + 3], y[size + 4], 0.0};
}

CraneVector CraneMotion::acceleration(const CraneState& state, const CraneInputs& in) const {
  const Crane::Dynamics& known = dynamics(state.q, state.qd, in);
  return Crane::acceleration(known, applied_force(state.q, state.qd, state.torque, in, known));
}

CraneVector CraneMotion::holding_force(const CraneState& state, const CraneInputs& in) const {
  CraneVector holding{};
  const Crane::Dynamics& known = dynamics(state.q, state.qd, in);
  const CraneVector force = applied_force(state.q, state.qd, state.torque, in, known);
  const CraneVector qdd = Crane::acceleration(known, force);
  const CraneMatrix m = crane_.mass_matrix(state.q, in.payload);
  const CraneVector h = crane_.bias(state.q, state.qd, in.payload);
  const CraneVector g = crane_.gravity_force(state.q, in.payload);
  for (std::size_t k = 0; k < crane_size; ++k) {
    if ((in.locked >> k & 1U) == 0) continue;
    double sum = h[k] + g[k] - force[k];
    for (std::size_t i = 0; i < crane_size; ++i) sum += m[k][i] * qdd[i];
    holding[k] = sum;
  }
  return holding;
}

double CraneMotion::sticking_force(const CraneState& state, const CraneInputs& in, std::size_t joint) const {
  return sticking_force(holding_force(state, in), state, joint);
}

double CraneMotion::sticking_force(const CraneVector& holding, const CraneState& state, std::size_t joint) const {
  return holding[coordinate_of(joint)] - crane_.gear_force(joint, state.torque[joint], 0.0);
}

void CraneMotion::stop(CraneState& state, const CraneInputs& inputs, std::size_t k) const {
  CraneVector& qd = state.qd;
  if (qd[k] == 0.0) return;
  const CraneMatrix m = crane_.mass_matrix(state.q, inputs.payload);
  CraneVector impulse{};
  impulse[k] = 1.0;
  const CraneVector response = Crane::solve(m, impulse, inputs.locked & ~(1U << k));
  const double scale = -qd[k] / response[k];
  for (std::size_t i = 0; i < crane_size; ++i) qd[i] += scale * response[i];
  qd[k] = 0.0;
}

CraneMotion::Slope CraneMotion::linearize(const CraneState& state, const CraneInputs& in) const {
  Slope slope{};
  const auto held = [&in](std::size_t k) { return (in.locked >> k & 1U) != 0; };
  const auto& p = crane_.parameters();
  const auto by = [&](std::size_t column, double step, auto&& variable) {
    for (const auto& [places, weight] : {std::pair{1.0, 8.0}, {-1.0, -8.0}, {2.0, -1.0}, {-2.0, 1.0}}) {
      CraneState moved = state;
      variable(moved) += places * step;
      const CraneVector qdd = acceleration(moved, in);
      for (std::size_t k = 0; k < crane_size; ++k) slope[crane_size + k][column] += weight * qdd[k] / (12.0 * step);
    }
  };
  for (std::size_t k = 0; k < crane_size; ++k) {
    if (held(k)) continue;
    slope[k][crane_size + k] = 1.0;
    by(k, 1e-3, [k](CraneState& s) -> double& { return s.q[k]; });
    // Fine against the speeds over which dry friction is smoothed.
    double fine = 1e-3;
    for (std::size_t j = 0; j < joint_count; ++j)
      if (coordinate_of(j) == k)
        fine = std::min(fine, 0.01 * p.drives[j].smooth_speed * p.drives[j].rated_joint_speed());
    by(crane_size + k, fine, [k](CraneState& s) -> double& { return s.qd[k]; });
  }
  for (std::size_t j = 0; j < joint_count; ++j)
    by(2 * crane_size + j, 1e-3 * p.drives[j].rated_torque, [j](CraneState& s) -> double& { return s.torque[j]; });
  return slope;
}

std::array<CraneMotion::Packed, 2> CraneMotion::sensitivity(const CraneState& state, const CraneInputs& inputs,
                                                            double seconds) const {
  // CVODES varies the payload's mass in place while it computes differences of the right-hand side.
  struct Varied {
    CraneMotion motion;
    CraneInputs inputs;
    double mass;
  } varied{{crane_.parameters(), settings_}, inputs, inputs.payload.mass};
  varied.motion.begin(state, varied.inputs);
  const auto f = [](void* model, double t, const double* y, double* yd) {
    auto& self = *static_cast<Varied*>(model);
    self.inputs.payload.mass = self.mass;
    derivative(&self.motion, t, y, yd);
  };
  Packed y = pack(state);
  std::array<Packed, 2> by{};
  by[1][Q_L] = 1.0;
  advance_sensitivity(settings_.relative, absolute_, f, &varied, y, by[0], by[1], varied.mass, state.q[Q_L], seconds);
  return by;
}

}  // namespace plant
