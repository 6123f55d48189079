// A bus with plain masters, bridges and memories.
#include "bus_model/bus.hpp"

#include <pybind11/stl.h>

#include <deque>
#include <optional>
#include <stdexcept>

#include "bus_model/audit.hpp"
#include "bus_model/bridge.hpp"
#include "bus_model/bus_bridge.hpp"
#include "tests/bindings/bindings.hpp"

namespace {

using namespace pci;

class Memory final : public Target {
 public:
  explicit Memory(std::size_t words) : words_(words) {}
  Answer answer(Address, unsigned, bool, const Access&) override { return answer_; }
  Word read(Address offset, const Access& access) override {
    if (log) accesses.push_back({false, offset, words_[offset], access.master, access.clock});
    return words_[offset];
  }
  void write(Address offset, Word value, const Access& access) override {
    if (log) accesses.push_back({true, offset, value, access.master, access.clock});
    words_[offset] = value;
  }
  struct Logged {
    bool write;
    Address offset;
    Word value;
    unsigned master;
    Clocks clock;
  };
  std::vector<Word> words_;
  std::vector<Logged> accesses;
  Answer answer_ = Answer::accept;
  bool log = true;
};

struct Ended {
  Transaction transaction;
  std::vector<Word> words;
};

struct Master final : Initiator {
  explicit Master(std::vector<Ended>& list) : ended{list} {}
  unsigned framed(const Attempt& attempt, bool, Clocks, std::span<Word>) override { return attempt.wanted; }
  void completed(const Transaction& transaction, std::span<const Word> words) override {
    ended.push_back({transaction, {words.begin(), words.end()}});
  }
  std::vector<Ended>& ended;
};

struct PyBridge final : Bridge::Client {
  PyBridge(Bus& bus, const MasterConfig& master, const BridgeConfig& config) : bridge{bus, master, config, *this} {}
  void answered(Word value, Clocks ready, Clocks arbitration, Result result) override {
    answer = {value, ready, arbitration, result};
  }
  void taken(Clocks ready, Clocks) override { room = ready; }
  void landed(const Posted& posted, Clocks clock, Result) override {
    landings.emplace_back(posted.address, posted.value, clock);
  }
  std::optional<std::tuple<Word, Clocks, Clocks, Result>> take_answer() { return std::exchange(answer, std::nullopt); }
  std::optional<Clocks> take_room() { return std::exchange(room, std::nullopt); }
  std::optional<std::pair<Word, Clocks>> look_up(Address address) const {
    Bridge::Hit hit{};
    if (!bridge.look_up(address, hit)) return std::nullopt;
    return std::pair{hit.value, hit.ready};
  }
  std::optional<std::tuple<Word, Clocks, Clocks, Result>> answer;
  std::optional<Clocks> room;
  std::vector<std::tuple<Address, Word, Clocks>> landings;
  Bridge bridge;
};

class PyBus final : public Monitor {
 public:
  explicit PyBus(const BusConfig& config) : bus{config} { bus.set_monitor(this); }
  void attempted(const Attempt& attempt) override { attempts.push_back(attempt); }
  void ended(const Transaction&) override {}
  unsigned add_master(const MasterConfig& config) { return bus.add_master(config, masters.emplace_back(all_ended)); }
  Memory& add_memory(const TargetConfig& config, Address base, std::size_t words) {
    Memory& memory = memories.emplace_back(words);
    bus.add_target(config, memory, base, words);
    return memory;
  }
  PyBridge& add_bridge(const MasterConfig& master, const BridgeConfig& config) {
    return bridges.emplace_back(bus, master, config);
  }
  void read(unsigned master, Address address, unsigned words, Clocks clock) {
    bus.submit(master, false, address, words, clock);
  }
  void write(unsigned master, Address address, const std::vector<Word>& words, Clocks clock, Command command) {
    if (words.size() > Bus::most_words) throw std::invalid_argument{"a transaction has at most 256 words"};
    if (!is_write(command)) throw std::invalid_argument{"a write's command is write or write_invalidate"};
    std::copy(words.begin(), words.end(), bus.buffer(master).begin());
    bus.submit(master, command, address, static_cast<unsigned>(words.size()), clock, bus.master_config(master).agent);
  }
  std::vector<Ended> take_ended() { return std::exchange(all_ended, {}); }
  std::vector<Ended> advance_to(Clocks clock) {
    bus.advance_to(clock);
    return take_ended();
  }

