#include "plant/numerics/ode_start.hpp"

#include <fmt/format.h>
#include <ode/ode.h>

#include <cstdarg>
#include <mutex>
#include <stdexcept>

namespace plant {
namespace {

// ODE prints messages and exits by itself; here its errors become exceptions, and its other messages are dropped.
void complain(int number, const char* message, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof text, message, arguments);
  throw std::runtime_error(fmt::format("plant: ODE error {}: {}", number, text));
}

void ignore(int, const char*, va_list) {}

}  // namespace

void start_ode() {
  static std::once_flag once;
  std::call_once(once, [] {
    dSetErrorHandler(complain);
    dSetDebugHandler(complain);
    dSetMessageHandler(ignore);
    if (dInitODE2(0) == 0) throw std::runtime_error("plant: ODE does not start");
    if (dCheckConfiguration("ODE_double_precision") == 0)
      throw std::runtime_error("plant: ODE is built in single precision; the double precision library is needed");
  });
  thread_local const bool ready = dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll)) != 0;
  if (!ready) throw std::runtime_error("plant: ODE has no data for this thread");
  dRandSetSeed(0);
}

}  // namespace plant
