#pragma once
// Elementary functions with the same bits on every x86-64: SLEEF's deterministic ones, one or two at a time. The C
// library selects variants by CPU. sqrt, floor and fabs are exact everywhere and come from <cmath>. Only sources
// include this file: the header below is large.
#include <emmintrin.h>
#include <sleef.h>

#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "plant/numerics/vector.hpp"

namespace plant {

inline constexpr double degree = std::numbers::pi / 180.0;  // in radians

struct SinCos {
  double sin, cos;
};

inline SinCos sin_cos(double x) {
  const auto r = Sleef_cinz_sincosd1_u10purec(x);
  return {r.x, r.y};
}
// Both at once, with the bits of each alone.
inline std::array<SinCos, 2> sin_cos(double x, double y) {
  const auto r = Sleef_cinz_sincosd2_u10sse2(_mm_setr_pd(x, y));
  return {SinCos{_mm_cvtsd_f64(r.x), _mm_cvtsd_f64(r.y)},
          SinCos{_mm_cvtsd_f64(_mm_unpackhi_pd(r.x, r.x)), _mm_cvtsd_f64(_mm_unpackhi_pd(r.y, r.y))}};
}
inline double sin(double x) { return Sleef_cinz_sind1_u10purec(x); }
inline double cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }
inline double atan2(double y, double x) { return Sleef_cinz_atan2d1_u10purec(y, x); }
// Beyond 20 the nearest double is always 1.
inline double tanh(double x) { return x > 20.0 ? 1.0 : x < -20.0 ? -1.0 : Sleef_cinz_tanhd1_u10purec(x); }
inline double exp(double x) { return Sleef_cinz_expd1_u10purec(x); }
// 0 if less than exp(-700).
inline double small_exp(double x) { return x < -700.0 ? 0.0 : exp(x); }

// Replaces each element by within(element, its result of f), two elements at a time; an odd last one goes twice.
template <class F, class Within>
void in_pairs(std::span<double> x, const F& f, const Within& within) {
  std::size_t i = 0;
  for (; i + 1 < x.size(); i += 2) {
    const __m128d two = f(_mm_loadu_pd(&x[i]));
    x[i] = within(x[i], _mm_cvtsd_f64(two));
    x[i + 1] = within(x[i + 1], _mm_cvtsd_f64(_mm_unpackhi_pd(two, two)));
  }
  if (i < x.size()) x[i] = within(x[i], _mm_cvtsd_f64(f(_mm_set1_pd(x[i]))));
}

// tanh of each element, with the bits of the scalar function. Two at a time cost less than one.
inline void tanh_each(std::span<double> x) {
  const auto within = [](double at, double value) { return at > 20.0 ? 1.0 : at < -20.0 ? -1.0 : value; };
  in_pairs(x, [&](__m128d at) { return Sleef_cinz_tanhd2_u10sse2(at); }, within);
}
inline void small_exp_each(std::span<double> x) {
  const auto within = [](double at, double value) { return at < -700.0 ? 0.0 : value; };
  in_pairs(x, [&](__m128d at) { return Sleef_cinz_expd2_u10sse2(at); }, within);
}
inline double log(double x) { return Sleef_cinz_logd1_u10purec(x); }
inline double hypot(double x, double y) { return Sleef_cinz_hypotd1_u05purec(x, y); }

inline double wrap_angle(double a) {
  const double turn = 2.0 * std::numbers::pi;
  return a - turn * std::floor((a + std::numbers::pi) / turn);
}

}  // namespace plant
