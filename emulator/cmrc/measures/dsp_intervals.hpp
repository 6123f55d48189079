#pragma once
// The time of each DSP, divided into intervals: off, asleep, in its executive, running a block; and the delays in each.
//
// A DSP runs a block from the instant at which its program issues the write of 0Fh to the write of FFh, as in the
// report (`dsps`, `tasks`): so the intervals of a DSP and a task kind add up to the report's values, to the picosecond.
// A DSP is asleep from the arrival of its idle bit to the interrupt that wakes it, and off from a failure or a reset to
// the first word of its program.
//
//     DspIntervals intervals(listener);  // a DspIntervalListener
//     simulation.watch(intervals);       // before the run, or after restore()
//     simulation.run();
//     intervals.finish(simulation.time());
//
// Memory does not grow with the run.
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "cmrc/measures/run_watcher.hpp"

namespace cmrc {

/// What delays a DSP: an access through window A or B; or the list's semaphore, which another master has: from the
/// first refusal to the answer that grants it, including the DSP's accesses in between.
enum class HeldUpBy : std::uint8_t { window_a, window_b, list };
inline constexpr std::size_t held_up_count = 3;

/// The state of a DSP from `from` to `to`.
struct DspInterval {
  unsigned slot = 0;
  SlotState doing = SlotState::off;  ///< awake: in its executive; busy: running a block
  Time from{}, to{};
  std::array<std::int64_t, held_up_count> held_up{};  ///< ps of the interval, by HeldUpBy; they do not overlap
  // If it ran a block:
  TakenBlock block{};
  report::Run::End end = report::Run::End::running;
  std::vector<std::int64_t> cycles{};  ///< by cause, from the ledger; empty: not known
};

class DspIntervalListener {
 public:
  virtual ~DspIntervalListener() = default;
  /// Intervals of each DSP follow each other without gaps; none is empty, except possibly that of a block.
  virtual void interval(const DspInterval& interval) = 0;
};

class DspIntervals final : public RunWatcher {
 public:
  explicit DspIntervals(DspIntervalListener& listener) : listener_(listener) {}

  void slot_is(unsigned slot, SlotState state, Time at) override;
  void booted(unsigned slot, Time at) override;
  void took(unsigned slot, const TakenBlock& block) override;
  void left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
            const std::vector<std::int64_t>& cycles) override;
  void held_up(unsigned slot, machine::Window window, Time from, Time to) override;
  void refused(unsigned slot, Time at) override;
  void list(unsigned owner, Time at) override;
  /// Ends the intervals under way here; a block's then ends as `running`.
  void finish(Time now);

 private:
  struct Wait {
    Time from{}, to{};
    HeldUpBy by{};
  };
  struct Lane {
    bool begun = false;
    DspInterval now{};           // as far as known: without its end
    std::optional<Time> failed;  // the DSP was given up while it ran a block; it may still finish the block
    std::deque<Wait> waits;      // of the present interval and the following ones, in order
    std::optional<Time> refused;
    Time lists{};  // until here the DSP waited for the list
  };

  Lane& lane(unsigned slot);
  void next(unsigned slot, SlotState doing, Time at);
  void close(Lane& lane, Time at);
  void lose_block(Lane& lane, report::Run::End end, Time at);
  void book_waits(Lane& lane, Time until);
  void wait(Lane& lane, const Wait& wait);
  void got_list(Lane& lane, Time at);

  DspIntervalListener& listener_;
  std::vector<Lane> lanes_;
};

}  // namespace cmrc
