// The latch's part of the AGVs: motion, collisions, range sensors, the warehouse.
#include <cmath>
#include <limits>

#include "plant/dock/dock_core.hpp"
#include "plant/dock/sensors.hpp"

namespace plant {

void DockCore::move_agvs() {
  for (AgvState& agv : state.agvs) agv_motion.advance(agv, agv_latches * latch_seconds);
  if (config.collisions) {
    solids_.clear();
    each_solid(config, state, -1, [this](const Solid& solid) {
      const bool load =
          solid.kind == Solid::Kind::container && state.containers[static_cast<std::size_t>(solid.index)].agv >= 0;
      if (!load && solid.bottom < config.agv.deck_height) solids_.push_back(solid);  // not above every vehicle
    });
    traffic.collide(state.agvs, solids_, [this](std::size_t agv, int other, double speed) {
      report(EventKind::collision, static_cast<int>(agv), speed, other);
    });
  }
  for (std::size_t i = 0; i < state.agvs.size(); ++i) {
    AgvState& agv = state.agvs[i];
    if (!state.scans.empty() && range_ticks(i, state.latch) > range_ticks(i, state.latch - agv_latches)) look(i);
    if (AgvMotion::take_set_point(agv, now())) report(EventKind::agv_dry, static_cast<int>(i));
    const SampleClock clock = unit_clock(i);
    if (ticks_until(clock, state.latch, tick_latches) > ticks_until(clock, state.latch - agv_latches, tick_latches)) {
      const double allowed =
          config.agv.protective_field ? traffic.allowed_speed(agv, scan(i)) : std::numeric_limits<double>::infinity();
      agv_motion.drive_tick(agv, allowed);
      serve_warehouse(i);
    }
  }
}

std::int64_t DockCore::range_ticks(std::size_t agv, std::int64_t latch) const {
  return range_ticks_until(config.sensors, range_clock(agv), latch);
}

// The scan is of the last step.
std::uint32_t DockCore::scan_number(std::size_t agv) const {
  return static_cast<std::uint32_t>(range_ticks(agv, state.latch - state.latch % agv_latches));
}

const Geometry::Scan& DockCore::scan(std::size_t agv) {
  if (!state.scans.empty()) return state.scans[agv];
  fresh_.resize(state.agvs.size());
  Fresh& fresh = fresh_[agv];
  if (fresh.latch != state.latch) {
    collect_solids(config, state, state.agvs[agv].container, solids_);
    fresh = {state.latch, traffic.scan(state.agvs[agv], agv, solids_)};
  }
  return fresh.codes;
}

// Takes a sample of a range sensor with its own rate; some rays have no echo.
void DockCore::look(std::size_t agv) {
  collect_solids(config, state, state.agvs[agv].container, solids_);
  Geometry::Scan codes = traffic.scan(state.agvs[agv], agv, solids_);
  const std::int64_t number = range_ticks(agv, state.latch);
  for (std::size_t ray = 0; ray < codes.size(); ++ray)
    if (drops(config.sensors, agv, number * range_rays + static_cast<std::int64_t>(ray))) codes[ray] = 0;
  state.scans[agv] = codes;
}

void DockCore::serve_warehouse(std::size_t index) {
  AgvState& agv = state.agvs[index];
  const Layout& layout = config.layout;
  const double dx = agv.y[A_X] - layout.warehouse.x;
  const double dy = agv.y[A_Y] - layout.warehouse.y;
  const bool there = dx * dx + dy * dy <= layout.warehouse_radius * layout.warehouse_radius;
  if (!agv.standing || agv.container < 0 || !there) {
    agv.served_since = Time{-1};
    return;
  }
  if (agv.served_since.count() < 0) {
    agv.served_since = now();
    report(EventKind::agv_arrived, static_cast<int>(index));
  }
  if (now() - agv.served_since < Time{std::llround(layout.warehouse_take * 1e12)}) return;
  ContainerData& container = state.containers[static_cast<std::size_t>(agv.container)];
  container.state = ContainerState::delivered;
  container.agv = -1;
  ++state.delivered;
  report(EventKind::delivered, agv.container, static_cast<double>(index));
  agv.container = -1;
  agv.load_mass = agv.load_inertia = 0.0;
  agv.served_since = Time{-1};
}

}  // namespace plant
