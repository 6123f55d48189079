#pragma once
// Combines several watchers of a run into one. What only draws a run must not be able to end it: a watcher that throws
// is left out from then on.
#include <vector>

#include "cmrc/measures/run_watcher.hpp"

namespace cmrc {

class RunWatchers final : public RunWatcher {
 public:
  void add(RunWatcher& watcher) { all_.push_back(&watcher); }

  void slot_is(unsigned slot, SlotState state, Time at) override;
  void booted(unsigned slot, Time at) override;
  void took(unsigned slot, const TakenBlock& block) override;
  void left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
            const std::vector<std::int64_t>& cycles) override;
  void held_up(unsigned slot, machine::Window window, Time from, Time to) override;
  void refused(unsigned slot, Time at) override;
  void list(unsigned owner, Time at) override;
  void ended(const EndedJob& job) override;
  void missed(const MissedWaits& waits) override;
  void refreshed(const RefreshTimes& times, Time end, std::size_t blocks) override;
  void on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) override;
  void latched(const plant::Dock& dock, Time now) override;

 private:
  template <class Call>
  void each(const Call& call);

  std::vector<RunWatcher*> all_;
};

}  // namespace cmrc
