#pragma once
// What every DSP and the list's semaphore were doing, as far back as an open job was released; and from it, what a
// block waited for that could have been claimed.
//
// At any instant a block that may be claimed waits for one thing (docs/report.md, Why late): for a DSP that is free to
// wake up, for a free DSP to go through its claim, or for the blocks that every living DSP runs.
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "cmrc/measures/run_watcher.hpp"
#include "machine/machine.hpp"
#include "report/why_late.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// Waiting, split without a remainder.
struct Waiting {
  report::WaitTimes times{};
  std::vector<report::BlockingJob>
      behind;  ///< blocks that kept all DSPs busy that may claim it; shares sum to blocked + behind_list
};

class Timeline {
 public:
  static constexpr unsigned nobody = 0;

  /// A DSP's state from `at` on. Calls for one slot come in the order of time; one that comes late counts from the
  /// last.
  void slot(unsigned slot, SlotState state, Time at);
  /// It runs this job from `at` on.
  void took(unsigned slot, const report::JobName& job, Time at);
  /// It is done with it, or the job was taken from it; no change where it runs none.
  void left(unsigned slot, Time at);
  /// The list's semaphore belongs to `owner` (DSP slot + 1, machine::host_owner) from `at` on, or to nobody.
  void list(unsigned owner, Time at);
  /// A DSP waited for an access through a window; asked of those without a block.
  void window(unsigned slot, machine::Window window, Time from, Time to);
  /// Tells it whatever it is told itself; null: nobody.
  void watch(RunWatcher* watcher) { watcher_ = watcher; }
  /// What the DSPs that run no block are now.
  void introduce(RunWatcher& watcher) const;
  /// Nothing before this will be asked for again.
  void forget(Time before);

  /// What a block waited for that could be claimed from `from` on and that slot `claimer` claimed at `to` (32: nobody
  /// did).
  /// \param only the slot whose DSP alone may claim it: nobody else counts
  Waiting explain(Time from, Time to, unsigned claimer, std::optional<unsigned> only = {}) const;
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
  };
  struct Span;

  void change(unsigned slot, State state);
  void wait_for_free(Time from, Time to, unsigned slot, report::WaitTimes& times) const;

  std::vector<Slot> slots_;
  std::deque<Holder> holders_;
  RunWatcher* watcher_ = nullptr;
};

}  // namespace cmrc
