#include "plant/linkage.hpp"

#include <ida/ida.h>

#include <algorithm>
#include <cmath>

#include "plant/config.hpp"
#include "plant/math.hpp"
#include "plant/sundials.hpp"

namespace plant {
namespace {

constexpr double pull = 10.0;           // 1/s, Baumgarte's
constexpr std::size_t size = 8;         // 3 angles, 3 rates, 2 multipliers
constexpr std::size_t bodies = 4;       // jib, fly jib, tie bar, load

using Three = std::array<double, 3>;
using Matrix3 = std::array<Three, 3>;
using Two = std::array<double, 2>;

}  // namespace

struct Linkage::Model {
  LinkageParameters p;
  double torque = 0.0;
  double scale = 1.0;  // N per unit of a multiplier, so that all unknowns are of one size
  std::array<double, bodies> mass{};
  std::array<Three, bodies> arm{};  // a body's centre is a sum of these times e(angle), and for the tie bar its pivot
  Three inertia{};

  explicit Model(const LinkageParameters& parameters) : p(parameters) {
    mass = {p.jib_mass, p.fly_mass, p.tie_mass, p.load};
    arm = {{{0.5 * p.jib, 0, 0}, {p.jib, 0.5 * (p.fly - p.back), 0}, {0, 0, 0.5 * p.tie}, {p.jib, p.fly, 0}}};
    const double fly = p.fly + p.back;
    inertia = {p.jib_mass * p.jib * p.jib / 12, p.fly_mass * fly * fly / 12, p.tie_mass * p.tie * p.tie / 12};
    scale = gravity * (p.jib_mass + p.fly_mass + p.tie_mass + p.load);
  }

  Three loop_arm() const { return {p.jib, -p.back, -p.tie}; }

  Two loop(const Three& t) const {
    Two sum{-p.base_x, -p.base_z};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [s, c] = sin_cos(t[k]);
      sum[0] += loop_arm()[k] * c;
      sum[1] += loop_arm()[k] * s;
    }
    return sum;
  }
  // d loop / d angle, columns.
  std::array<Two, 3> loop_by(const Three& t) const {
    std::array<Two, 3> by{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [s, c] = sin_cos(t[k]);
      by[k] = {-loop_arm()[k] * s, loop_arm()[k] * c};
    }
    return by;
  }
  // What its second derivative has besides loop_by times the angles' second derivatives.
  Two loop_bias(const Three& t, const Three& w) const {
    Two sum{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [s, c] = sin_cos(t[k]);
      sum[0] -= loop_arm()[k] * c * w[k] * w[k];
      sum[1] -= loop_arm()[k] * s * w[k] * w[k];
    }
    return sum;
  }

