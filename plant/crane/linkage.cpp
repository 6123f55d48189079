#include "plant/crane/linkage.hpp"

#include <ida/ida.h>

#include <algorithm>
#include <cmath>

#include "plant/numerics/frame.hpp"
#include "plant/numerics/math.hpp"
#include "plant/numerics/sundials.hpp"
#include "plant/parameters/config.hpp"

#include <Eigen/LU>

namespace plant {
namespace {

constexpr double pull = 10.0;      // 1/s, Baumgarte's
constexpr std::size_t size = 8;    // 3 angles, 3 rates, 2 multipliers
constexpr std::size_t bodies = 4;  // jib, fly jib, tie bar, load

using Three = Eigen::Vector3d;
using Two = Eigen::Vector2d;
using LoopBy = Eigen::Matrix<double, 2, 3>;

Three three(const std::array<double, 3>& v) { return Three(v[0], v[1], v[2]); }
std::array<double, 3> plain(const Three& v) { return {v[0], v[1], v[2]}; }

}  // namespace

struct Linkage::Model {
  LinkageParameters p;
  double torque = 0.0;
  double scale = 1.0;  // N per unit of a multiplier, so that all unknowns are of one size
  std::array<double, bodies> mass{};
  std::array<Three, bodies> arm;  // a body's centre is a sum of these times e(angle), and for the tie bar its pivot
  Three inertia;

  explicit Model(const LinkageParameters& parameters) : p(parameters) {
    mass = {p.jib_mass, p.fly_mass, p.tie_mass, p.load};
    arm = {Three(0.5 * p.jib, 0, 0), Three(p.jib, 0.5 * (p.fly - p.back), 0), Three(0, 0, 0.5 * p.tie),
           Three(p.jib, p.fly, 0)};
    const double fly = p.fly + p.back;
    inertia = Three(p.jib_mass * p.jib * p.jib / 12, p.fly_mass * fly * fly / 12, p.tie_mass * p.tie * p.tie / 12);
    scale = gravity * (p.jib_mass + p.fly_mass + p.tie_mass + p.load);
  }

  // The bars of the loop as vectors, in columns; and d loop / d angle.
  void bars(const Three& t, LoopBy& along, LoopBy& by) const {
    const Three length(p.jib, -p.back, -p.tie);
    for (int k = 0; k < 3; ++k) {
      const auto [s, c] = sin_cos(t[k]);
      along.col(k) = length[k] * Two(c, s);
      by.col(k) = length[k] * Two(-s, c);
    }
  }
  Two loop(const Three& t) const {
    LoopBy along, by;
    bars(t, along, by);
    return along.rowwise().sum() - Two(p.base_x, p.base_z);
  }

  Matrix3 mass_matrix(const Three& t) const {
    Matrix3 turned, m = inertia.asDiagonal();
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) turned(j, k) = cos(t[j] - t[k]);
    for (std::size_t b = 0; b < bodies; ++b) m += mass[b] * (arm[b] * arm[b].transpose()).cwiseProduct(turned);
    return m;
  }
  // h + g minus the torque.
  Three rest(const Three& t, const Three& w) const {
    Matrix3 turned;
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) turned(j, k) = sin(t[j] - t[k]);
    const Three square = w.cwiseProduct(w), level(cos(t[0]), cos(t[1]), cos(t[2]));
    Three sum(-torque, 0.0, 0.0);
    for (std::size_t b = 0; b < bodies; ++b) {
      sum += mass[b] * (arm[b] * arm[b].transpose()).cwiseProduct(turned) * square;
      sum += mass[b] * gravity * arm[b].cwiseProduct(level);
    }
    return sum;
  }

  // Rates of the two other bars per rate of the jib.
  Three ratio(const Three& t) const {
    LoopBy along, by;
    bars(t, along, by);
    const Two others = by.rightCols<2>().inverse() * -by.col(0);
    return Three(1.0, others[0], others[1]);
  }

  // Accelerations and multipliers that fulfil both sets of equations.
  void accelerate(const Three& t, const Three& w, Three& wd, Two& lambda) const {
    LoopBy along, by;
    bars(t, along, by);
    const Eigen::Matrix2d inverse = by.rightCols<2>().inverse();
    const Two others = inverse * -by.col(0), bias = inverse * (along * w.cwiseProduct(w));
    const Three r(1.0, others[0], others[1]), free(0.0, bias[0], bias[1]);
    // Along the loop's freedom: r^T (M wd + rest) = 0 with wd = r wd1 + bias part.
    const Matrix3 m = mass_matrix(t);
    const Three h = rest(t, w);
    wd = r * (-r.dot(h + m * free) / r.dot(m * r)) + free;
    const Three left = h + m * wd;  // = loop_by^T lambda; rows 1 and 2 give it
    lambda = inverse.transpose() * left.tail<2>();
  }

  static int residual(realtype, N_Vector y, N_Vector yd, N_Vector r, void* data) {
    const auto& self = *static_cast<const Model*>(data);
    const double* const v = NV_DATA_S(y);
    const double* const vd = NV_DATA_S(yd);
    double* const out = NV_DATA_S(r);
    const Three t(v[0], v[1], v[2]), w(v[3], v[4], v[5]), wd(vd[3], vd[4], vd[5]);
    const Two multiplier(v[6], v[7]);
    LoopBy along, by;
    self.bars(t, along, by);
    const Two gap = along.rowwise().sum() - Two(self.p.base_x, self.p.base_z);
    Eigen::Map<Eigen::Matrix<double, size, 1>> all(out);
    all.head<3>() = Three(vd[0], vd[1], vd[2]) - w;
    all.segment<3>(3) = (self.mass_matrix(t) * wd + self.rest(t, w)) / self.scale - by.transpose() * multiplier;
    all.tail<2>() = by * (wd + 2.0 * pull * w) + pull * pull * gap - along * w.cwiseProduct(w);
    return 0;
  }

  // d r / d y + c d r / d y' by differences, as IDA computes it, but without temporary vectors.
  static int jacobian(realtype, realtype c, N_Vector y, N_Vector yd, N_Vector r, SUNMatrix j, void* data, N_Vector at,
                      N_Vector atd, N_Vector there) {
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
        SM_ELEMENT_D(j, static_cast<sunindextype>(i), static_cast<sunindextype>(k)) =
            (NV_DATA_S(there)[i] - NV_DATA_S(r)[i]) / step;
    }
    return 0;
  }
};

