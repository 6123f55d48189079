#pragma once
// SUNDIALS' handles with owners. Private to this room: the headers below are large.
#include <cvodes/cvodes.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "plant/numerics/integrator.hpp"

namespace plant {

// The data of SUNDIALS' callbacks.
struct SundialsCall {
  RightHandSide f = nullptr;
  RootFunction roots = nullptr;
  void* model = nullptr;
  std::string message;
  const double* linked = nullptr;  // a parameter that CVODES varies, and the address from which f reads it
  double* link = nullptr;
  const double* sizes = nullptr;  // of the states, for the increments of `jacobian`
};

inline int evaluate(realtype t, N_Vector y, N_Vector yd, void* data) {
  auto& call = *static_cast<SundialsCall*>(data);
  if (call.link != nullptr) *call.link = *call.linked;
  call.f(call.model, t, NV_DATA_S(y), NV_DATA_S(yd));
  return 0;
}

// By forward differences, like CVODES' own but in place: CVODES' allocates and frees a vector each time.
inline int jacobian(realtype t, N_Vector y, N_Vector yd, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
  const auto& call = *static_cast<SundialsCall*>(data);
  double* const state = NV_DATA_S(y);
  const double* const rate = NV_DATA_S(yd);
  const sunindextype size = SM_COLUMNS_D(matrix);
  for (sunindextype j = 0; j < size; ++j) {
    const double kept = state[j];
    state[j] += 1e-8 * std::max(std::fabs(kept), call.sizes[j]);
    const double increment = state[j] - kept;
    double* const column = SM_COLUMN_D(matrix, j);
    call.f(call.model, t, state, column);
    state[j] = kept;
    for (sunindextype i = 0; i < size; ++i) column[i] = (column[i] - rate[i]) / increment;
  }
  return 0;
}

inline int evaluate_roots(realtype t, N_Vector y, realtype* values, void* data) {
  auto& call = *static_cast<SundialsCall*>(data);
  call.roots(call.model, t, NV_DATA_S(y), values);
  return 0;
}

inline void keep_message(int code, const char*, const char* function, char* message, void* data) {
  if (code < 0) static_cast<SundialsCall*>(data)->message = fmt::format("{}: {}", function, message);
}

inline void require(int flag, const SundialsCall& call, const char* what) {
  if (flag < 0) throw std::runtime_error(fmt::format("plant: {} failed with {} ({})", what, flag, call.message));
}

struct SundialsContext {
  SUNContext context = nullptr;
  SundialsContext() {
    if (SUNContext_Create(nullptr, &context) != 0) throw std::runtime_error("plant: SUNContext_Create failed");
  }
  ~SundialsContext() { SUNContext_Free(&context); }
  SundialsContext(const SundialsContext&) = delete;
  SundialsContext& operator=(const SundialsContext&) = delete;
};

struct SundialsVector {
  N_Vector vector;
  SundialsVector(std::size_t n, const SundialsContext& context)
      : vector(N_VNew_Serial(static_cast<sunindextype>(n), context.context)) {
    if (vector == nullptr) throw std::runtime_error("plant: N_VNew_Serial failed");
    N_VConst(0.0, vector);
  }
  ~SundialsVector() { N_VDestroy(vector); }
  SundialsVector(const SundialsVector&) = delete;
  SundialsVector& operator=(const SundialsVector&) = delete;
  double* data() { return NV_DATA_S(vector); }
};

// The solvers of an integrator; destroyed after it.
struct SundialsSolvers {
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  SUNNonlinearSolver nonlinear = nullptr;
  SUNNonlinearSolver staggered = nullptr;
  SundialsSolvers() = default;
  ~SundialsSolvers() {
    if (linear != nullptr) SUNLinSolFree(linear);
    if (matrix != nullptr) SUNMatDestroy(matrix);
    if (nonlinear != nullptr) SUNNonlinSolFree(nonlinear);
    if (staggered != nullptr) SUNNonlinSolFree(staggered);
  }
  SundialsSolvers(const SundialsSolvers&) = delete;
  SundialsSolvers& operator=(const SundialsSolvers&) = delete;

  void make_dense(std::size_t n, N_Vector like, const SundialsContext& context) {
    matrix = SUNDenseMatrix(static_cast<sunindextype>(n), static_cast<sunindextype>(n), context.context);
    linear = SUNLinSol_Dense(like, matrix, context.context);
  }
};

// CVODES' memory.
struct CvodesMemory {
  void* memory;
  CvodesMemory(int method, const SundialsContext& context) : memory(CVodeCreate(method, context.context)) {
    if (memory == nullptr) throw std::runtime_error("plant: CVodeCreate failed");
  }
  ~CvodesMemory() { CVodeFree(&memory); }
  CvodesMemory(const CvodesMemory&) = delete;
  CvodesMemory& operator=(const CvodesMemory&) = delete;

  void begin(SundialsCall& call, SundialsVector& state, double relative, SundialsVector& tolerance) const {
    require(CVodeSetErrHandlerFn(memory, keep_message, &call), call, "CVodeSetErrHandlerFn");
    require(CVodeInit(memory, evaluate, 0.0, state.vector), call, "CVodeInit");
    require(CVodeSetUserData(memory, &call), call, "CVodeSetUserData");
    require(CVodeSVtolerances(memory, relative, tolerance.vector), call, "CVodeSVtolerances");
    require(CVodeSetMaxNumSteps(memory, 10'000'000), call, "CVodeSetMaxNumSteps");
  }
};

}  // namespace plant
