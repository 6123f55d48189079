#pragma once
// One adaptive integrator, restarted at every call: its only memory is the caller's state and step.
#include <cstdint>
#include <memory>
#include <span>

namespace plant {

// ARKODE's explicit Runge-Kutta (ERKStep), or CVODES' multistep methods. A multistep method falls back to order 1 at
// every restart, so it costs more where inputs change often (plant-and-bus.md 1.6); BDF is for stiff settings.
enum class Method : std::uint8_t { erk, adams, bdf };

// yd = f(t, y); t is the time since the call's beginning, so that no time is accumulated in floating point.
using RightHandSide = void (*)(void* model, double t, const double* y, double* yd);
// values: the quantities that change their sign at an event.
using RootFunction = void (*)(void* model, double t, const double* y, double* values);

// Orders of ERKStep. SUNDIALS 6.4 has tables of order 2, 6 and 8 too, but treats every table whose last stage is at the
// step's end as one whose last derivative is the next step's first ("first same as last"). This is not true for these
// tables: further steps of one call would begin with a wrong derivative, or with none. So Integrator's constructor
// refuses them.
inline constexpr int lowest_order = 3, highest_order = 5;

class Integrator {
 public:
  struct Settings {
    Method method = Method::erk;
    int order = 4;  // of ERKStep, see lowest_order; the multistep methods choose their own
    double relative = 1e-8;
  };
  // absolute: one tolerance per state. roots: events of advance_to_root, none if null. Throws std::runtime_error if
  // SUNDIALS refuses.
  Integrator(const Settings&, std::span<const double> absolute, RightHandSide f, RootFunction roots = nullptr,
             int root_count = 0);
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  // Advances y by `interval` seconds. `step` is the first step, and on return the first step for the next call
  // (ERKStep; the multistep methods derive it from y alone). Allocates nothing after the first call. Throws
  // std::runtime_error with SUNDIALS' reason.
  void advance(void* model, std::span<double> y, double interval, double& step);
  // The same, but stops at the first root; returns the elapsed seconds, `interval` if there was no root. found: -1, 0
  // or 1 per root, the direction of its change of sign.
  double advance_to_root(void* model, std::span<double> y, double interval, double& step, std::span<int> found);
  // The same as advance with steps of a fixed size (ERKStep only; for tests of the order).
  void advance_fixed(void* model, std::span<double> y, double interval, double step);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> self_;
};

// CVODES (Adams) with two forward sensitivities: `by_parameter` for `parameter`, which f reads and CVODES varies, and
// `by_start` for a quantity of the given size that acts through the initial values alone. Both contain the derivatives
// at the start, then at the end.
void advance_sensitivity(double relative, std::span<const double> absolute, RightHandSide f, void* model,
                         std::span<double> y, std::span<double> by_parameter, std::span<double> by_start,
                         double& parameter, double start_size, double interval);

}  // namespace plant