  Matrix3 mass_matrix(const Three& t) const {
    Matrix3 m{};
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t b = 0; b < bodies; ++b) m[j][k] += mass[b] * arm[b][j] * arm[b][k] * cos(t[j] - t[k]);
      m[j][j] += inertia[j];
    }
    return m;
  }
  // h + g less the torque.
  Three rest(const Three& t, const Three& w) const {
    Three sum{-torque, 0.0, 0.0};
    for (std::size_t b = 0; b < bodies; ++b)
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) sum[j] += mass[b] * arm[b][j] * arm[b][k] * sin(t[j] - t[k]) * w[k] * w[k];
        sum[j] += mass[b] * gravity * arm[b][j] * cos(t[j]);
      }
    return sum;
  }

  // Rates of the two other bars per rate of the jib.
  Three ratio(const Three& t) const {
    const auto by = loop_by(t);
    const double det = by[1][0] * by[2][1] - by[2][0] * by[1][1];
    return {1.0, (-by[0][0] * by[2][1] + by[2][0] * by[0][1]) / det, (-by[1][0] * by[0][1] + by[0][0] * by[1][1]) / det};
  }

  // Accelerations and multipliers that fulfil both sets of equations.
  void accelerate(const Three& t, const Three& w, Three& wd, Two& lambda) const {
    // Along the loop's freedom: r^T (M wd + rest) = 0 with wd = r wd1 + bias part.
    const Three r = ratio(t);
    const auto by = loop_by(t);
    const Two gamma = loop_bias(t, w);
    const double det = by[1][0] * by[2][1] - by[2][0] * by[1][1];
    const Three free{0.0, (-gamma[0] * by[2][1] + by[2][0] * gamma[1]) / det, (-by[1][0] * gamma[1] + gamma[0] * by[1][1]) / det};
    const Matrix3 m = mass_matrix(t);
    const Three h = rest(t, w);
    double top = 0.0, bottom = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
      top -= r[j] * h[j];
      for (std::size_t k = 0; k < 3; ++k) {
        top -= r[j] * m[j][k] * free[k];
        bottom += r[j] * m[j][k] * r[k];
      }
    }
    for (std::size_t j = 0; j < 3; ++j) wd[j] = r[j] * top / bottom + free[j];
    Three left = h;  // = loop_by^T lambda; rows 1 and 2 give it
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) left[j] += m[j][k] * wd[k];
    lambda = {(left[1] * by[2][1] - left[2] * by[1][1]) / det, (left[2] * by[1][0] - left[1] * by[2][0]) / det};
  }

  static int residual(realtype, N_Vector y, N_Vector yd, N_Vector r, void* data) {
    const auto& self = *static_cast<const Model*>(data);
    const double* const v = NV_DATA_S(y);
    const double* const vd = NV_DATA_S(yd);
    double* const out = NV_DATA_S(r);
    const Three t{v[0], v[1], v[2]}, w{v[3], v[4], v[5]};
    const Matrix3 m = self.mass_matrix(t);
    const Three h = self.rest(t, w);
    const auto by = self.loop_by(t);
    const Two gamma = self.loop_bias(t, w), gap = self.loop(t);
    for (std::size_t j = 0; j < 3; ++j) {
      out[j] = vd[j] - w[j];
      double sum = h[j] / self.scale - by[j][0] * v[6] - by[j][1] * v[7];
      for (std::size_t k = 0; k < 3; ++k) sum += m[j][k] * vd[3 + k] / self.scale;
      out[3 + j] = sum;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      double sum = gamma[i] + pull * pull * gap[i];
      for (std::size_t k = 0; k < 3; ++k) sum += by[k][i] * (vd[3 + k] + 2.0 * pull * w[k]);
      out[6 + i] = sum;
    }
    return 0;
  }

  // d r / d y + c d r / d y' by differences, as IDA would make it, but without its temporary vectors.
  static int jacobian(realtype, realtype c, N_Vector y, N_Vector yd, N_Vector r, SUNMatrix j, void* data, N_Vector at, N_Vector atd, N_Vector there) {
    N_VScale(1.0, y, at);
    N_VScale(1.0, yd, atd);
    for (std::size_t k = 0; k < size; ++k) {
      double& v = NV_DATA_S(at)[k];
      double& vd = NV_DATA_S(atd)[k];
      const double before = v, before_d = vd;
      const double step = 1e-8 * std::max(1.0, std::fabs(before));
      v += step;
      vd += c * step;
      if (const int flag = residual(0.0, at, atd, there, data); flag != 0) return flag;
      v = before;
      vd = before_d;
      for (std::size_t i = 0; i < size; ++i)
        SM_ELEMENT_D(j, static_cast<sunindextype>(i), static_cast<sunindextype>(k)) = (NV_DATA_S(there)[i] - NV_DATA_S(r)[i]) / step;
    }
    return 0;
  }
};

// IDA with what it needs, made once: stepping allocates nothing.
struct Linkage::Solver {
  SundialsContext context;
  SundialsVector y{size, context}, yd{size, context};
  SundialsCall call;
  SundialsSolvers solvers;
  struct Memory {
    void* memory;
    ~Memory() { IDAFree(&memory); }
  } ida{IDACreate(context.context)};

  Solver(Model& model, double tolerance) {
    if (ida.memory == nullptr) throw std::runtime_error("plant: IDACreate failed");
    solvers.make_dense(size, y.vector, context);
    SundialsVector kind(size, context), absolute(size, context);
    for (std::size_t i = 0; i < size; ++i) {
      kind.data()[i] = i < 6 ? 1.0 : 0.0;
      absolute.data()[i] = tolerance * 0.1;
    }
    require(IDASetErrHandlerFn(ida.memory, keep_message, &call), call, "IDASetErrHandlerFn");
    require(IDAInit(ida.memory, &Model::residual, 0.0, y.vector, yd.vector), call, "IDAInit");
    require(IDASetUserData(ida.memory, &model), call, "IDASetUserData");
    require(IDASVtolerances(ida.memory, tolerance, absolute.vector), call, "IDASVtolerances");
    require(IDASetId(ida.memory, kind.vector), call, "IDASetId");
    require(IDASetSuppressAlg(ida.memory, SUNTRUE), call, "IDASetSuppressAlg");
    require(IDASetMaxNumSteps(ida.memory, 1'000'000), call, "IDASetMaxNumSteps");
    require(IDASetLinearSolver(ida.memory, solvers.linear, solvers.matrix), call, "IDASetLinearSolver");
    require(IDASetJacFn(ida.memory, &Model::jacobian), call, "IDASetJacFn");
  }

  // From y, yd as they stand.
  void run(double seconds) {
    require(IDAReInit(ida.memory, 0.0, y.vector, yd.vector), call, "IDAReInit");
    require(IDASetInitStep(ida.memory, std::min(1e-4, 0.1 * seconds)), call, "IDASetInitStep");
    require(IDASetStopTime(ida.memory, seconds), call, "IDASetStopTime");
    double reached = 0.0;
    require(IDASolve(ida.memory, seconds, &reached, y.vector, yd.vector, IDA_NORMAL), call, "IDASolve");
  }
};

