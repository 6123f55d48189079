#pragma once
// The states of every DSP and of the list's semaphore, as far back as an open job was released; and from these, what a
// claimable block waited for.
//
// At any instant a block that may be claimed waits for one thing (docs/report.md, Why late): for a free DSP to wake up,
// for a free DSP to do its claim, or for the blocks that all working DSPs run.
#include <deque>
#include <optional>
#include <vector>

#include "cmrc/measures/run_watcher.hpp"
#include "machine/system/bus_topology.hpp"
#include "report/values/why_late.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// A wait, split without a remainder.
struct Waiting {
  report::WaitTimes times{};
  std::vector<report::BlockingJob>
      behind;  ///< blocks that kept all DSPs busy that may claim it; shares add up to blocked + behind_list
};

class Timeline {
 public:
  static constexpr unsigned nobody = 0;

  /// A DSP's state from `at` on. Calls for one slot come in the order of time; a late call counts from the time of the
  /// last one.
  void slot(unsigned slot, SlotState state, Time at);
  /// The DSP has said that it is idle or busy, or its doorbell was rung. A DSP that has failed stays off: a write that
  /// was on its way, and the host's doorbell, do not bring it back.
  void doorbell(unsigned slot, SlotState state, Time at);
  /// The DSP runs this job from `at` on.
  void took(unsigned slot, const report::JobName& job, Time at);
  /// The DSP has finished this job, or lost it; no change if it does not run this job.
  void left(unsigned slot, const report::JobName& job, Time at);
  /// The list's semaphore belongs to `owner` (DSP slot + 1, machine::host_owner) from `at` on, or is free.
  void list(unsigned owner, Time at);
  /// A DSP waited for an access through a window; called for DSPs without a block.
  void window(unsigned slot, machine::Window window, Time from, Time to) {
    if (watcher_ != nullptr) watcher_->held_up(slot, window, from, to);
    if (from < to && slot < slots_.size() && slots_[slot].free()) slots_[slot].waited({from, to, window});
  }
  /// Passes all calls on to `watcher`; null: none.
  void watch(RunWatcher* watcher) { watcher_ = watcher; }
  /// Reports the present states of the DSPs that run no block.
  void introduce(RunWatcher& watcher) const;
  /// No query will need anything before this time.
  void forget(Time before);

  /// The wait of a block that could be claimed from `from` on and that slot `claimer` claimed at `to` (32: no DSP did).
  /// \param only the slot whose DSP alone may claim it: no other DSP counts
  Waiting explain(Time from, Time to, std::optional<unsigned> claimer, std::optional<unsigned> only = {}) const;
  void list_state(state::Visitor& list);

 private:
  struct State {
    Time from{};
    SlotState state = SlotState::off;
    report::JobName job;
  };
  struct Holder {
    Time from{};
    unsigned owner = nobody;
  };
  struct BusWait {
    Time from{}, to{};
    machine::Window window{};
  };
  struct Slot {
    std::deque<State> states;
    std::deque<BusWait> waits;
    // While the DSP runs a job, the chip counts its waits for the job.
    bool free() const { return !states.empty() && states.back().state != SlotState::busy; }
    void waited(const BusWait& wait);
  };

  void change(unsigned slot, State state);
  void wait_for_free(Time from, Time to, unsigned slot, report::WaitTimes& times) const;

  std::vector<Slot> slots_;
  std::deque<Holder> holders_;
  RunWatcher* watcher_ = nullptr;
};

}  // namespace cmrc
