// emulator vectors: compares single instructions with the states that another core or a specification gives.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "c40/chip/chip.hpp"
#include "c40/memory/memory.hpp"
#include "cli/arguments/options.hpp"
#include "cli/arguments/text_lines.hpp"
#include "cli/arguments/vector_line.hpp"
#include "io/print.hpp"
#include "io/signals.hpp"
#include "isa/types.hpp"

namespace cli {
namespace {

using PlaceKind = Vector::Place::Kind;
using isa::Address;
using isa::Word;

constexpr Address start = 0x1000;

/// The bus accesses of the instructions.
class Bus : public c40::TraceSink {
 public:
  void instruction(const c40::TraceRecord& record) override {
    events.insert(events.end(), record.memory.begin(), record.memory.end());
  }
  void interrupt(const c40::InterruptRecord&) override {}
  std::vector<c40::MemoryEvent> events;
};

/// A chip on a board of plain RAM; all memory is zero before each vector.
class Bench {
 public:
  explicit Bench(bool every_access) : chip_(c40::Board::plain_ram()), every_access_(every_access) {
    chip_.set_trace(&bus_);
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  std::vector<std::string> differences(const Vector& vector) {
    found_.clear();
    bus_.events.clear();
    set_up(vector);
    run(vector);
    compare_registers(vector);
    compare_memory(vector);
    compare_bus(vector);
    for (const Address address : touched_) chip_.poke(address, 0);
    touched_.clear();
    // A flat board makes its pages on demand; a million vectors would need all of them.
    constexpr std::size_t most_areas = 256;
    if (chip_.memory().areas().size() > most_areas) start_afresh();
    return std::move(found_);
  }

 private:
  void start_afresh() {
    chip_ = c40::Chip(c40::Board::plain_ram());
    chip_.set_trace(&bus_);
  }

  std::uint64_t get(Vector::Place place) const {
    switch (place.kind) {
      case PlaceKind::pc: return chip_.pc();
      case PlaceKind::expansion: return chip_.expansion(static_cast<isa::Expansion>(place.code));
      case PlaceKind::primary: return chip_.register_value(static_cast<isa::Register>(place.code));
    }
    return 0;
  }
  void set(const Vector::Setting& setting) {
    if (setting.place.kind == PlaceKind::expansion)
      chip_.set_expansion(static_cast<isa::Expansion>(setting.place.code), static_cast<Word>(setting.value));
    else
      chip_.set_register(static_cast<isa::Register>(setting.place.code), setting.value);
  }
  void poke(Address address, Word value) {
    chip_.poke(address, value);
    touched_.insert(address);
  }

  void set_up(const Vector& vector) {
    chip_.reset();
    for (std::uint8_t code = 0; code < isa::register_count; ++code) set({{PlaceKind::primary, code}, 0});
    for (std::size_t i = 0; i < vector.code.size(); ++i) poke(start + static_cast<Address>(i), vector.code[i]);
    for (const Vector::Word& word : vector.memory_before) poke(word.address, word.value);
    constexpr Vector::Place status{PlaceKind::primary, isa::code(isa::Register::ST)},
        count{PlaceKind::primary, isa::code(isa::Register::RC)};
    // A write of ST sets RM only together with a count; a vector's state may have RM with any RC.
    set({count, 1});
    for (const Vector::Setting& setting : vector.before)
      if (setting.place == status) set(setting);
    set({count, 0});
    for (const Vector::Setting& setting : vector.before)
      if (setting.place != status) set(setting);
    chip_.set_pc(start);
    initial_.clear();
    for (const Vector::Place place : places()) initial_.push_back(get(place));
  }

  void run(const Vector& vector) {
    for (unsigned step = 0; step < vector.steps; ++step) {
      const c40::StopInfo stop = chip_.step();
      // At SWI no effect has happened yet; the comparison of states says the rest.
      if (stop.reason == c40::StopInfo::Reason::limit || stop.reason == c40::StopInfo::Reason::software_interrupt)
        continue;
      found_.push_back(
          fmt::format("stopped in step {}: {}", step + 1, stop.fault ? stop.fault->message : name(stop.reason)));
      return;
    }
  }

  static const std::vector<Vector::Place>& places() {
    static const std::vector<Vector::Place> all = [] {
      std::vector<Vector::Place> out{{PlaceKind::pc, 0}};
      for (std::uint8_t code = 0; code < isa::register_count; ++code) out.push_back({PlaceKind::primary, code});
      for (std::uint8_t code = 0; code < 2; ++code) out.push_back({PlaceKind::expansion, code});
      return out;
    }();
    return all;
  }

  // A register that is not named on the right has to keep its value. The PC is compared if it is named.
  void compare_registers(const Vector& vector) {
    for (std::size_t i = 0; i < places().size(); ++i) {
      const Vector::Place place = places()[i];
      const auto after =
          std::find_if(vector.after.begin(), vector.after.end(), [&](const auto& s) { return s.place == place; });
      if (after == vector.after.end() && place.kind == PlaceKind::pc) continue;
      const std::uint64_t expected = after == vector.after.end() ? initial_[i] : after->value;
      const bool is_status = place == Vector::Place{PlaceKind::primary, isa::code(isa::Register::ST)};
      const std::uint64_t mask = is_status ? vector.status_mask : ~std::uint64_t{0};
      const std::uint64_t actual = get(place);
      if (((actual ^ expected) & mask) == 0) continue;
      const bool extended =
          place.kind == PlaceKind::primary && isa::is_extended(static_cast<isa::Register>(place.code));
      found_.push_back(fmt::format("{} is {:0{}X}, expected {:0{}X}", name(place), actual & mask, extended ? 10 : 8,
                                   expected & mask, extended ? 10 : 8));
    }
  }

  void compare_memory(const Vector& vector) {
    std::map<Address, Word> expected;
    for (std::size_t i = 0; i < vector.code.size(); ++i) expected[start + static_cast<Address>(i)] = vector.code[i];
    for (const Vector::Word& word : vector.memory_before) expected[word.address] = word.value;
    for (const Vector::Word& word : vector.memory_after) expected[word.address] = word.value;
    for (const c40::MemoryEvent& event : bus_.events)
      if (event.write) expected.try_emplace(event.address, 0u), touched_.insert(event.address);
    for (const auto& [address, value] : expected) {
      const Word actual = chip_.peek(address);
      if (actual != value) found_.push_back(fmt::format("@{:08X} is {:08X}, expected {:08X}", address, actual, value));
    }
  }

  static std::vector<Vector::Access> reads_sorted(std::vector<Vector::Access> accesses) {
    const auto is_write = [](const Vector::Access& access) { return access.write; };
    for (auto from = accesses.begin(); from != accesses.end();) {
      const auto to = std::find_if(from, accesses.end(), is_write);
      std::sort(from, to, [](const auto& a, const auto& b) { return a.address < b.address; });
      from = to == accesses.end() ? to : std::next(to);
    }
    return accesses;
  }

  void compare_bus(const Vector& vector) {
    if (vector.accesses.empty() && !every_access_) return;
    const auto show = [](bool write, Address address, Word value) {
      return write ? fmt::format(" wr@{:08X}={:08X}", address, value) : fmt::format(" rd@{:08X}", address);
    };
    std::vector<Vector::Access> seen, named = vector.accesses;
    for (const c40::MemoryEvent& event : bus_.events) seen.push_back({event.address, event.write, event.value});
    // No document says which of two reads of one instruction comes first.
    const bool any_order = !every_access_ && vector.steps == 1;
    std::string actual, expected;
    for (const Vector::Access& access : any_order ? reads_sorted(seen) : seen)
      actual += show(access.write, access.address, access.value);
    for (const Vector::Access& access : any_order ? reads_sorted(named) : named)
      expected += show(access.write, access.address, access.value);
    if (actual != expected)
      found_.push_back(fmt::format("the bus shows{}, expected{}", actual.empty() ? " nothing" : actual,
                                   expected.empty() ? " nothing" : expected));
  }

  c40::Chip chip_;
  Bus bus_;
  bool every_access_;
  std::vector<std::uint64_t> initial_;
  std::set<Address> touched_;
  std::vector<std::string> found_;
};

struct Failure {
  std::string file;
  std::uint64_t line;
  std::string id;
  std::vector<std::string> differences;
};

struct Totals {
  std::uint64_t passed = 0, failed = 0;
  std::vector<Failure> failures;  ///< the first ones
  bool interrupted = false;       ///< not all vectors have been run
};

void run_file(const std::string& path, Bench& bench, Totals& totals, std::size_t shown) {
  TextLines lines(path);
  std::string line;
  while (!totals.interrupted && lines.next(line)) {
    totals.interrupted = io::stop_asked();
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos || line[first] == '#') continue;
    try {
      const Vector vector = parse_vector(line);
      std::vector<std::string> differences = bench.differences(vector);
      if (differences.empty()) {
        ++totals.passed;
        continue;
      }
      ++totals.failed;
      if (totals.failures.size() < shown)
        totals.failures.push_back({path, lines.number(), vector.id, std::move(differences)});
    } catch (const VectorError& error) {
      throw InputError(fmt::format("{}:{}: {}", path, lines.number(), error.what()));
    }
  }
}

void print_text(const Totals& totals) {
  for (const Failure& failure : totals.failures)
    for (const std::string& difference : failure.differences)
      io::print("{}:{}: {}: {}\n", failure.file, failure.line, failure.id, difference);
  if (totals.failed > totals.failures.size()) io::print("... and {} more\n", totals.failed - totals.failures.size());
  io::print("{} passed, {} failed{}\n", totals.passed, totals.failed, totals.interrupted ? "; interrupted" : "");
}

void print_json(const Totals& totals) {
  using Json = nlohmann::ordered_json;
  Json root = {{"passed", totals.passed},
               {"failed", totals.failed},
               {"stop_reason", totals.interrupted ? "interrupted" : "completed"},
               {"failures", Json::array()}};
  for (const Failure& failure : totals.failures)
    root["failures"].push_back(
        {{"file", failure.file}, {"line", failure.line}, {"id", failure.id}, {"differences", failure.differences}});
  io::print("{}\n", root.dump(2, ' ', true, Json::error_handler_t::replace));
}

}  // namespace

int vectors(const VectorOptions& options) {
  Bench bench(options.every_access);
  Totals totals;
  const io::StopBySignal signals;
  for (const std::string& file : options.files) run_file(file, bench, totals, static_cast<std::size_t>(options.show));
  if (totals.passed + totals.failed == 0 && !totals.interrupted)
    throw InputError(fmt::format("{}: contains no vector", options.files.front()));
  (options.json ? print_json : print_text)(totals);
  if (totals.interrupted) return signals.status(run_failed);
  return totals.failed == 0 ? success : run_failed;
}

}  // namespace cli
