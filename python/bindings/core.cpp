#include "python/bindings/bindings.hpp"

PYBIND11_MODULE(_core, core) {
  core.doc() = "The emulator's C++ core. Use the package cmrc; this module is its private part.";
  bind_io(core);
  bind_report(core);
  bind_isa(core);
  bind_toolchain(core);
  bind_c40(core);
  bind_plant(core);
  bind_debug(core);
  bind_network(core);
  bind_cmrc(core);
  bind_why_late(core);
  bind_trace(core);
}
