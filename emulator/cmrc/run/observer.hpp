#pragma once
// Passes the events of a run from the machine and the dock to the event log, the ledger and the report's statistics.
#include <array>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "cmrc/host/host.hpp"
#include "cmrc/measures/instability.hpp"
#include "cmrc/measures/ledger.hpp"
#include "cmrc/measures/motion_watch.hpp"
#include "cmrc/measures/run_profile.hpp"
#include "cmrc/measures/square_sum.hpp"
#include "cmrc/measures/standstill.hpp"
#include "cmrc/measures/wind_watch.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/system/bus_topology.hpp"
#include "machine/system/observer.hpp"
#include "machine/system/scripted_events.hpp"
#include "plant/dock/dock.hpp"
#include "report/events/event_log.hpp"

namespace cmrc {

class RunObserver : public machine::Observer, public HostListener {
 public:
  /// \param samples_max up to this number of samples the percentiles of a summary are exact
  RunObserver(const Words& words, Ledger& ledger, report::EventLog& log, std::size_t samples_max);
  /// Reads PID's five errors from the crane's area while PID's stage is `servoing`; at other stages the words are not
  /// errors. `errors` and `stage` are offsets.
  void watch_errors(Word errors, Word stage, Word servoing) {
    errors_ = errors, stage_ = stage, servoing_stage_ = servoing;
  }
  /// Called when a slot issues a write: the slot's cycles by cause. Without it, jobs have no causes, and nobody asks
  /// what they waited for.
  void set_causes(std::function<CauseTimes(unsigned)> causes) { causes_ = std::move(causes); }
  /// Reads shared memory without time.
  void set_peek(std::function<machine::Word(machine::Offset)> peek) { peek_ = std::move(peek); }
  /// Whether the crane is servoed now. If not, drives stop because their work is finished.
  void set_servoing(std::function<bool()> servoing) { servoing_ = std::move(servoing); }
  /// Listens to the dock, and records it in `course` if this is given and wants rows. `wind_limit`: m/s, see wind().
  void attach(plant::Dock& dock, Course* course, double wind_limit);
  /// Notes in the profile when jobs begin and end; null: none.
  void set_profile(RunProfile* profile) { profile_ = profile; }
  /// At power-on there is a DSP in this slot.
  void plugged_from_power_on(unsigned slot) { standstill_.works(slot); }
  /// At power-on the slot's DSP has yet to be booted.
  void boots_from_power_on(unsigned slot) { boots_.at(slot).emplace_back(); }
  /// The watcher gets what the ledger gets, and the dock; null: none. Not part of the state.
  void watch(RunWatcher* watcher) { watcher_ = watcher, ledger_.watch(watcher); }

  // machine::Observer
  void dsp_issue(unsigned slot, machine::Window window, machine::Offset offset, machine::Word value,
                 Time issued) override;
  bool wants_issues_at(machine::Window window, machine::Offset offset) const override {
    const bool in_pool = offset - words_.block_pool < words_.block_count * words_.block_words;
    return in_pool && window == machine::Window::a && flag_of(offset).has_value() && causes_;
  }
  void dsp_write(unsigned slot, machine::Window window, machine::Offset offset, machine::Word value, Time issued,
                 Time now) override;
  void dsp_write_dropped(unsigned slot, machine::Window window, machine::Offset offset, machine::Word value,
                         Time issued, Time now) override;
  void dsp_waited(unsigned slot, machine::Window window, Time from, Time to) override {
    if (causes_) ledger_.timeline().window(slot, window, from, to);
  }
  void dsp_write_refused(unsigned slot, machine::Offset offset, machine::Word value, machine::Word kind,
                         Time now) override;
  void transaction(machine::BusId bus, const pci::Transaction& transaction, Time now) override;
  bool wants_transactions() const override { return !log_.discards(); }
  void interrupt(unsigned slot, int pin, Time now) override;
  void semaphore(unsigned number, machine::SemaphoreEvent event, unsigned owner, Time now) override;
  void fault(const machine::ChipFault& fault) override;
  void slot(unsigned slot, machine::SlotChange change, Time now) override;
  void link_lost(unsigned slot, bool to_dsp, machine::Word word, int bytes, Time now) override;
  void scripted(const machine::ScriptedEvent& event, Time now) override;

