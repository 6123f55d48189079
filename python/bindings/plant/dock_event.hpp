#pragma once
// An event of the dock in Python.
#include <vector>

#include "plant/dock/dock.hpp"

/// An event, and the crane whose joints its index counts.
struct DockEvent {
  plant::Event event;
  plant::CraneKind crane;
};

inline std::vector<DockEvent> events_of(const plant::Dock& dock) {
  std::vector<DockEvent> all;
  for (const plant::Event& event : dock.events()) all.push_back({event, dock.config().crane.machine});
  return all;
}
