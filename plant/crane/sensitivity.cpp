#include <algorithm>
#include <array>

#include "plant/numerics/sundials.hpp"

namespace plant {

void advance_sensitivity(double relative, std::span<const double> absolute, RightHandSide f, void* model,
                         std::span<double> y, std::span<double> by_parameter, std::span<double> by_start,
                         double& parameter, double start_size, double interval) {
  const SundialsContext context;
  SundialsVector state(y.size(), context);
  SundialsVector tolerance(y.size(), context);
  SundialsVector first(y.size(), context);
  SundialsVector second(y.size(), context);
  std::copy(y.begin(), y.end(), state.data());
  std::copy(absolute.begin(), absolute.end(), tolerance.data());
  std::copy(by_parameter.begin(), by_parameter.end(), first.data());
  std::copy(by_start.begin(), by_start.end(), second.data());
  SundialsCall call;
  call.f = f;
  call.model = model;
  SundialsSolvers solvers;
  const CvodesMemory solver(CV_ADAMS, context);
  solver.begin(call, state, relative, tolerance);
  require(CVodeSetStopTime(solver.memory, interval), call, "CVodeSetStopTime");
  solvers.nonlinear = SUNNonlinSol_FixedPoint(state.vector, 0, context.context);
  require(CVodeSetNonlinearSolver(solver.memory, solvers.nonlinear), call, "CVodeSetNonlinearSolver");
  std::array<N_Vector, 2> vectors{first.vector, second.vector};
  require(CVodeSensInit1(solver.memory, 2, CV_STAGGERED, nullptr, vectors.data()), call, "CVodeSensInit1");
  // The two parameters must be adjacent in memory: f reads the first through `link`, and the second acts through the
  // initial values alone.
  std::array<double, 2> values{parameter, start_size};
  std::array<double, 2> sizes = values;
  std::array<int, 2> list{0, 1};
  call.linked = values.data();
  call.link = &parameter;
  require(CVodeSetSensParams(solver.memory, values.data(), sizes.data(), list.data()), call, "CVodeSetSensParams");
  require(CVodeSensEEtolerances(solver.memory), call, "CVodeSensEEtolerances");
  require(CVodeSetSensErrCon(solver.memory, SUNTRUE), call, "CVodeSetSensErrCon");
  solvers.staggered = SUNNonlinSol_FixedPointSens(2, state.vector, 0, context.context);
  require(CVodeSetNonlinearSolverSensStg(solver.memory, solvers.staggered), call, "CVodeSetNonlinearSolverSensStg");
  double reached = 0.0;
  require(CVode(solver.memory, interval, state.vector, &reached, CV_NORMAL), call, "CVode");
  require(CVodeGetSens(solver.memory, &reached, vectors.data()), call, "CVodeGetSens");
  std::copy_n(state.data(), y.size(), y.begin());
  std::copy_n(first.data(), y.size(), by_parameter.begin());
  std::copy_n(second.data(), y.size(), by_start.begin());
}

}  // namespace plant
