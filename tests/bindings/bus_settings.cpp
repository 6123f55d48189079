// How buses, masters, targets and bridges are set.
#include "bus_model/bridge.hpp"
#include "bus_model/bus.hpp"
#include "bus_model/bus_bridge.hpp"
#include "tests/bindings/bindings.hpp"

using namespace pci;

void bind_bus_settings(py::module_& m) {
  py::enum_<Arbitration>(m, "Arbitration")
      .value("round_robin", Arbitration::round_robin)
      .value("fixed", Arbitration::fixed)
      .value("two_level", Arbitration::two_level)
      .value("host_fair", Arbitration::host_fair);
  py::enum_<Command>(m, "Command")
      .value("read", Command::read)
      .value("read_line", Command::read_line)
      .value("read_multiple", Command::read_multiple)
      .value("write", Command::write)
      .value("write_invalidate", Command::write_invalidate);
  py::enum_<Parking>(m, "Parking")
      .value("none", Parking::none)
      .value("last_owner", Parking::last_owner)
      .value("first", Parking::first);
  py::enum_<Result>(m, "Result")
      .value("done", Result::done)
      .value("master_abort", Result::master_abort)
      .value("target_abort", Result::target_abort)
      .value("withdrawn", Result::withdrawn);
  py::enum_<Answer>(m, "Answer")
      .value("accept", Answer::accept)
      .value("retry", Answer::retry)
      .value("abort", Answer::abort);
  py::enum_<Attempt::Kind>(m, "AttemptKind")
      .value("data", Attempt::Kind::data)
      .value("retry", Attempt::Kind::retry)
      .value("master_abort", Attempt::Kind::master_abort)
      .value("target_abort", Attempt::Kind::target_abort);
  py::class_<BusConfig>(m, "BusConfig")
      .def(py::init<>())
      .def_readwrite("name", &BusConfig::name)
      .def_readwrite("arbitration", &BusConfig::arbitration)
      .def_readwrite("parking", &BusConfig::parking)
      .def_readwrite("grant_clocks", &BusConfig::grant_clocks)
      .def_readwrite("fast_back_to_back", &BusConfig::fast_back_to_back)
      .def_readwrite("multi_transaction_timer", &BusConfig::multi_transaction_timer)
      .def_readwrite("line_words", &BusConfig::line_words)
      .def_readwrite("host_bridge", &BusConfig::host_bridge);
  py::class_<MasterConfig>(m, "MasterConfig")
      .def(py::init<>())
      .def_readwrite("name", &MasterConfig::name)
      .def_readwrite("latency_timer", &MasterConfig::latency_timer)
      .def_readwrite("request_off_after_stop", &MasterConfig::request_off_after_stop)
      .def_readwrite("think_on_retry", &MasterConfig::think_on_retry)
      .def_readwrite("max_burst", &MasterConfig::max_burst)
      .def_readwrite("first_level", &MasterConfig::first_level)
      .def_readwrite("agent", &MasterConfig::agent);
  py::class_<Prefetch>(m, "Prefetch")
      .def(py::init<unsigned, unsigned, unsigned>(), py::arg("read") = 0, py::arg("line") = 0, py::arg("multiple") = 0);
  py::class_<TargetConfig>(m, "TargetConfig")
      .def(py::init<>())
      .def_static("sram", &TargetConfig::sram)
      .def_static("s5933", &TargetConfig::s5933)
      .def_static("drive_card", &TargetConfig::drive_card)
      .def_static("host_dram", &TargetConfig::host_dram)
      .def_readwrite("name", &TargetConfig::name)
      .def_readwrite("devsel", &TargetConfig::devsel)
      .def_readwrite("read_initial", &TargetConfig::read_initial)
      .def_readwrite("read_step", &TargetConfig::read_step)
      .def_readwrite("write_initial", &TargetConfig::write_initial)
      .def_readwrite("write_step", &TargetConfig::write_step)
      .def_readwrite("max_burst", &TargetConfig::max_burst)
      .def_readwrite("delayed_read", &TargetConfig::delayed_read)
      .def_readwrite("fetch", &TargetConfig::fetch)
      .def_readwrite("prefetch", &TargetConfig::prefetch)
      .def_readwrite("post_words", &TargetConfig::post_words)
      .def_readwrite("post_drain", &TargetConfig::post_drain);
  py::class_<BridgeConfig>(m, "BridgeConfig")
      .def(py::init<>())
      .def_readwrite("request_sync", &BridgeConfig::request_sync)
      .def_readwrite("return_sync", &BridgeConfig::return_sync)
      .def_readwrite("post_depth", &BridgeConfig::post_depth)
      .def_readwrite("prefetch_words", &BridgeConfig::prefetch_words)
      .def_readwrite("prefetch_limit", &BridgeConfig::prefetch_limit);
  py::class_<BusBridgeConfig>(m, "BusBridgeConfig")
      .def(py::init<>())
      .def_readwrite("post_depth", &BusBridgeConfig::post_depth)
      .def_readwrite("delayed_reads", &BusBridgeConfig::delayed_reads)
      .def_readwrite("prefetch_lines", &BusBridgeConfig::prefetch_lines)
      .def_readwrite("forward", &BusBridgeConfig::forward)
      .def_readwrite("latency_timer", &BusBridgeConfig::latency_timer);
}
