#include "plant/integrator.hpp"

#include <arkode/arkode_erkstep.h>
#include <cvodes/cvodes.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace plant {
namespace {

// What SUNDIALS calls back with.
struct Call {
  RightHandSide f = nullptr;
  void* model = nullptr;
  std::string message;
  const double* linked = nullptr;  // a parameter that CVODES varies, and where f reads it
  double* link = nullptr;
};

int evaluate(realtype, N_Vector y, N_Vector yd, void* data) {
  auto& call = *static_cast<Call*>(data);
  if (call.link != nullptr) *call.link = *call.linked;
  call.f(call.model, NV_DATA_S(y), NV_DATA_S(yd));
  return 0;
}

void keep_message(int code, const char*, const char* function, char* message, void* data) {
  if (code < 0) static_cast<Call*>(data)->message = fmt::format("{}: {}", function, message);
}

void require(int flag, const Call& call, const char* what) {
  if (flag < 0) throw std::runtime_error(fmt::format("plant: {} failed with {} ({})", what, flag, call.message));
}

struct Context {
  SUNContext context = nullptr;
  Context() {
    if (SUNContext_Create(nullptr, &context) != 0) throw std::runtime_error("plant: SUNContext_Create failed");
  }
  ~Context() { SUNContext_Free(&context); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

struct Vector {
  N_Vector vector;
  Vector(std::size_t n, const Context& context) : vector(N_VNew_Serial(static_cast<sunindextype>(n), context.context)) {
    if (vector == nullptr) throw std::runtime_error("plant: N_VNew_Serial failed");
    N_VConst(0.0, vector);
  }
  ~Vector() { N_VDestroy(vector); }
  Vector(const Vector&) = delete;
  Vector& operator=(const Vector&) = delete;
  double* data() { return NV_DATA_S(vector); }
};

// CVODES' memory and what hangs on it.
struct Solver {
  void* memory;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  SUNNonlinearSolver nonlinear = nullptr;
  SUNNonlinearSolver staggered = nullptr;

  Solver(int method, const Context& context) : memory(CVodeCreate(method, context.context)) {
    if (memory == nullptr) throw std::runtime_error("plant: CVodeCreate failed");
  }
  ~Solver() {
    CVodeFree(&memory);
    if (linear != nullptr) SUNLinSolFree(linear);
    if (matrix != nullptr) SUNMatDestroy(matrix);
    if (nonlinear != nullptr) SUNNonlinSolFree(nonlinear);
    if (staggered != nullptr) SUNNonlinSolFree(staggered);
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  void begin(Call& call, Vector& state, double relative, Vector& tolerance, double interval) const {
    require(CVodeSetErrHandlerFn(memory, keep_message, &call), call, "CVodeSetErrHandlerFn");
    require(CVodeInit(memory, evaluate, 0.0, state.vector), call, "CVodeInit");
    require(CVodeSetUserData(memory, &call), call, "CVodeSetUserData");
    require(CVodeSVtolerances(memory, relative, tolerance.vector), call, "CVodeSVtolerances");
    require(CVodeSetMaxNumSteps(memory, 10'000'000), call, "CVodeSetMaxNumSteps");
    require(CVodeSetStopTime(memory, interval), call, "CVodeSetStopTime");
  }
};

}  // namespace

struct Integrator::Implementation {
  Context context;
  std::size_t size;
  Vector y, absolute;
  Call call;
  void* memory = nullptr;

  explicit Implementation(std::span<const double> tolerances)
      : size(tolerances.size()), y(size, context), absolute(size, context) {
    std::copy(tolerances.begin(), tolerances.end(), absolute.data());
  }
  ~Implementation() {
    if (memory != nullptr) ERKStepFree(&memory);
  }
  void run(void* model, std::span<double> state, double interval) {
    call.model = model;
    std::copy(state.begin(), state.end(), y.data());
    require(ERKStepReset(memory, 0.0, y.vector), call, "ERKStepReset");
    require(ERKStepSetStopTime(memory, interval), call, "ERKStepSetStopTime");
    double reached = 0.0;
    require(ERKStepEvolve(memory, interval, y.vector, &reached, ARK_NORMAL), call, "ERKStepEvolve");
    std::copy_n(y.data(), size, state.begin());
  }
};

Integrator::Integrator(int order, double relative, std::span<const double> absolute, RightHandSide f)
    : self_(std::make_unique<Implementation>(absolute)) {
  auto& s = *self_;
  s.call.f = f;
  s.memory = ERKStepCreate(evaluate, 0.0, s.y.vector, s.context.context);
  if (s.memory == nullptr) throw std::runtime_error("plant: ERKStepCreate failed");
  require(ERKStepSetErrHandlerFn(s.memory, keep_message, &s.call), s.call, "ERKStepSetErrHandlerFn");
  require(ERKStepSetUserData(s.memory, &s.call), s.call, "ERKStepSetUserData");
  require(ERKStepSetOrder(s.memory, order), s.call, "ERKStepSetOrder");
  require(ERKStepSVtolerances(s.memory, relative, s.absolute.vector), s.call, "ERKStepSVtolerances");
  require(ERKStepSetMaxNumSteps(s.memory, 10'000'000), s.call, "ERKStepSetMaxNumSteps");
}

Integrator::~Integrator() = default;

void Integrator::advance(void* model, std::span<double> y, double interval, double& step) {
  auto& s = *self_;
  require(ERKStepSetInitStep(s.memory, std::min(step, interval)), s.call, "ERKStepSetInitStep");
  s.run(model, y, interval);
  double next = interval;
  require(ERKStepGetCurrentStep(s.memory, &next), s.call, "ERKStepGetCurrentStep");
  step = std::min(next, interval);
}

void Integrator::advance_fixed(void* model, std::span<double> y, double interval, double step) {
  auto& s = *self_;
  require(ERKStepSetFixedStep(s.memory, step), s.call, "ERKStepSetFixedStep");
  s.run(model, y, interval);
}

long Integrator::evaluations() const {
  long n = 0;
  ERKStepGetNumRhsEvals(self_->memory, &n);
  return n;
}

void advance_reference(bool stiff, double relative, std::span<const double> absolute, RightHandSide f, void* model,
                       std::span<double> y, double interval) {
  const Context context;
  Vector state(y.size(), context);
  Vector tolerance(y.size(), context);
  std::copy(y.begin(), y.end(), state.data());
  std::copy(absolute.begin(), absolute.end(), tolerance.data());
  Call call;
  call.f = f;
  call.model = model;
  Solver solver(stiff ? CV_BDF : CV_ADAMS, context);
  solver.begin(call, state, relative, tolerance, interval);
  if (stiff) {
    const auto n = static_cast<sunindextype>(y.size());
    solver.matrix = SUNDenseMatrix(n, n, context.context);
    solver.linear = SUNLinSol_Dense(state.vector, solver.matrix, context.context);
    require(CVodeSetLinearSolver(solver.memory, solver.linear, solver.matrix), call, "CVodeSetLinearSolver");
  } else {
    solver.nonlinear = SUNNonlinSol_FixedPoint(state.vector, 0, context.context);
    require(CVodeSetNonlinearSolver(solver.memory, solver.nonlinear), call, "CVodeSetNonlinearSolver");
  }
  double reached = 0.0;
  require(CVode(solver.memory, interval, state.vector, &reached, CV_NORMAL), call, "CVode");
  std::copy_n(state.data(), y.size(), y.begin());
}

void advance_sensitivity(double relative, std::span<const double> absolute, RightHandSide f, void* model, std::span<double> y,
                         std::span<double> by_parameter, std::span<double> by_start, double& parameter, double start_size,
                         double interval) {
  const Context context;
  Vector state(y.size(), context);
  Vector tolerance(y.size(), context);
  Vector first(y.size(), context);
  Vector second(y.size(), context);
  std::copy(y.begin(), y.end(), state.data());
  std::copy(absolute.begin(), absolute.end(), tolerance.data());
  std::copy(by_parameter.begin(), by_parameter.end(), first.data());
  std::copy(by_start.begin(), by_start.end(), second.data());
  Call call;
  call.f = f;
  call.model = model;
  Solver solver(CV_ADAMS, context);
  solver.begin(call, state, relative, tolerance, interval);
  solver.nonlinear = SUNNonlinSol_FixedPoint(state.vector, 0, context.context);
  require(CVodeSetNonlinearSolver(solver.memory, solver.nonlinear), call, "CVodeSetNonlinearSolver");
  std::array<N_Vector, 2> vectors{first.vector, second.vector};
  require(CVodeSensInit1(solver.memory, 2, CV_STAGGERED, nullptr, vectors.data()), call, "CVodeSensInit1");
  // Two parameters must lie side by side: f reads the first through `link`, and the second enters by the initial values alone.
  std::array<double, 2> values{parameter, start_size};
  std::array<double, 2> sizes = values;
  std::array<int, 2> list{0, 1};
  call.linked = values.data();
  call.link = &parameter;
  require(CVodeSetSensParams(solver.memory, values.data(), sizes.data(), list.data()), call, "CVodeSetSensParams");
  require(CVodeSensEEtolerances(solver.memory), call, "CVodeSensEEtolerances");
  require(CVodeSetSensErrCon(solver.memory, SUNTRUE), call, "CVodeSetSensErrCon");
  solver.staggered = SUNNonlinSol_FixedPointSens(2, state.vector, 0, context.context);
  require(CVodeSetNonlinearSolverSensStg(solver.memory, solver.staggered), call, "CVodeSetNonlinearSolverSensStg");
  double reached = 0.0;
  require(CVode(solver.memory, interval, state.vector, &reached, CV_NORMAL), call, "CVode");
  require(CVodeGetSens(solver.memory, &reached, vectors.data()), call, "CVodeGetSens");
  std::copy_n(state.data(), y.size(), y.begin());
  std::copy_n(first.data(), y.size(), by_parameter.begin());
  std::copy_n(second.data(), y.size(), by_start.begin());
}

}  // namespace plant
