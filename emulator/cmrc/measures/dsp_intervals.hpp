#pragma once
// The time of each DSP cut into stretches: off, asleep, in its executive, running a block; and what held it up in them.
//
// A DSP runs a block from the instant at which its program issues the write of 0Fh to that of FFh, as in the report
// (`dsps`, `tasks`): so the stretches of a DSP and a task kind sum to what the report says, to the picosecond. The
// other instants: it is asleep from the arrival of its idle bit to the interrupt that wakes it, off from a failure or a
// reset to the first word of its program.
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

/// What holds a DSP up: an access through window A or B; the list's semaphore, which somebody else has: from the first
/// refusal to the answer that gives it, its accesses in between included.
enum class HeldUpBy : std::uint8_t { window_a, window_b, list };
inline constexpr std::size_t held_up_count = 3;

/// What a DSP did from `from` to `to`.
struct DspInterval {
  unsigned slot = 0;
  SlotState doing = SlotState::off;  ///< awake: in its executive; busy: it ran a block
  Time from{}, to{};
  std::array<std::int64_t, held_up_count> held_up{};  ///< ps of it, by HeldUpBy; they do not overlap
  // Where it ran a block:
  TakenBlock block{};
  report::Run::End end = report::Run::End::running;
  std::vector<std::int64_t> cycles{};  ///< by cause, the ledger's; empty: not known
};

class DspIntervalListener {
 public:
  virtual ~DspIntervalListener() = default;
  /// Of each DSP one after the other, each beginning where the one before ended: none is left out, none is empty but
  /// perhaps a block's.
  virtual void interval(const DspInterval& interval) = 0;
};

class DspIntervals final : public RunWatcher {
 public:
  explicit DspIntervals(DspIntervalListener& listener) : listener_(listener) {}

  void slot_is(unsigned slot, SlotState state, Time at) override;
  void booted(unsigned slot, Time at) override;
  void took(unsigned slot, const TakenBlock& block) override;
  void left(unsigned slot, report::Run::End end, Time at, const std::vector<std::int64_t>& cycles) override;
  void held_up(unsigned slot, machine::Window window, Time from, Time to) override;
  void refused(unsigned slot, Time at) override;
  void list(unsigned owner, Time at) override;
  /// The stretches that go on are cut here; a block then ends as `running`.
  void finish(Time now);

 private:
  struct Wait {
    Time from{}, to{};
    HeldUpBy by{};
  };
  struct Lane {
    bool begun = false;
    DspInterval now{};           // as far as it is known: without its end
    std::optional<Time> failed;  // the DSP was given up while it ran a block; it may come back with that
    std::deque<Wait> waits;      // of the present stretch and of what follows, in order
    std::optional<Time> refused;
    Time lists{};  // until here the list was waited for
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
