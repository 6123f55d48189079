#pragma once
// The dock at equal intervals of a run, and beside it the ideal run's.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/run/simulation.hpp"
#include "isa/word.hpp"
#include "machine/time/time.hpp"
#include "nlohmann/json.hpp"
#include "plant/dock/dock.hpp"

namespace page {

class Columns;
using machine::Time;

/// The parts of the dock and their places, for drawing: m and rad.
nlohmann::json layout_of(const plant::DockConfig& config);

class PlantSamples {
 public:
  /// For a run that ends at `end`: samples 10 ms apart; in a long run farther apart, so that there are at most
  /// `rows_max`.
  static constexpr std::size_t rows_max = 20'000;
  PlantSamples(cmrc::Simulation& simulation, Time from, Time end);

  Time period() const { return period_; }
  void take(Time now);
  /// Writes the columns; and into the header how containers changed their carriers.
  void put(Columns& columns, nlohmann::json& header, const cmrc::Reference* reference) const;

 private:
  struct Column {
    std::string name;
    double unit;
    std::vector<double> values;
  };
  std::vector<double>& column(std::size_t number) { return columns_[number].values; }
  void add(std::string name, double unit) { columns_.push_back({std::move(name), unit, {}}); }
  void declare();
  void watch_containers(Time now);
  void put_ideal(Columns& columns, nlohmann::json& header, const cmrc::Reference& reference) const;

  cmrc::Simulation& simulation_;
  Time period_;
  std::vector<Time> times_;
  std::vector<Column> columns_;
  bool ship_moves_;
  std::optional<isa::Word> planned_crane_, planned_agv_;  // offsets of the planned points, if the program has them
  isa::Word agv_words_ = 0;
  std::map<std::string, std::size_t> planned_rows_;  // by how their columns' names begin, rows before a first plan
  std::vector<plant::ContainerState> container_states_;
  nlohmann::json stories_ = nlohmann::json::array();
};

}  // namespace page
