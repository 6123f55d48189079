#pragma once
// Elementary functions with the same bits on every x86-64: SLEEF's deterministic ones, one or two at a time. The C
// library selects variants by CPU. sqrt, floor and fabs are exact everywhere and come from <cmath>. Only sources
// include this file: the header below is large.
#include <emmintrin.h>
#include <sleef.h>

#include <array>
#include <cmath>
#include <numbers>

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

// Replaces x and y by their results, with the bits of the scalar functions. Two cost less than one; x and y may be one.
inline void tanh_both(double& x, double& y) {
  const __m128d at = _mm_setr_pd(x, y), within = Sleef_cinz_tanhd2_u10sse2(at);
  const __m128d sign = _mm_and_pd(at, _mm_set1_pd(-0.0)), one = _mm_or_pd(_mm_set1_pd(1.0), sign);
  const __m128d beyond = _mm_cmpgt_pd(_mm_xor_pd(at, sign), _mm_set1_pd(20.0));
  const __m128d both = _mm_or_pd(_mm_and_pd(beyond, one), _mm_andnot_pd(beyond, within));
  _mm_storel_pd(&x, both);
  _mm_storeh_pd(&y, both);
}
inline void small_exp_both(double& x, double& y) {
  const __m128d at = _mm_setr_pd(x, y), within = Sleef_cinz_expd2_u10sse2(at);
  const __m128d both = _mm_andnot_pd(_mm_cmplt_pd(at, _mm_set1_pd(-700.0)), within);
  _mm_storel_pd(&x, both);
  _mm_storeh_pd(&y, both);
}
inline double log(double x) { return Sleef_cinz_logd1_u10purec(x); }
inline double hypot(double x, double y) { return Sleef_cinz_hypotd1_u05purec(x, y); }

inline double wrap_angle(double a) {
  const double turn = 2.0 * std::numbers::pi;
  return a - turn * std::floor((a + std::numbers::pi) / turn);
}

}  // namespace plant
