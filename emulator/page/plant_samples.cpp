#include "page/plant_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cmrc/tasks/ti_float.hpp"
#include "machine/system/machine.hpp"
#include "page/columns.hpp"
#include "plant/numerics/math.hpp"
#include "plant/scene/scene.hpp"
#include "toolchain/objects/image.hpp"

namespace page {
namespace {

constexpr double metres = 1e-4, radians = 1e-5, errors = 1e-9, newtons = 100, speeds = 1e-3, directions = 1e-4;
constexpr Time finest = std::chrono::milliseconds{10};
constexpr std::array<const char*, 3> axes = {"x", "y", "z"};

Time period_for(Time span) {
  const auto rows = static_cast<std::int64_t>(PlantSamples::rows_max);
  const Time least{(span.count() + rows - 1) / rows};
  return std::max(finest, (least + finest - Time{1}) / finest * finest);
}

const char* name(plant::ContainerState state) {
  switch (state) {
    case plant::ContainerState::on_ship: return "ship";
    case plant::ContainerState::carried: return "carried";
    case plant::ContainerState::on_agv: return "agv";
    case plant::ContainerState::on_ground: return "set";
    case plant::ContainerState::delivered: return "gone";
  }
  return "gone";
}

nlohmann::json box(const plant::Box& b) { return {b.x_min, b.x_max, b.y_min, b.y_max, b.z_min, b.z_max}; }

/// An offset in shared memory that a symbol of the program names. A user's own program may not have the symbol.
std::optional<isa::Word> offset_of(const cmrc::Simulation& simulation, const char* symbol) {
  const auto& symbols = simulation.image().symbols;
  const auto found = symbols.find(symbol);
  return found == symbols.end() ? std::nullopt : std::optional(static_cast<isa::Word>(found->second));
}

}  // namespace

nlohmann::json layout_of(const plant::DockConfig& config) {
  const plant::Layout& layout = config.layout;
  const plant::CraneParameters& crane = config.crane;
  nlohmann::json containers = nlohmann::json::array(), boxes = containers, movers = containers, lanes = containers;
  for (const auto& c : layout.containers) containers.push_back({c.x, c.y, c.z, c.yaw});
  for (const auto& b : layout.no_go) boxes.push_back(box(b));
  for (const auto& m : layout.movers) movers.push_back({m.radius, m.height});
  for (const auto& leg : layout.legs)
    for (const auto& s : leg) lanes.push_back({s.x, s.y, s.heading, s.length, s.curvature});
  const bool gantry = crane.machine == plant::CraneKind::gantry;
  return {
      {"size", {plant::container_length, plant::container_width, plant::container_height}},
      {"containers", containers},
      {"ship", box(layout.ship)},
      {"ship_moves", config.ship.moves()},
      {"boxes", boxes},
      {"movers", movers},
      {"lanes", lanes},
      {"spot", {layout.spot.x, layout.spot.y}},
      {"warehouse", {layout.warehouse.x, layout.warehouse.y, layout.warehouse_radius}},
      {"agv",
       {{"count", config.agv_count},
        {"length", config.agv.length},
        {"width", config.agv.width},
        {"deck", config.agv.deck_height}}},
      {"crane",
       {{"machine", gantry ? "gantry" : "slewing"},
        {"a0", crane.a0},
        {"pivot", crane.pivot_height},
        {"counterweight", crane.counterweight_radius},
        {"reach", {crane.lower[2], crane.upper[2]}},
        {"falls", {config.landing.fall_spread_x, config.landing.fall_spread_y}},
        {"portal",
         {{"along", crane.portal.along},
          {"rails", {crane.portal.waterside, crane.portal.landside}},
          {"leg", crane.portal.leg},
          {"height", crane.portal.height}}}}},
  };
}

PlantSamples::PlantSamples(cmrc::Simulation& simulation, Time from, Time end)
    : simulation_(simulation), period_(period_for(end - from)), ship_moves_(simulation.dock().config().ship.moves()) {
  planned_crane_ = offset_of(simulation, "CR_POINT");
  if (planned_crane_) *planned_crane_ += offset_of(simulation, "CR_BASE").value_or(0);
  planned_agv_ = offset_of(simulation, "AG_POINT");
  if (planned_agv_) *planned_agv_ += offset_of(simulation, "AG_BASE").value_or(0);
  agv_words_ = offset_of(simulation, "AG_WORDS").value_or(0);
  declare();
  for (const plant::ContainerStatus& status : simulation.dock().containers()) {
    container_states_.push_back(status.state);
    stories_.push_back(nlohmann::json::array());
  }
  for (auto& state : container_states_) state = plant::ContainerState::on_ship;
  take(from);
}

// In the order in which take() fills them.
void PlantSamples::declare() {
  const plant::DockConfig& config = simulation_.dock().config();
  for (const auto& [joint, unit] : plant::joint_names(config.crane.machine))
    add(fmt::format("{}_{}", joint, unit), std::string_view(unit) == "m" ? metres : radians);
  for (const char* of : {"tip", "payload"})
    for (const char* axis : axes) add(fmt::format("{}_{}_m", of, axis), metres);
  for (const char* angle : {"payload_yaw_rad", "sway_alpha_rad", "sway_beta_rad"}) add(angle, radians);
  add("tension_N", newtons);
  add("contact", 1);
  for (const char* axis : {"x", "y"}) add(fmt::format("payload_up_{}", axis), directions);
  if (planned_crane_)
    for (const char* axis : axes) add(fmt::format("planned_{}_m", axis), metres);
  if (ship_moves_) {
    for (const char* axis : axes) add(fmt::format("ship_{}_m", axis), metres);
    for (const char* axis : {"x", "y"}) add(fmt::format("ship_up_{}", axis), directions);
  }
  for (int agv = 0; agv < config.agv_count; ++agv) {
    for (const char* axis : {"x", "y"}) add(fmt::format("agv{}_{}_m", agv, axis), metres);
    for (const char* angle : {"heading", "front", "rear"}) add(fmt::format("agv{}_{}_rad", agv, angle), radians);
    add(fmt::format("agv{}_speed_m_per_s", agv), speeds);
    if (planned_agv_)
      for (const char* axis : {"x", "y"}) add(fmt::format("agv{}_planned_{}_m", agv, axis), metres);
  }
  for (std::size_t i = 0; i < config.layout.movers.size(); ++i)
    for (const char* axis : {"x", "y"}) add(fmt::format("mover{}_{}_m", i, axis), metres);
}

void PlantSamples::take(Time now) {
  if (!times_.empty() && now <= times_.back()) return;
  times_.push_back(now);
  watch_containers(now);
  const plant::Dock& dock = simulation_.dock();
  std::size_t next = 0;
  const auto put = [&](double value) { column(next++).push_back(value); };
  // Before the first point is planned its words are 0, which a TI float reads as 1.
  const auto put_planned = [&](const std::string& name, isa::Word offset, isa::Word count) {
    bool there = false;
    for (isa::Word axis = 0; axis < count; ++axis) {
      const isa::Word word = simulation_.machine().peek(offset + axis);
      there = there || word != 0;
      put(cmrc::from_ti_float(word));
    }
    std::size_t& rows = planned_rows_[name];
    if (!there && rows + 1 == times_.size()) ++rows;
  };
  const plant::Signal signal = dock.signal();
  for (const double q : signal.q) put(q);
  for (const double value : signal.tip) put(value);
  for (const double value : signal.payload) put(value);
  put(signal.yaw), put(signal.alpha), put(signal.beta), put(signal.tension), put(signal.contact ? 1 : 0);
  const plant::Attitude attitude = dock.attitude();
  put(attitude.load_up[0]), put(attitude.load_up[1]);
  if (planned_crane_) put_planned("planned_", *planned_crane_, 3);
  if (ship_moves_) {
    for (const double value : attitude.ship_shift) put(value);
    put(attitude.ship_up[0]), put(attitude.ship_up[1]);
  }
  for (int agv = 0; agv < dock.agv_count(); ++agv) {
    const plant::AgvSignal at = dock.agv(agv);
    put(at.x), put(at.y), put(at.heading), put(at.front), put(at.rear), put(at.speed);
    if (!planned_agv_) continue;
    put_planned(fmt::format("agv{}_planned_", agv), *planned_agv_ + static_cast<isa::Word>(agv) * agv_words_, 2);
  }
  for (const plant::Mover& mover : dock.config().layout.movers) {
    const plant::MoverPlace at = plant::place_of(mover, report::seconds(now));
    put(at.x), put(at.y);
  }
}

// The place of a container follows from its carrier. The container's pose relative to the carrier is written when the
// carrier changes.
void PlantSamples::watch_containers(Time now) {
  const plant::Dock& dock = simulation_.dock();
  const std::vector<plant::ContainerStatus> all = dock.containers();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const plant::ContainerStatus& status = all[i];
    if (status.state == container_states_[i]) continue;
    container_states_[i] = status.state;
    nlohmann::json place;
    if (status.state == plant::ContainerState::carried) {
      const plant::Signal signal = dock.signal();
      place = {status.z - signal.payload[2], status.yaw - signal.yaw};
    } else if (status.state == plant::ContainerState::on_agv) {
      const plant::AgvSignal agv = dock.agv(status.agv);
      const auto [s, c] = plant::sin_cos(agv.heading);
      const double dx = status.x - agv.x, dy = status.y - agv.y;
      place = {status.agv, c * dx + s * dy, c * dy - s * dx, status.yaw - agv.heading};
    } else {
      place = {status.x, status.y, status.z - plant::container_height, status.yaw};
    }
    stories_[i].push_back({report::seconds(now), name(status.state), place});
  }
}

