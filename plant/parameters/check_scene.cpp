// Checks of everything on the dock at the start: in reach, not overlapping, standing on something, clear of the lanes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "plant/crane/crane.hpp"
#include "plant/parameters/check.hpp"
#include "plant/parameters/holding.hpp"
#include "plant/scene/scene.hpp"

namespace plant {
namespace {

struct Thing {
  std::string name;
  Solid solid;
};

// The crane's legs at the start.
std::vector<Solid> legs_of(const DockConfig& c) {
  std::vector<Solid> legs;
  const double at = c.crane.machine == CraneKind::gantry ? c.home.x : c.home.s;
  each_leg(c.crane.portal, at, 0.0, [&legs](const Solid& leg) { legs.push_back(leg); });
  return legs;
}

// All objects on the dock at the start that must not overlap.
std::vector<Thing> things(const DockConfig& c) {
  std::vector<Thing> all;
  for (std::size_t i = 0; i < c.layout.no_go.size(); ++i)
    all.push_back({fmt::format("box {}", i), solid_of(Solid::Kind::fixed, c.layout.no_go[i])});
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    all.push_back(
        {fmt::format("container {}", i), make_solid(Solid::Kind::container, -1, p.x, p.y, p.yaw, 0.5 * container_length,
                                                    0.5 * container_width, p.z, p.z + container_height)});
  }
  for (std::size_t i = 0; i < c.layout.movers.size(); ++i) {
    const Mover& m = c.layout.movers[i];
    const MoverPlace at = place_of(m, 0.0);
    all.push_back({fmt::format("mover {}", i),
                   make_solid(Solid::Kind::mover, -1, at.x, at.y, 0.0, m.radius, m.radius, 0.0, m.height)});
  }
  for (int i = 0; i < c.agv_count; ++i) {
    const Pose at = start_of_agv(c.layout, i);
    all.push_back({fmt::format("AGV {}", i), solid_of(c.agv, i, at.x, at.y, at.heading)});
  }
  const std::vector<Solid> legs = legs_of(c);
  for (std::size_t i = 0; i < legs.size(); ++i) all.push_back({fmt::format("the crane's leg {}", i), legs[i]});
  return all;
}

// A vehicle on its lane must not run into the crane at the crane's place at the start.
void check_lanes(const DockConfig& c) {
  constexpr double sampled = 0.5;  // m
  const std::vector<Solid> legs = legs_of(c);
  for (const auto& lane : c.layout.legs)
    for (const LaneSegment& s : lane) {
      refuse(!(s.length >= 0.0 && s.length <= 1e5), "a lane's length must be 0 to 1e5 m", s.length);
      for (int i = 0; i * sampled <= s.length; ++i) {
        const Pose at = along(s, i * sampled);
        const Solid vehicle = solid_of(c.agv, -1, at.x, at.y, at.heading);
        for (const Solid& leg : legs)
          if (overlaps(vehicle, leg, 0.0))
            throw std::invalid_argument(fmt::format(
                "plant: an AGV at ({:.2f}, {:.2f}) m of its lane runs into the crane's leg at ({:.2f}, {:.2f}) m; "
                "move the lane or the crane's portal",
                at.x, at.y, leg.x, leg.y));
      }
    }
}

void check_apart(const DockConfig& c) {
  constexpr double play = 1e-3;  // m, by which neighbours may overlap because a layout has rounded numbers
  std::vector<Thing> all = things(c);
  all.push_back({"the ship", solid_of(Solid::Kind::ship, c.layout.ship)});
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      // A box may be a part of the ship, and check_standing() looks below the containers.
      const bool aboard = all[i].solid.kind == Solid::Kind::fixed || all[i].solid.kind == Solid::Kind::container;
      if (all[j].solid.kind == Solid::Kind::ship && aboard) continue;
      const Solid& a = all[i].solid;
      const Solid& b = all[j].solid;
      if (std::min(a.top, b.top) - std::max(a.bottom, b.bottom) <= play || !overlaps(a, b, -play)) continue;
      throw std::invalid_argument(
          fmt::format("plant: {} and {} are inside each other, at ({:.2f}, {:.2f}) and ({:.2f}, {:.2f}) m", all[i].name,
                      all[j].name, a.x, a.y, b.x, b.y));
    }
}

