// WholeStep against ERKStep itself, bit for bit.
#include "plant/numerics/whole_step.hpp"

#include <arkode/arkode_erkstep.h>
#include <doctest/doctest.h>
#include <nvector/nvector_serial.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace {

using Values = std::vector<double>;

// Bounded rates that are no polynomials, with an input that grows with time. Some states rest: their rate is a zero,
// which is negative before `turn`.
struct Model {
  std::size_t size;
  Values by_state, input;
  std::vector<bool> rests;
  double turn = 0.0;

  Model(std::size_t n, double stiffness, std::mt19937_64& draw) : size(n), by_state(n * n), input(n), rests(n) {
    std::normal_distribution<double> normal;
    for (double& x : by_state) x = stiffness * normal(draw);
    for (std::size_t i = 0; i < n; ++i) {
      rests[i] = draw() % 4 == 0;
      input[i] = normal(draw);
    }
  }
  void rates(double t, const double* y, double* yd) const {
    for (std::size_t i = 0; i < size; ++i) {
      if (rests[i]) {
        yd[i] = t < turn ? -0.0 : 0.0;
        continue;
      }
      double sum = input[i] * (1.0 + t);
      for (std::size_t j = 0; j < size; ++j) sum += by_state[i * size + j] * y[j] / (1.0 + y[j] * y[j]);
      yd[i] = sum;
    }
  }
};

int evaluate(realtype t, N_Vector y, N_Vector yd, void* model) {
  static_cast<const Model*>(model)->rates(t, NV_DATA_S(y), NV_DATA_S(yd));
  return 0;
}

struct Ended {
  long steps;
  double next;
};

// With the settings of Integrator (plant/numerics/integrator.cpp).
Ended by_erkstep(Model& model, int order, double relative, const Values& absolute, Values& y, double interval,
                 double first_step) {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  const auto n = static_cast<sunindextype>(y.size());
  N_Vector state = N_VNew_Serial(n, context), tolerance = N_VNew_Serial(n, context);
  std::copy(y.begin(), y.end(), NV_DATA_S(state));
  std::copy(absolute.begin(), absolute.end(), NV_DATA_S(tolerance));
  void* memory = ERKStepCreate(evaluate, 0.0, state, context);
  ERKStepSetUserData(memory, &model);
  ERKStepSetOrder(memory, order);
  ERKStepSVtolerances(memory, relative, tolerance);
  ERKStepSetMaxGrowth(memory, 25.0);
  ERKStepSetMaxFirstGrowth(memory, 25.0);
  ERKStepSetInitStep(memory, first_step);
  ERKStepSetStopTime(memory, interval);
  ERKStepSetMaxNumSteps(memory, 1'000'000);
  double reached = 0.0;
  CHECK(ERKStepEvolve(memory, interval, state, &reached, ARK_NORMAL) >= 0);
  CHECK(reached == interval);
  Ended ended{};
  ERKStepGetNumSteps(memory, &ended.steps);
  ERKStepGetCurrentStep(memory, &ended.next);
  std::copy_n(NV_DATA_S(state), y.size(), y.begin());
  ERKStepFree(&memory);
  N_VDestroy(state);
  N_VDestroy(tolerance);
  SUNContext_Free(&context);
  return ended;
}

bool same_bits(const Values& a, const Values& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

struct Trial {
  std::size_t size;
  Model model;
  double relative, interval;
  Values absolute, start;

  explicit Trial(std::mt19937_64& draw)
      : size(1 + draw() % 14),
        model(size, std::pow(10.0, static_cast<double>(draw() % 4)), draw),
        relative(std::pow(10.0, -4.0 - static_cast<double>(draw() % 6))),
        interval(1e-3 * static_cast<double>(1 + draw() % 8) / 8.0),
        absolute(size, 0.1 * relative),
        start(size) {
    std::normal_distribution<double> normal;
    for (double& x : start) x = draw() % 6 == 0 ? (draw() % 2 == 0 ? 0.0 : -0.0) : normal(draw);
    if (draw() % 2 == 0) model.turn = interval;
  }
};

void rates(void* model, double t, const double* y, double* yd) { static_cast<const Model*>(model)->rates(t, y, yd); }

}  // namespace

TEST_CASE("a whole step has the bits of ERKStep's only step, or is left to ERKStep") {
  std::mt19937_64 draw(1);
  for (const int order : {3, 4}) {
    CAPTURE(order);
    int taken = 0, left = 0, close = 0;
    for (int n = 0; n < 4000; ++n) {
      CAPTURE(n);
      Trial t(draw);
      Values whole = t.start, other = t.start;
      plant::WholeStep step(order, t.relative, t.absolute);
      const bool took = step.take(rates, &t.model, whole, t.interval);
      const Ended ended = by_erkstep(t.model, order, t.relative, t.absolute, other, t.interval, t.interval);
      if (took) {
        ++taken;
        CHECK(same_bits(whole, other));
        CHECK(ended.steps == 1);
        CHECK(ended.next >= t.interval);
      } else {
        ++left;
        close += ended.steps == 1 ? 1 : 0;
        CHECK(same_bits(whole, t.start));
      }
    }
    CHECK(taken > 1000);
    CHECK(left > 500);
    CHECK(close > 10);
  }
}

TEST_CASE("an integrator continues as ERKStep, whatever step it begins with") {
  std::mt19937_64 draw(2);
  for (const int order : {3, 4, 5}) {
    CAPTURE(order);
    for (int n = 0; n < 1000; ++n) {
      CAPTURE(n);
      Trial t(draw);
      const double begins = t.interval * std::array{0.01, 0.3, 1.0, 2.0}[draw() % 4];
      Values own = t.start, other = t.start;
      plant::Integrator integrator({.order = order, .relative = t.relative}, t.absolute, rates);
      double step = begins;
      integrator.advance(&t.model, own, t.interval, step);
      const Ended ended =
          by_erkstep(t.model, order, t.relative, t.absolute, other, t.interval, std::min(begins, t.interval));
      CHECK(same_bits(own, other));
      CHECK(step == std::min(ended.next, t.interval));
    }
  }
}
