// The 40-bit arithmetic.
#include <pybind11/stl.h>

#include "c40/values/float40.hpp"
#include "python/bindings/c40/c40.hpp"
#include "python/bindings/c40/chip_inspection.hpp"

using c40::Float40;
using c40::Word;

namespace {

std::uint64_t bits(Float40 x) { return c40::float40::bits(x); }
Float40 from_bits(std::uint64_t bits) { return c40::float40::from_bits(bits); }
std::pair<std::uint64_t, Word> pair(const c40::FloatResult& r) { return {bits(r.value), r.flags}; }

}  // namespace

void bind_float40(py::module_& m) {
  namespace f = c40::float40;
  auto sub =
      m.def_submodule("float40", "The 40-bit arithmetic: operands and results are 40-bit integers, flags as in ST.");
  const auto unary = [&](const char* name, c40::FloatResult (*operation)(Float40)) {
    sub.def(name, [operation](std::uint64_t a) { return pair(operation(from_bits(a))); });
  };
  const auto binary = [&](const char* name, c40::FloatResult (*operation)(Float40, Float40)) {
    sub.def(name,
            [operation](std::uint64_t a, std::uint64_t b) { return pair(operation(from_bits(a), from_bits(b))); });
  };
  binary("add", &f::add);
  binary("sub", &f::sub);
  binary("mul", &f::mul);
  unary("neg", &f::neg);
  unary("abs", &f::abs);
  unary("rnd", &f::rnd);
  unary("norm", &f::norm);
  unary("rcp", &f::rcp);
  unary("rsqr", &f::rsqr);
  unary("to_ieee", &f::to_ieee);
  unary("load", &f::load);
  sub.def("from_ieee", [](Word word) { return pair(f::from_ieee(word)); });
  sub.def("from_integer", [](Word word) { return pair(f::from_integer(word)); });
  sub.def("fix", [](std::uint64_t a) {
    const c40::FixResult r = f::fix(from_bits(a));
    return std::pair{r.value, r.flags};
  });
  sub.def("from_single", [](Word word) { return bits(f::from_single(word)); });
  sub.def("to_single", [](std::uint64_t a) { return f::to_single(from_bits(a)); });
  sub.def("from_short", [](Word half) { return bits(f::from_single(f::short_to_single(half & 0xFFFFu))); });
  sub.def("value", [](std::uint64_t a) { return value_of(from_bits(a)); }, "The exact value as a Fraction.");
}
