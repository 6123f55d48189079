#pragma once
// When and why a run ends. The account of jobs may end before the run: then the plant continues, braked, without the
// machine.
#include <chrono>
#include <optional>

#include "machine/time/time.hpp"
#include "report/values/run_report.hpp"

namespace machine {
class Machine;
}
namespace plant {
class Dock;
}
namespace state {
class Visitor;
}

namespace cmrc {

struct Config;
class Host;
class Standstill;

class RunEnd {
 public:
  /// Whether the job is finished or the plant has faulted is checked at whole multiples of this, however the caller
  /// divides the run.
  static constexpr machine::Time look_period = std::chrono::milliseconds{10};

  RunEnd(const Config& config, const machine::Machine& machine, plant::Dock& dock, const Host& host,
         const Standstill& standstill);

  /// Checks whether the job is finished, no DSP or no drive works any more, or the plant has faulted.
  void look();
  /// The instant at which the account ends because DSPs or drives have not worked for too long, if none works until
  /// then; never while they work. The machine must not run beyond it.
  machine::Time limit() const;
  /// A run that was stopped from outside.
  void interrupt() { stop_ = report::StopReason::interrupted; }
  /// An interrupted run continues. \returns whether it was interrupted
  bool resume();

  machine::Time now() const;
  bool over() const { return now() >= end_ || (account_end_ && now() >= after_end_); }
  bool interrupted() const { return stop_ == report::StopReason::interrupted; }
  /// Nothing: the run is under way, or completed.
  std::optional<report::StopReason> stop() const { return stop_; }
  /// The configured end.
  machine::Time end() const { return end_; }
  /// From this time on the plant continues without the machine, until after_end().
  std::optional<machine::Time> account_end() const { return account_end_; }
  machine::Time after_end() const { return after_end_; }

  void list_state(state::Visitor& list);

 private:
  machine::Time dsps_limit() const;
  machine::Time drives_limit() const;
  machine::Time after_stop() const;
  void stop_account(report::StopReason reason, machine::Time after);

  const Config& config_;
  const machine::Machine& machine_;
  plant::Dock& dock_;
  const Host& host_;
  const Standstill& standstill_;
  machine::Time end_;
  std::optional<machine::Time> account_end_;
  machine::Time after_end_{};
  std::optional<report::StopReason> stop_;
  std::optional<report::StopReason> stopped_by_;  // the end of the account; an interruption is not kept here
};

}  // namespace cmrc
