#pragma once
#include <cfenv>

/// While it lives, this thread calculates as a new process does: to nearest, with denormal numbers. A library that was
/// compiled with -ffast-math takes denormal numbers from the whole thread, only by being loaded.
class UsualFloats {
 public:
  UsualFloats() {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~UsualFloats() { std::fesetenv(&before_); }
  UsualFloats(const UsualFloats&) = delete;
  UsualFloats& operator=(const UsualFloats&) = delete;

 private:
  std::fenv_t before_{};
};