void PlantSamples::put(Columns& columns, nlohmann::json& header, const cmrc::Reference* reference) const {
  std::vector<double> seconds;
  for (const Time time : times_) seconds.push_back(report::seconds(time));
  // A recording that begins at a snapshot may begin between two milliseconds.
  const bool whole = times_.empty() || times_.front() % std::chrono::milliseconds{1} == Time{};
  columns.scaled("time_s", seconds, whole ? 1e-3 : 1e-9);
  for (const Column& column : columns_) columns.scaled(column.name, column.values, column.unit);
  header["layout"] = layout_of(simulation_.dock().config());
  header["containers"] = stories_;
  header["planned_rows"] = planned_rows_;
  header["ideal_until_s"] = nullptr;
  if (reference != nullptr && reference->course.size() > 0 && simulation_.course().size() > 0)
    put_ideal(columns, header, *reference);
}

// The ideal run's load is written relative to this run's load: mostly small numbers.
void PlantSamples::put_ideal(Columns& columns, nlohmann::json& header, const cmrc::Reference& reference) const {
  const cmrc::Course &run = simulation_.course(), &ideal = reference.course;
  const auto difference = [&](Time time, std::size_t column) { return ideal.at(time)[column] - run.at(time)[column]; };
  const auto distance = [&](Time time) {
    const auto away = [&](std::size_t axis) { return difference(time, cmrc::load_column + axis); };
    return std::hypot(away(0), away(1), away(2));
  };
  const Time known = std::min(run.end(), ideal.end()), step = std::max(run.step(), ideal.step());
  header["ideal_until_s"] = report::seconds(known);
  std::vector<double> error;
  std::vector<std::vector<double>> ghost(4);
  for (std::size_t row = 0; row < times_.size(); ++row) {
    const Time until = std::min(times_[row], known);
    const Time before = row == 0 ? until - Time{1} : std::min(times_[row - 1], known);
    double largest = 0;
    if (before < until) {
      for (Time at = (before / step + 1) * step; at < until; at += step) largest = std::max(largest, distance(at));
      largest = std::max(largest, distance(until));
    }
    error.push_back(largest);
    for (std::size_t axis = 0; axis < 3; ++axis) ghost[axis].push_back(difference(until, cmrc::load_column + axis));
    constexpr auto slew = static_cast<std::size_t>(plant::Joint::slew),
                   kappa = static_cast<std::size_t>(plant::Joint::rotator);
    ghost[3].push_back(difference(until, slew) + difference(until, kappa));
  }
  columns.scaled("load_error_m", error, errors);
  const auto joints = plant::joint_names(simulation_.dock().config().crane.machine);
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    std::vector<double> away;
    for (const Time time : times_) away.push_back(-difference(std::min(time, known), joint));
    columns.scaled(fmt::format("{}_error_{}", joints[joint].name, joints[joint].unit), away, errors);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    columns.scaled(fmt::format("ghost_{}_m", axes[axis]), ghost[axis], metres);
  columns.scaled("ghost_yaw_rad", ghost[3], radians);
  for (int agv = 0; agv < simulation_.dock().agv_count(); ++agv) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      std::vector<double> away;
      for (const Time time : times_)
        away.push_back(difference(std::min(time, known), cmrc::agv_column + 2 * static_cast<std::size_t>(agv) + axis));
      columns.scaled(fmt::format("agv{}_ghost_{}_m", agv, axes[axis]), away, metres);
    }
  }
}

}  // namespace page
