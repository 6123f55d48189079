#pragma once
// One Runge-Kutta step over a whole interval, with the bits of ERKStep.
//
// Nearly every call of Integrator::advance is one step whose error is far below the tolerance. ERKStep spends more host
// instructions on such a call (set-up, interpolation, choice of the next step) than on its arithmetic. WholeStep does
// the same arithmetic in the same order and leaves every other case to ERKStep. Private to this room.
#include <cstdio>  // for the header below, which names FILE

#include <arkode/arkode_butcher.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "plant/numerics/integrator.hpp"

namespace plant {

class WholeStep {
 public:
  static constexpr int highest_order = 4;

  // absolute: one tolerance per state.
  WholeStep(int order, double relative, std::span<const double> absolute);

  // True: y has advanced by `interval`. ERKStep would take this one step too, and would begin the next call with a step
  // of at least that length. False: ERKStep has to do it, and y is unchanged.
  bool take(RightHandSide f, void* model, std::span<double> y, double interval);

 private:
  struct FreeTable {
    void operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
  };
  static constexpr std::size_t most_stages = 5;
  using Vector = std::vector<double>;
  using Coefficients = std::array<double, most_stages>;

  // to = start + the sum of coefficient times rate over the first `terms` stages; without start: only the sum.
  template <std::size_t terms, bool with_start>
  void sum_of(Vector& to, const Coefficients&) const;
  template <bool with_start>
  void sum_of(Vector& to, const Coefficients&, std::size_t terms) const;
  double error() const;  // in units of the tolerance

  std::unique_ptr<ARKodeButcherTableMem, FreeTable> table_;
  std::size_t stages_;
  double relative_;
  Vector absolute_;
  // One more place if the number of states is odd, because sums work on pairs.
  std::array<Vector, most_stages> rates_;
  Vector start_, point_, difference_;
};

}  // namespace plant