// IDA and its objects, made once: stepping allocates nothing.
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

  // From the present y, yd.
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
    if (!(x > 0.0 && std::isfinite(x)))
      throw std::invalid_argument(fmt::format("plant: lengths and masses of a linkage must be positive (got {})", x));
  if (!(p.load >= 0.0 && std::isfinite(p.load)))
    throw std::invalid_argument(fmt::format("plant: a linkage's load must not be negative (got {})", p.load));
  if (!(tolerance >= 1e-12 && tolerance <= 1e-3))
    throw std::invalid_argument(fmt::format("plant: tolerance must be 1e-12 to 1e-3 (got {})", tolerance));
  solver_ = std::make_unique<Solver>(*model_, tolerance);
}
Linkage::~Linkage() = default;

void Linkage::place(double jib_angle, double jib_rate) {
  const LinkageParameters& p = model_->p;
  const auto [s, c] = sin_cos(jib_angle);
  // From the tie bar's pivot to the jib's end; tie bar and the fly jib's back are the other two sides of this triangle.
  const double x = p.jib * c - p.base_x, z = p.jib * s - p.base_z;
  const double span = std::sqrt(x * x + z * z);
  const double cosine = (span * span + p.back * p.back - p.tie * p.tie) / (2.0 * span * p.back);
  if (!(std::fabs(cosine) < 1.0))
    throw std::invalid_argument(
        fmt::format("plant: with the jib at {} rad the linkage does not close: {} m are to be spanned by {} and {} m",
                    jib_angle, span, p.back, p.tie));
  const double toward = atan2(z, x);
  const double inside = atan2(std::sqrt(1.0 - cosine * cosine), cosine);
  const double fly = toward - inside;  // the back end is above the jib, the nose hangs forward
  const auto [sf, cf] = sin_cos(fly);
  const Three angles(jib_angle, fly, atan2(z - p.back * sf, x - p.back * cf));
  const Three rates = model_->ratio(angles) * jib_rate;
  angle_ = plain(angles);
  rate_ = plain(rates);
  model_->torque = 0.0;
  Three wd;
  Two lambda;
  model_->accelerate(angles, rates, wd, lambda);
  force_ = {lambda[0], lambda[1]};
}

void Linkage::advance(double torque, double seconds) {
  if (!std::isfinite(torque)) throw std::invalid_argument("plant: the torque on a linkage must be a number");
  if (!(seconds >= 0.0 && seconds <= 3600.0))
    throw std::invalid_argument(fmt::format("plant: a step of a linkage must be 0 to 3600 s (got {})", seconds));
  if (seconds == 0.0) return;
  Model& m = *model_;
  m.torque = torque;
  double* const y = solver_->y.data();
  double* const yd = solver_->yd.data();
  Three wd;
  Two lambda;
  m.accelerate(three(angle_), three(rate_), wd, lambda);
  for (std::size_t k = 0; k < 3; ++k) {
    y[k] = angle_[k];
    y[3 + k] = yd[k] = rate_[k];
    yd[3 + k] = wd[static_cast<int>(k)];
  }
  for (std::size_t i = 0; i < 2; ++i) {
    y[6 + i] = lambda[static_cast<int>(i)] / m.scale;
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

double Linkage::open() const { return model_->loop(three(angle_)).norm(); }

double Linkage::energy() const {
  const Three t = three(angle_), w = three(rate_), height(sin(t[0]), sin(t[1]), sin(t[2]));
  double sum = model_->p.tie_mass * gravity * model_->p.base_z + 0.5 * w.dot(model_->mass_matrix(t) * w);
  for (std::size_t b = 0; b < bodies; ++b) sum += model_->mass[b] * gravity * model_->arm[b].dot(height);
  return sum;
}

double Linkage::holding_torque() const {
  Model at = *model_;
  at.torque = 0.0;
  return at.ratio(three(angle_)).dot(at.rest(three(angle_), Three::Zero()));
}

std::array<double, 2> Linkage::joint_force() const { return force_; }

}  // namespace plant