Linkage::Linkage(const LinkageParameters& p, double tolerance) : model_(std::make_unique<Model>(p)) {
  for (const double x : {p.jib, p.jib_mass, p.fly, p.fly_mass, p.back, p.tie, p.tie_mass})
    if (!(x > 0.0 && std::isfinite(x))) throw std::invalid_argument(fmt::format("plant: lengths and masses of a linkage must be positive (got {})", x));
  if (!(p.load >= 0.0 && std::isfinite(p.load))) throw std::invalid_argument(fmt::format("plant: a linkage's load must not be negative (got {})", p.load));
  if (!(tolerance >= 1e-12 && tolerance <= 1e-3)) throw std::invalid_argument(fmt::format("plant: tolerance must be 1e-12 to 1e-3 (got {})", tolerance));
  solver_ = std::make_unique<Solver>(*model_, tolerance);
}
Linkage::~Linkage() = default;

void Linkage::place(double jib_angle, double jib_rate) {
  const LinkageParameters& p = model_->p;
  const auto [s, c] = sin_cos(jib_angle);
  // From the tie bar's pivot to the jib's end; tie bar and the fly jib's back span it as two sides of a triangle.
  const double x = p.jib * c - p.base_x, z = p.jib * s - p.base_z;
  const double span = std::sqrt(x * x + z * z);
  const double cosine = (span * span + p.back * p.back - p.tie * p.tie) / (2.0 * span * p.back);
  if (!(std::fabs(cosine) < 1.0))
    throw std::invalid_argument(fmt::format("plant: with the jib at {} rad the linkage does not close: {} m are to be spanned by {} and {} m",
                                            jib_angle, span, p.back, p.tie));
  const double toward = atan2(z, x);
  const double inside = atan2(std::sqrt(1.0 - cosine * cosine), cosine);
  const double fly = toward - inside;  // the back end lies above the jib, the nose hangs forward
  const auto [sf, cf] = sin_cos(fly);
  const Three angles{jib_angle, fly, atan2(z - p.back * sf, x - p.back * cf)};
  angle_ = angles;
  const Three r = model_->ratio(angles);
  for (std::size_t k = 0; k < 3; ++k) rate_[k] = r[k] * jib_rate;
  model_->torque = 0.0;
  Three wd{};
  model_->accelerate(angle_, rate_, wd, force_);
}

void Linkage::advance(double torque, double seconds) {
  if (!std::isfinite(torque)) throw std::invalid_argument("plant: the torque on a linkage must be a number");
  if (!(seconds >= 0.0 && seconds <= 3600.0)) throw std::invalid_argument(fmt::format("plant: a step of a linkage must be 0 to 3600 s (got {})", seconds));
  if (seconds == 0.0) return;
  Model& m = *model_;
  m.torque = torque;
  double* const y = solver_->y.data();
  double* const yd = solver_->yd.data();
  Three wd{};
  Two lambda{};
  m.accelerate(angle_, rate_, wd, lambda);
  for (std::size_t k = 0; k < 3; ++k) {
    y[k] = angle_[k];
    y[3 + k] = yd[k] = rate_[k];
    yd[3 + k] = wd[k];
  }
  for (std::size_t i = 0; i < 2; ++i) {
    y[6 + i] = lambda[i] / m.scale;
    yd[6 + i] = 0.0;
  }
  solver_->run(seconds);
  for (std::size_t k = 0; k < 3; ++k) {
    angle_[k] = y[k];
    rate_[k] = y[3 + k];
  }
  for (std::size_t i = 0; i < 2; ++i) force_[i] = y[6 + i] * m.scale;
}

std::array<double, 2> Linkage::nose() const {
  const LinkageParameters& p = model_->p;
  return {p.jib * cos(angle_[0]) + p.fly * cos(angle_[1]), p.jib * sin(angle_[0]) + p.fly * sin(angle_[1])};
}

double Linkage::open() const {
  const Two gap = model_->loop(angle_);
  return std::sqrt(gap[0] * gap[0] + gap[1] * gap[1]);
}

double Linkage::energy() const {
  const Matrix3 m = model_->mass_matrix(angle_);
  double sum = model_->p.tie_mass * gravity * model_->p.base_z;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 3; ++k) sum += 0.5 * rate_[j] * m[j][k] * rate_[k];
    for (std::size_t b = 0; b < bodies; ++b) sum += model_->mass[b] * gravity * model_->arm[b][j] * sin(angle_[j]);
  }
  return sum;
}

double Linkage::holding_torque() const {
  Model at = *model_;
  at.torque = 0.0;
  const Three g = at.rest(angle_, {});
  const Three r = at.ratio(angle_);
  return r[0] * g[0] + r[1] * g[1] + r[2] * g[2];
}

std::array<double, 2> Linkage::joint_force() const { return force_; }

}  // namespace plant