  Bus bus;
  std::deque<Memory> memories;
  std::deque<PyBridge> bridges;
  std::vector<Attempt> attempts;

 private:
  std::vector<Ended> all_ended;
  std::deque<Master> masters;
};

// Buses and bridges between them, in one time.
class PyBuses final : public BusBridge::Client {
 public:
  explicit PyBuses(unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
      BusConfig config;
      config.name = std::string(1, static_cast<char>('A' + i));
      buses.emplace_back(config);
    }
  }
  void join(unsigned first, unsigned second, const BusBridgeConfig& config) {
    bridges.emplace_back(buses.at(first).bus, buses.at(second).bus, config, this);
  }
  void claim(std::size_t bridge, unsigned near, Address base, std::uint64_t words) {
    bridges.at(bridge).claim(buses.at(near).bus, "window", base, words);
  }
  std::optional<Clocks> next_event() const {
    Clocks next = never;
    for (const PyBus& bus : buses) next = std::min(next, bus.bus.next_event());
    return next == never ? std::nullopt : std::optional{next};
  }
  /// The earliest event of all, the lower bus first; gives (bus, transaction) of what has ended.
  std::vector<std::pair<unsigned, Ended>> step() {
    unsigned earliest = 0;
    for (unsigned i = 1; i < buses.size(); ++i)
      if (buses[i].bus.next_event() < buses[earliest].bus.next_event()) earliest = i;
    buses[earliest].bus.step();
    std::vector<std::pair<unsigned, Ended>> all;
    for (Ended& one : buses[earliest].take_ended()) all.emplace_back(earliest, std::move(one));
    return all;
  }
  void forget(unsigned agent) {
    for (BusBridge& bridge : bridges) bridge.forget(agent);
  }
  void delivered(const Bus&, unsigned agent, Address address, Word value, Clocks clock, Result) override {
    deliveries.emplace_back(agent, address, value, clock);
  }

  std::deque<PyBus> buses;
  std::deque<BusBridge> bridges;
  std::vector<std::tuple<unsigned, Address, Word, Clocks>> deliveries;
};

}  // namespace

