#include "cmrc/measures/run_watchers.hpp"

#include <cstddef>
#include <exception>

namespace cmrc {

template <class Call>
void RunWatchers::each(const Call& call) {
  for (std::size_t i = 0; i < all_.size();) {
    RunWatcher& one = *all_[i];
    try {
      call(one);
      ++i;
    } catch (const std::exception&) {
      all_.erase(all_.begin() + static_cast<std::ptrdiff_t>(i));
      one.failed();
    }
  }
}

void RunWatchers::slot_is(unsigned slot, SlotState state, Time at) {
  each([&](RunWatcher& one) { one.slot_is(slot, state, at); });
}
void RunWatchers::booted(unsigned slot, Time at) {
  each([&](RunWatcher& one) { one.booted(slot, at); });
}
void RunWatchers::took(unsigned slot, const TakenBlock& block) {
  each([&](RunWatcher& one) { one.took(slot, block); });
}
void RunWatchers::left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
                       const std::vector<std::int64_t>& cycles) {
  each([&](RunWatcher& one) { one.left(slot, job, end, at, cycles); });
}
void RunWatchers::held_up(unsigned slot, machine::Window window, Time from, Time to) {
  each([&](RunWatcher& one) { one.held_up(slot, window, from, to); });
}
void RunWatchers::refused(unsigned slot, Time at) {
  each([&](RunWatcher& one) { one.refused(slot, at); });
}
void RunWatchers::list(unsigned owner, Time at) {
  each([&](RunWatcher& one) { one.list(owner, at); });
}
void RunWatchers::ended(const EndedJob& job) {
  each([&](RunWatcher& one) { one.ended(job); });
}
void RunWatchers::missed(const MissedWaits& waits) {
  each([&](RunWatcher& one) { one.missed(waits); });
}
void RunWatchers::refreshed(const RefreshTimes& times, Time end, std::size_t blocks) {
  each([&](RunWatcher& one) { one.refreshed(times, end, blocks); });
}
void RunWatchers::on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) {
  each([&](RunWatcher& one) { one.on_bus(bus, attempt, clock); });
}
void RunWatchers::latched(const plant::Dock& dock, Time now) {
  each([&](RunWatcher& one) { one.latched(dock, now); });
}

}  // namespace cmrc