  // HostListener
  void event(const report::Event& event) override { log_.add(event); }
  void failure(const report::FailureReport& failure) override { failures_.push_back(failure); }
  void reset_by_watchdog(unsigned slot) override { ++resets_.at(slot); }
  void boot_given_up(unsigned slot, Time at) override { standstill_.stops(slot, at); }
  void refreshed(Time tick, std::size_t blocks, Time now) override;

  const std::vector<report::FailureReport>& failures() const { return failures_; }
  const report::Distribution& semaphore_hold() const { return hold_; }
  /// From the tick until the host is done and the list is released. \param under_way the tick of one that is not done
  report::Distribution refresh_duration(std::optional<Time> under_way, Time end) const;
  /// Reports the refreshes that refresh_duration() adds at the end. \param under_way whether one is not done
  void close_refreshes(bool under_way, Time end, RunWatcher& watcher) const;
  /// By joint: its errors, as PID computed them.
  const std::array<SquareSum, 5>& pid_error() const { return pid_error_; }
  /// The integral of the squared torque codes, s.
  double drive_effort() const { return effort_; }
  /// Since when DSPs and drives do nothing.
  const Standstill& standstill() const { return standstill_; }
  /// How long the wind has been above its limit.
  const WindWatch& wind() const { return wind_.value(); }
  /// Sway, and vehicles beside their lanes.
  const MotionWatch& motion() const { return motion_.value(); }
  /// Time at full torque by joint, in latches.
  const std::array<std::int64_t, plant::joint_count>& saturated_latches() const { return saturated_; }
  std::uint64_t faults(unsigned slot) const { return slot < faults_.size() ? faults_[slot] : 0; }
  /// By the watchdog.
  std::uint64_t resets(unsigned slot) const { return slot < resets_.size() ? resets_[slot] : 0; }
  const std::vector<report::BootReport>& boots(unsigned slot) const { return boots_.at(slot); }
  void list_state(state::Visitor& list);

 private:
  struct Refresh {
    Time tick{};
    RefreshTimes times;
    std::size_t blocks = 0;
  };
  struct Snapshot {
    Time issued;
    machine::Offset offset;
    CauseTimes causes;
  };

  void claim(unsigned slot, std::size_t block, Time issued, Time now);
  void finish(unsigned slot, std::size_t block, Time issued, Time now);
  void issued(unsigned slot, std::size_t block, Word flag, Time issued, Time now);
  void idle(unsigned slot, bool idle, Time now);
  void list_taken(unsigned owner, Time now);
  void refresh_ended(const Refresh& refresh, Time now);
  void pid_error(std::size_t joint, machine::Word value);
  std::optional<std::size_t> flag_of(machine::Offset offset) const;
  CauseTimes take_snapshot(unsigned slot, machine::Offset offset, Time issued);
  void dock_event(const plant::Event& event, plant::CraneKind crane);

  const Words words_;
  Ledger& ledger_;
  report::EventLog& log_;
  std::function<CauseTimes(unsigned)> causes_;
  std::function<machine::Word(machine::Offset)> peek_;
  std::function<bool()> servoing_;
  std::vector<std::deque<Snapshot>> snapshots_;  // by slot: writes of flags under way
  std::vector<std::array<Word, 16>> blocks_;     // what DSPs wrote into each block: result and notify
  struct Refused {
    std::size_t failure;  // index among the failures, for the first one reported
    std::uint64_t count;
    std::string first;
  };
  std::vector<report::FailureReport> failures_;
  std::map<std::pair<unsigned, machine::Word>, Refused> refused_;  // by slot and kind
  std::vector<std::uint64_t> faults_, resets_;
  std::vector<std::vector<report::BootReport>> boots_;  // by slot
  report::Distribution hold_;
  Time held_since_{};
  bool host_has_list_ = false;
  report::Distribution refresh_duration_;
  std::optional<Refresh> posted_;  // a refresh whose last writes are on their way
  std::array<SquareSum, 5> pid_error_;
  std::array<std::int64_t, plant::joint_count> saturated_{};
  Word errors_ = 0, stage_ = 0, servoing_stage_ = 0;
  bool errors_hold_ = false;  // the errors belong to the run of PID whose words are being written
  Instability instability_;
  Standstill standstill_;
  double effort_ = 0;
  Time effort_until_{};
  std::optional<WindWatch> wind_;
  std::optional<MotionWatch> motion_;
  RunProfile* profile_ = nullptr;
  RunWatcher* watcher_ = nullptr;
};

}  // namespace cmrc