void check_reach(const DockConfig& c) {
  const auto reach = [&c](const std::string& what, double x, double y, double z) {
    try {
      inverse_kinematics(c.crane, {c.home.s, x, y, z, c.home.yaw});
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}; so the crane cannot reach {}", error.what(), what));
    }
  };
  reach("its home", c.home.x, c.home.y, c.home.z);
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    reach(fmt::format("container {}", i), p.x, p.y, p.z + container_height);
  }
  if (c.agv_count > 0) reach("the loading spot", c.layout.spot.x, c.layout.spot.y, c.agv.deck_height);
}

// Each container stands on something, and nothing is inside the spreader at home.
void check_standing(const DockConfig& c) {
  constexpr double play = 0.02;  // m
  std::vector<Thing> all = things(c);
  all.push_back({"the ship", solid_of(Solid::Kind::ship, c.layout.ship)});
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    double under = 0.0;
    for (const Thing& thing : all)
      if (covers(thing.solid, p.x, p.y) &&
          (thing.solid.kind == Solid::Kind::ship || thing.solid.top < p.z + 0.5 * container_height))
        under = std::max(under, thing.solid.top);
    if (!(std::fabs(p.z - under) <= play))
      throw std::invalid_argument(
          fmt::format("plant: container {} must stand on something: its underside is at {:.3f} m, but the object below "
                      "it ends at {:.3f} m",
                      i, p.z, under));
  }
  const Solid spreader = make_solid(Solid::Kind::fixed, -1, c.home.x, c.home.y, c.home.yaw, 0.5 * container_length,
                                    0.5 * container_width, c.home.z, c.home.z + spreader_height);
  refuse(c.home.z < 0.0, "the spreader's home must be above the ground", c.home.z);
  for (const Thing& thing : all)
    if (std::min(thing.solid.top, spreader.top) - std::max(thing.solid.bottom, spreader.bottom) > play &&
        overlaps(thing.solid, spreader, -play))
      throw std::invalid_argument(fmt::format("plant: the spreader's home at ({:.2f}, {:.2f}, {:.2f}) m is inside {}",
                                              c.home.x, c.home.y, c.home.z, thing.name));
}

void check_containers(const DockConfig& c) {
  for (std::size_t i = 0; i < c.layout.containers.size(); ++i) {
    const ContainerPlace& p = c.layout.containers[i];
    if (!std::isfinite(p.x + p.y + p.z + p.yaw))
      throw std::invalid_argument(fmt::format("plant: container {} needs a place of numbers", i));
    if (!(p.mass > 0.0))
      throw std::invalid_argument(fmt::format("plant: container {}'s mass must be positive (got {})", i, p.mass));
    if (const std::string why = cannot_hold(c.crane, p.mass); !why.empty())
      throw std::invalid_argument(fmt::format("plant: container {} is too heavy for the crane: {}", i, why));
    if (p.mass > c.crane.rated_load)
      throw std::invalid_argument(
          fmt::format("plant: container {} weighs {} kg, more than the crane's rated_load of {} kg (the hoist would "
                      "hold it with {:.0f} N m)",
                      i, p.mass, c.crane.rated_load, hoist_holding_torque(c.crane, p.mass)));
  }
}

}  // namespace

void check_scene(const DockConfig& c) {
  if (const std::string why = cannot_hold(c.crane, c.crane.rated_load); !why.empty())
    throw std::invalid_argument(fmt::format("plant: the crane cannot carry its rated_load: {}", why));
  check_containers(c);
  check_reach(c);
  check_apart(c);
  check_standing(c);
  check_lanes(c);
}

}  // namespace plant
