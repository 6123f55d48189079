#include "cmrc/measures/run_watchers.hpp"

namespace cmrc {

void RunWatchers::slot_is(unsigned slot, SlotState state, Time at) {
  for (RunWatcher* one : all_) one->slot_is(slot, state, at);
}
void RunWatchers::booted(unsigned slot, Time at) {
  for (RunWatcher* one : all_) one->booted(slot, at);
}
void RunWatchers::took(unsigned slot, const TakenBlock& block) {
  for (RunWatcher* one : all_) one->took(slot, block);
}
void RunWatchers::left(unsigned slot, report::Run::End end, Time at, const std::vector<std::int64_t>& cycles) {
  for (RunWatcher* one : all_) one->left(slot, end, at, cycles);
}
void RunWatchers::held_up(unsigned slot, machine::Window window, Time from, Time to) {
  for (RunWatcher* one : all_) one->held_up(slot, window, from, to);
}
void RunWatchers::refused(unsigned slot, Time at) {
  for (RunWatcher* one : all_) one->refused(slot, at);
}
void RunWatchers::list(unsigned owner, Time at) {
  for (RunWatcher* one : all_) one->list(owner, at);
}
void RunWatchers::ended(const EndedJob& job) {
  for (RunWatcher* one : all_) one->ended(job);
}
void RunWatchers::missed(const MissedWaits& waits) {
  for (RunWatcher* one : all_) one->missed(waits);
}
void RunWatchers::refreshed(const RefreshTimes& times, Time end, std::size_t blocks) {
  for (RunWatcher* one : all_) one->refreshed(times, end, blocks);
}
void RunWatchers::on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) {
  for (RunWatcher* one : all_) one->on_bus(bus, attempt, clock);
}
void RunWatchers::latched(const plant::Dock& dock, Time now) {
  for (RunWatcher* one : all_) one->latched(dock, now);
}

}  // namespace cmrc
