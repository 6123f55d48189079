// Functions that SUNDIALS and ODE call instead of the C library's (portable_names.txt), with the C library's meaning.
#include <cstdio>

#include "plant/numerics/math.hpp"

extern "C" {

#pragma GCC visibility push(default)  // tests/plant/test_same_bits.py calls them in the module
double cmrc_libm_acos(double x) { return Sleef_cinz_acosd1_u10purec(x); }
float cmrc_libm_acosf(float x) { return Sleef_cinz_acosf1_u10purec(x); }
double cmrc_libm_asin(double x) { return Sleef_cinz_asind1_u10purec(x); }
float cmrc_libm_asinf(float x) { return Sleef_cinz_asinf1_u10purec(x); }
double cmrc_libm_atan2(double y, double x) { return plant::atan2(y, x); }
double cmrc_libm_pow(double x, double y) { return Sleef_cinz_powd1_u10purec(x, y); }
void cmrc_libm_sincos(double x, double* sin, double* cos) {
  const plant::SinCos both = plant::sin_cos(x);
  *sin = both.sin;
  *cos = both.cos;
}
#pragma GCC visibility pop

// ODE's archive refers to these two as if they were in the same file, which is not so in a shared module.
std::FILE* cmrc_libc_stderr = stderr;
std::FILE* cmrc_libc_stdout = stdout;
}
