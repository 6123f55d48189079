#include "plant/numerics/whole_step.hpp"

#include <arkode/arkode_erkstep.h>
#include <emmintrin.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plant {
namespace {

// ERKStep makes the next step 0.99 (1.2 error)^(-0.8 / p) times this step, p = 2 or 3 here. Up to this error, the next
// step is longer than this one.
constexpr double largest_error = 0.5;

}  // namespace

WholeStep::WholeStep(int order, double relative, std::span<const double> absolute)
    : table_(ARKodeButcherTable_LoadERK(
          static_cast<ARKODE_ERKTableID>(order == 3 ? ERKSTEP_DEFAULT_3 : ERKSTEP_DEFAULT_4))),
      stages_(table_ ? static_cast<std::size_t>(table_->stages) : 0),
      relative_(relative),
      absolute_(absolute.begin(), absolute.end()) {
  if (stages_ == 0 || stages_ > most_stages) throw std::runtime_error("plant: ARKodeButcherTable_LoadERK failed");
  const std::size_t places = (absolute.size() + 1) / 2 * 2;
  for (Vector* vector : {&start_, &point_, &difference_}) vector->assign(places, 0.0);
  for (Vector& rates : rates_) rates.assign(places, 0.0);
}

bool WholeStep::take(RightHandSide f, void* model, std::span<double> y, double interval) {
  std::copy(y.begin(), y.end(), start_.begin());
  f(model, 0.0, start_.data(), rates_[0].data());
  Coefficients by{}, apart{};
  for (std::size_t i = 1; i < stages_; ++i) {
    for (std::size_t j = 0; j < i; ++j) by[j] = interval * table_->A[i][j];
    sum_of<true>(point_, by, i);
    f(model, table_->c[i] * interval, point_.data(), rates_[i].data());
  }
  for (std::size_t j = 0; j < stages_; ++j) {
    by[j] = interval * table_->b[j];
    apart[j] = interval * (table_->b[j] - table_->d[j]);
  }
  sum_of<false>(difference_, apart, stages_);
  if (!(error() <= largest_error)) return false;
  sum_of<true>(point_, by, stages_);
  // ERKStep interpolates the end, which may turn a negative zero into a positive one.
  const std::span<const double> end(point_.data(), y.size());
  if (std::any_of(end.begin(), end.end(), [](double x) { return x == 0.0 && std::signbit(x); })) return false;
  std::copy(end.begin(), end.end(), y.begin());
  return true;
}

// ERKStep also adds terms with coefficient 0: they decide the sign of a zero.
template <std::size_t terms, bool with_start>
void WholeStep::sum_of(Vector& to, const Coefficients& by) const {
  // Not read again for each pair: `to` might be one of them, for all that the compiler knows.
  std::array<const double*, terms> rates;
  __m128d factors[terms];  // of the type with its alignment, which a template argument loses
  for (std::size_t j = 0; j < terms; ++j) rates[j] = rates_[j].data(), factors[j] = _mm_set1_pd(by[j]);
  const double* const start = start_.data();
  double* const sums = to.data();
  for (std::size_t i = 0, places = to.size(); i < places; i += 2) {
    __m128d two = _mm_mul_pd(factors[0], _mm_loadu_pd(rates[0] + i));
#pragma GCC unroll 5
    for (std::size_t j = 1; j < terms; ++j) two = _mm_add_pd(two, _mm_mul_pd(factors[j], _mm_loadu_pd(rates[j] + i)));
    if constexpr (with_start) two = _mm_add_pd(two, _mm_loadu_pd(start + i));
    _mm_storeu_pd(sums + i, two);
  }
}

template <bool with_start>
void WholeStep::sum_of(Vector& to, const Coefficients& by, std::size_t terms) const {
  static_assert(most_stages == 5);
  switch (terms) {
    case 1: return sum_of<1, with_start>(to, by);
    case 2: return sum_of<2, with_start>(to, by);
    case 3: return sum_of<3, with_start>(to, by);
    case 4: return sum_of<4, with_start>(to, by);
    default: return sum_of<5, with_start>(to, by);
  }
}

// The root of the mean square of each state's error divided by its tolerance at the step's beginning.
double WholeStep::error() const {
  double squares = 0.0;
  for (std::size_t i = 0; i < absolute_.size(); ++i) {
    const double weighted = difference_[i] * (1.0 / (relative_ * std::fabs(start_[i]) + absolute_[i]));
    squares += weighted * weighted;
  }
  return std::sqrt(squares / static_cast<double>(absolute_.size()));
}

}  // namespace plant
