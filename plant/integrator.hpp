#pragma once
// One adaptive one-step integrator (ARKODE's ERKStep), restarted at every call: its whole memory is the caller's state and step.
#include <functional>
#include <memory>
#include <span>

namespace plant {

// yd = f(y); autonomous, so that an interval always runs from 0 and no time is accumulated in floating point.
using RightHandSide = void (*)(void* model, const double* y, double* yd);

class Integrator {
 public:
  // order 2..6 or 8; absolute: one tolerance per state. Throws std::runtime_error if SUNDIALS refuses.
  Integrator(int order, double relative, std::span<const double> absolute, RightHandSide f);
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  // Advances y by `interval` seconds. `step` is the step to begin with, and on return the one to begin with next time.
  // Allocates nothing after the first call. Throws std::runtime_error naming SUNDIALS' reason.
  void advance(void* model, std::span<double> y, double interval, double& step);
  // The same with steps of a fixed size (tests of the order).
  void advance_fixed(void* model, std::span<double> y, double interval, double step);
  long evaluations() const;  // of f, since the last call of advance

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

// An independent multistep reference: CVODES, Adams or BDF. Slow; for tests and stiff settings.
void advance_reference(bool stiff, double relative, std::span<const double> absolute, RightHandSide f, void* model,
                       std::span<double> y, double interval);

// CVODES (Adams) with two forward sensitivities: `by_parameter` by `parameter`, which f reads and CVODES varies, and `by_start` by a
// quantity of the given size that enters through the initial values alone. Both hold the derivatives at the start, then at the end.
void advance_sensitivity(double relative, std::span<const double> absolute, RightHandSide f, void* model, std::span<double> y,
                         std::span<double> by_parameter, std::span<double> by_start, double& parameter, double start_size,
                         double interval);

}  // namespace plant
