#include "plant/numerics/integrator.hpp"

#include <arkode/arkode_erkstep.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "plant/numerics/sundials.hpp"
#include "plant/numerics/whole_step.hpp"

namespace plant {

namespace {

// By which ERKStep lets a step grow at most. By default the first step of all may grow 10,000 times, so that a call
// would depend on whether it is the object's first one.
constexpr double most_growth = 25.0;

// Parameters may ask for a motion that is a billion times faster than a crane's. Explicit methods then take steps of
// nanoseconds, and a simulated second would take hours: that is an error of the parameters, and is reported as one.
long steps_max(double interval) {
  constexpr double shortest_mean_step = 125e-9;
  return 1000 + static_cast<long>(interval / shortest_mean_step);
}

void require_ending(int flag, const SundialsCall& call, const char* what, double interval, long steps) {
  static_assert(ARK_TOO_MUCH_WORK == CV_TOO_MUCH_WORK);
  if (flag == ARK_TOO_MUCH_WORK)
    throw std::runtime_error(fmt::format(
        "plant: the equations of motion need more than {} steps for {} s: a torque, mass, friction or time constant is "
        "far from any machine's; values nearer to the defaults are expected (docs/configuration.md)",
        steps, interval));
  require(flag, call, what);
}

}  // namespace

struct Integrator::Implementation {
  SundialsContext context;
  Method method;
  std::size_t size;
  SundialsVector y, absolute;
  std::vector<double> sizes;
  SundialsCall call;
  SundialsSolvers solvers;
  std::optional<CvodesMemory> cvodes;
  void* erk = nullptr;
  std::optional<WholeStep> whole;