void bind_bus_model(py::module_& test) {
  py::module_ m = test.def_submodule(
      "bus_model", "PCI: transactions, arbitration, targets, bridges, statistics. All times are bus clocks.");
  bind_bus_settings(m);
  py::class_<Ended>(m, "Transaction", "A finished transaction, with its words when it was a read.")
      .def_readonly("words", &Ended::words)
      .def_property_readonly("number", [](const Ended& e) { return e.transaction.number; })
      .def_property_readonly("address", [](const Ended& e) { return e.transaction.address; })
      .def_property_readonly("count", [](const Ended& e) { return e.transaction.words; })
      .def_property_readonly("master", [](const Ended& e) { return e.transaction.master; })
      .def_property_readonly("target", [](const Ended& e) { return e.transaction.target; })
      .def_property_readonly("write", [](const Ended& e) { return e.transaction.write; })
      .def_property_readonly("result", [](const Ended& e) { return e.transaction.result; })
      .def_property_readonly("command", [](const Ended& e) { return e.transaction.command; })
      .def_property_readonly("requested", [](const Ended& e) { return e.transaction.requested; })
      .def_property_readonly("granted", [](const Ended& e) { return e.transaction.granted; })
      .def_property_readonly("framed", [](const Ended& e) { return e.transaction.framed; })
      .def_property_readonly("first_data", [](const Ended& e) { return e.transaction.first_data; })
      .def_property_readonly("ended", [](const Ended& e) { return e.transaction.ended; })
      .def_property_readonly("waited", [](const Ended& e) { return e.transaction.waited; })
      .def_property_readonly("retries", [](const Ended& e) { return e.transaction.retries; })
      .def_property_readonly("disconnects", [](const Ended& e) { return e.transaction.disconnects; });
  bind_bus_statistics(m);
  py::class_<Memory::Logged>(m, "Access")
      .def_readonly("write", &Memory::Logged::write)
      .def_readonly("offset", &Memory::Logged::offset)
      .def_readonly("value", &Memory::Logged::value)
      .def_readonly("master", &Memory::Logged::master)
      .def_readonly("clock", &Memory::Logged::clock);
  py::class_<Memory>(m, "Memory")
      .def_readwrite("answer", &Memory::answer_)
      .def_readonly("accesses", &Memory::accesses)
      .def("__getitem__", [](const Memory& memory, std::size_t i) { return memory.words_.at(i); })
      .def("__setitem__", [](Memory& memory, std::size_t i, Word word) { memory.words_.at(i) = word; });
  py::class_<PyBridge>(m, "Bridge")
      .def_property_readonly("master", [](const PyBridge& b) { return b.bridge.master(); })
      .def_property_readonly("blocked", [](const PyBridge& b) { return b.bridge.blocked(); })
      .def_property_readonly("posted", [](const PyBridge& b) { return b.bridge.posted(); })
      .def_readonly("landings", &PyBridge::landings)
      .def("has_room", [](const PyBridge& b) { return b.bridge.has_room(); })
      .def(
          "write",
          [](PyBridge& b, Address address, Word value, Clocks clock) { b.bridge.write({address, value, clock}); },
          py::arg("address"), py::arg("value"), py::arg("clock"))
      .def(
          "read", [](PyBridge& b, Address address, Clocks clock) { b.bridge.read(address, clock); }, py::arg("address"),
          py::arg("clock"))
      .def("look_up", &PyBridge::look_up)
      .def("clear", [](PyBridge& b, Clocks clock) { b.bridge.clear(clock); })
      .def("take_answer", &PyBridge::take_answer, "(value, ready, arbitration clocks, result), once")
      .def("take_room", &PyBridge::take_room);
  py::class_<PyBus>(m, "Bus")
      .def(py::init<const BusConfig&>(), py::arg("config") = BusConfig{})
      .def("add_master", &PyBus::add_master, py::arg("config") = MasterConfig{})
      .def("add_memory", &PyBus::add_memory, py::arg("config") = TargetConfig{}, py::arg("base") = 0,
           py::arg("words") = 0x1000, py::return_value_policy::reference_internal)
      .def("add_bridge", &PyBus::add_bridge, py::arg("master") = MasterConfig{}, py::arg("config") = BridgeConfig{},
           py::return_value_policy::reference_internal)
      .def("read", &PyBus::read, py::arg("master"), py::arg("address"), py::arg("words"), py::arg("clock"))
      .def("write", &PyBus::write, py::arg("master"), py::arg("address"), py::arg("words"), py::arg("clock"),
           py::arg("command") = Command::write)
      .def(
          "stall", [](PyBus& b, Clocks from, Clocks until) { b.bus.stall(from, until); }, py::arg("now"),
          py::arg("until"))
      .def(
          "audit", [](const PyBus& b, Clocks clock) { return audit(b.bus, clock); }, py::arg("clock"))
      .def(
          "withdraw", [](PyBus& b, unsigned master, Clocks clock) { return b.bus.withdraw(master, clock); },
          py::arg("master"), py::arg("clock"))
      .def("advance_to", &PyBus::advance_to, py::arg("clock"),
           "Lets everything up to and with the clock happen; gives what has ended, in order.")
      .def("next_event",
           [](const PyBus& b) -> std::optional<Clocks> {
             return b.bus.next_event() == never ? std::nullopt : std::optional{b.bus.next_event()};
           })
      .def("now", [](const PyBus& b) { return b.bus.now(); })
      .def_readonly("attempts", &PyBus::attempts)
      .def(
          "statistics", [](const PyBus& b, Clocks clock) { return b.bus.statistics(clock); }, py::arg("clock"))
      .def("master_statistics", [](const PyBus& b, unsigned master) { return b.bus.master_statistics(master); })
      .def("target_statistics", [](const PyBus& b, unsigned target) { return b.bus.target_statistics(target); });
  py::class_<PyBuses>(m, "Buses", "Several buses with bridges between them.")
      .def(py::init<unsigned>(), py::arg("count"))
      .def(
          "__getitem__", [](PyBuses& b, std::size_t i) -> PyBus& { return b.buses.at(i); },
          py::return_value_policy::reference_internal)
      .def("join", &PyBuses::join, py::arg("first"), py::arg("second"), py::arg("config") = BusBridgeConfig{})
      .def("claim", &PyBuses::claim, py::arg("bridge"), py::arg("near"), py::arg("base"), py::arg("words"))
      .def("forget", &PyBuses::forget, py::arg("agent"))
      .def("next_event", &PyBuses::next_event)
      .def("step", &PyBuses::step)
      .def_readonly("deliveries", &PyBuses::deliveries,
                    "(agent, address, value, clock) of posted words that have landed");
}
