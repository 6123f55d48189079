// cmrc._core.c40.Link: two processors whose ports are joined.
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "c40/peripherals/link.hpp"
#include "python/bindings/c40/c40.hpp"
#include "python/bindings/c40/processor.hpp"

namespace {

/// A link of two processors; its events as dicts.
class Link : public c40::LinkListener {
 public:
  using End = std::pair<Processor*, int>;
  static c40::Link::Side side(End end, std::pair<std::int64_t, std::int64_t> hertz) {
    return {"port " + std::to_string(end.second), end.second, &end.first->chip.port(end.second),
            c40::PacedClock{c40::Clock{hertz.first, hertz.second}}};
  }
  Link(End a, End b, std::pair<std::int64_t, std::int64_t> hertz_a, std::pair<std::int64_t, std::int64_t> hertz_b)
      : link(side(a, hertz_a), side(b, hertz_b)), ends{a, b} {
    a.first->chip.attach(a.second, &link.listener(0));
    b.first->chip.attach(b.second, &link.listener(1));
    link.listener_of_events = this;
  }
  void happened(const c40::LinkEvent& e) override {
    events.append(py::dict(py::arg("kind") = std::string(name(e.kind)), py::arg("time") = e.time.count(),
                           py::arg("side") = e.side, py::arg("word") = e.word, py::arg("bytes") = e.bytes));
  }
  ~Link() override {
    for (const End& end : ends) end.first->chip.attach(end.second, nullptr);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  c40::Link link;
  std::array<End, 2> ends;
  py::list events;
};

}  // namespace

void bind_link(py::module_& m) {
  using c40::Time;
  py::class_<Link>(m, "Link",
                   "A link of two ports, driven by whoever drives the processors. Ends are (processor, port), clocks "
                   "(numerator, denominator) in Hz, times picoseconds.")
      .def(py::init<Link::End, Link::End, std::pair<std::int64_t, std::int64_t>,
                    std::pair<std::int64_t, std::int64_t>>(),
           py::arg("a"), py::arg("b"), py::arg("hertz_a") = std::pair{20'000'000, 1},
           py::arg("hertz_b") = std::pair{20'000'000, 1}, py::keep_alive<1, 2>(), py::keep_alive<1, 3>())
      .def("advance_to", [](Link& l, std::int64_t t) { l.link.advance_to(Time{t}); })
      .def_property_readonly("next_event",
                             [](const Link& l) -> std::optional<std::int64_t> {
                               return l.link.next_event() == c40::never ? std::nullopt
                                                                        : std::optional{l.link.next_event().count()};
                             })
      .def("cut", [](Link& l, std::int64_t t) { l.link.cut(Time{t}); })
      .def("restore", [](Link& l, std::int64_t t) { l.link.restore(Time{t}); })
      .def_property_readonly("is_dead", [](const Link& l) { return l.link.is_dead(); })
      .def_property_readonly("lookahead", [](const Link& l) { return l.link.lookahead().count(); })
      .def("counters",
           [](const Link& l, int side) {
             const auto& c = l.link.counters(side);
             return py::dict(py::arg("sent") = c.sent, py::arg("arrived") = c.arrived, py::arg("lost") = c.lost,
                             py::arg("tokens") = c.tokens, py::arg("under_way") = l.link.under_way(side));
           })
      .def_readonly("events", &Link::events);
}