  Implementation(const Settings& settings, std::span<const double> tolerances)
      : method(settings.method), size(tolerances.size()), y(size, context), absolute(size, context) {
    std::copy(tolerances.begin(), tolerances.end(), absolute.data());
  }
  ~Implementation() {
    if (erk != nullptr) ERKStepFree(&erk);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void make_erk(const Settings& settings, int root_count) {
    if (settings.order < lowest_order || settings.order > highest_order)
      throw std::invalid_argument(fmt::format("plant: the order of Runge-Kutta must be {} to {} (got {})", lowest_order,
                                              highest_order, settings.order));
    erk = ERKStepCreate(evaluate, 0.0, y.vector, context.context);
    if (erk == nullptr) throw std::runtime_error("plant: ERKStepCreate failed");
    require(ERKStepSetErrHandlerFn(erk, keep_message, &call), call, "ERKStepSetErrHandlerFn");
    require(ERKStepSetUserData(erk, &call), call, "ERKStepSetUserData");
    require(ERKStepSetOrder(erk, settings.order), call, "ERKStepSetOrder");
    require(ERKStepSVtolerances(erk, settings.relative, absolute.vector), call, "ERKStepSVtolerances");
    require(ERKStepSetMaxGrowth(erk, most_growth), call, "ERKStepSetMaxGrowth");
    require(ERKStepSetMaxFirstGrowth(erk, most_growth), call, "ERKStepSetMaxFirstGrowth");
    if (root_count == 0 && settings.order <= WholeStep::highest_order)
      whole.emplace(settings.order, settings.relative, std::span{absolute.data(), size});
    if (root_count > 0) require(ERKStepRootInit(erk, root_count, evaluate_roots), call, "ERKStepRootInit");
  }

  void make_cvodes(const Settings& settings, int root_count) {
    cvodes.emplace(method == Method::bdf ? CV_BDF : CV_ADAMS, context);
    cvodes->begin(call, y, settings.relative, absolute);
    if (method == Method::bdf) {
      solvers.make_dense(size, y.vector, context);
      require(CVodeSetLinearSolver(cvodes->memory, solvers.linear, solvers.matrix), call, "CVodeSetLinearSolver");
      for (std::size_t i = 0; i < size; ++i) sizes.push_back(absolute.data()[i] / settings.relative);
      call.sizes = sizes.data();
      require(CVodeSetJacFn(cvodes->memory, jacobian), call, "CVodeSetJacFn");
    } else {
      solvers.nonlinear = SUNNonlinSol_FixedPoint(y.vector, 0, context.context);
      require(CVodeSetNonlinearSolver(cvodes->memory, solvers.nonlinear), call, "CVodeSetNonlinearSolver");
    }
    if (root_count > 0) require(CVodeRootInit(cvodes->memory, root_count, evaluate_roots), call, "CVodeRootInit");
  }

  // Returns the elapsed seconds.
  double run(void* model, std::span<double> state, double interval, long most_steps) {
    call.model = model;
    std::copy(state.begin(), state.end(), y.data());
    double reached = 0.0;
    if (erk != nullptr) {
      require(ERKStepReset(erk, 0.0, y.vector), call, "ERKStepReset");
      require(ERKStepSetStopTime(erk, interval), call, "ERKStepSetStopTime");
      require(ERKStepSetMaxNumSteps(erk, most_steps), call, "ERKStepSetMaxNumSteps");
      require_ending(ERKStepEvolve(erk, interval, y.vector, &reached, ARK_NORMAL), call, "ERKStepEvolve", interval,
                     most_steps);
    } else {
      require(CVodeReInit(cvodes->memory, 0.0, y.vector), call, "CVodeReInit");
      require(CVodeSetStopTime(cvodes->memory, interval), call, "CVodeSetStopTime");
      require(CVodeSetMaxNumSteps(cvodes->memory, most_steps), call, "CVodeSetMaxNumSteps");
      require_ending(CVode(cvodes->memory, interval, y.vector, &reached, CV_NORMAL), call, "CVode", interval,
                     most_steps);
    }
    std::copy_n(y.data(), size, state.begin());
    return reached;
  }

  double run_adaptive(void* model, std::span<double> state, double interval, double& step) {
    if (whole && step >= interval && interval > 0.0 && whole->take(call.f, model, state, interval)) {
      step = interval;
      return interval;
    }
    if (erk != nullptr) require(ERKStepSetInitStep(erk, std::min(step, interval)), call, "ERKStepSetInitStep");
    const double reached = run(model, state, interval, steps_max(interval));
    if (erk != nullptr) {
      double next = interval;
      require(ERKStepGetCurrentStep(erk, &next), call, "ERKStepGetCurrentStep");
      step = std::min(next, interval);
    }
    return reached;
  }
};

Integrator::Integrator(const Settings& settings, std::span<const double> absolute, RightHandSide f, RootFunction roots,
                       int root_count)
    : self_(std::make_unique<Implementation>(settings, absolute)) {
  self_->call.f = f;
  self_->call.roots = roots;
  if (settings.method == Method::erk)
    self_->make_erk(settings, root_count);
  else
    self_->make_cvodes(settings, root_count);
}

Integrator::~Integrator() = default;

void Integrator::advance(void* model, std::span<double> y, double interval, double& step) {
  self_->run_adaptive(model, y, interval, step);
}

double Integrator::advance_to_root(void* model, std::span<double> y, double interval, double& step,
                                   std::span<int> found) {
  auto& s = *self_;
  const double reached = s.run_adaptive(model, y, interval, step);
  std::fill(found.begin(), found.end(), 0);
  if (reached >= interval) return interval;
  if (s.erk != nullptr)
    require(ERKStepGetRootInfo(s.erk, found.data()), s.call, "ERKStepGetRootInfo");
  else
    require(CVodeGetRootInfo(s.cvodes->memory, found.data()), s.call, "CVodeGetRootInfo");
  return reached;
}

void Integrator::advance_fixed(void* model, std::span<double> y, double interval, double step) {
  auto& s = *self_;
  if (s.erk == nullptr) throw std::runtime_error("plant: steps of a fixed size need ERKStep");
  require(ERKStepSetFixedStep(s.erk, step), s.call, "ERKStepSetFixedStep");
  s.run(model, y, interval, 1 + static_cast<long>(interval / step) + 1000);
}

}  // namespace plant
