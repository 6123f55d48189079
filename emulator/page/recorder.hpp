#pragma once
// Records during a run what its page shows (docs/page.md, The recording). Listens only, and changes nothing.
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/measures/dsp_intervals.hpp"
#include "cmrc/measures/run_watcher.hpp"
#include "cmrc/run/simulation.hpp"
#include "page/plant_samples.hpp"
#include "report/events/event_log.hpp"

namespace page {

class Columns;
using report::Time;

/// The unit of times in lanes.
inline constexpr Time lane_tick = std::chrono::nanoseconds{1};
/// The limit of DSP intervals, and twice the limit of jobs. For the time after the limit, the page says that it has no
/// lanes.
inline constexpr std::size_t stretches_max = 6'000'000;
/// The limit of dock events.
inline constexpr std::size_t dock_events_max = 50'000;

class Recorder : public cmrc::RunWatcher, public cmrc::DspIntervalListener, public report::EventSink {
 public:
  /// Records `simulation` from now on: before its run, or after restore(). The recorder must live as long as the run.
  explicit Recorder(cmrc::Simulation& simulation, std::size_t stretches = stretches_max);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The recording of what has run, for a run that has ended. \param report of that run \throws std::runtime_error if
  /// an error has ended the recording before
  std::string recording(const report::RunReport& report, const std::string& title);

  // cmrc::RunWatcher, DspIntervalListener
  void slot_is(unsigned slot, cmrc::SlotState state, Time at) override { intervals_.slot_is(slot, state, at); }
  void booted(unsigned slot, Time at) override { intervals_.booted(slot, at); }
  void took(unsigned slot, const cmrc::TakenBlock& block) override { intervals_.took(slot, block); }
  void left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
            const std::vector<std::int64_t>& cycles) override {
    intervals_.left(slot, job, end, at, cycles);
  }
  void held_up(unsigned slot, machine::Window window, Time from, Time to) override {
    intervals_.held_up(slot, window, from, to);
  }
  void refused(unsigned slot, Time at) override { intervals_.refused(slot, at); }
  void list(unsigned owner, Time at) override { intervals_.list(owner, at); }
  void interval(const cmrc::DspInterval& interval) override;
  void ended(const cmrc::EndedJob& job) override;
  void on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) override;
  void latched(const plant::Dock& dock, Time now) override;

  // report::EventSink: failures and resets only
  void event(const report::Event& event) override;
  // Of both.
  void failed() override;

 private:
  using JobKey = std::uint64_t;
  static JobKey key(const report::JobName& job);
  struct Job {
    JobKey key = 0;
    Time released{}, end{};
    std::int64_t allowed = 0;  // ticks from release to deadline + 1; 0: no deadline
    std::uint8_t outcome = 0;
    bool missed = false;
    bool has_run = false;
  };
  struct Lane {
    Time from{}, to{};
    JobKey job = 0;                                           // of a busy interval
    std::array<std::int64_t, cmrc::held_up_count> held_up{};  // ps
    std::uint8_t slot = 0, what = 0, end = 0;
  };
  struct Bus {
    std::map<std::uint32_t, std::vector<std::int64_t>> held;  // ps per time slice, by master
    std::vector<std::int64_t> refused;                        // attempts that ended without data
  };

  std::vector<Lane> lanes_in_order();
  void put_lanes(Columns& columns);
  void put_buses(Columns& columns, const report::RunReport& report) const;

  cmrc::Simulation& simulation_;
  std::size_t most_;
  Time from_, bus_slice_;
  PlantSamples samples_;
  cmrc::DspIntervals intervals_{*this};
  std::vector<Lane> stretches_;
  std::vector<Job> jobs_;
  std::vector<Bus> buses_;
  std::map<unsigned, std::vector<std::pair<Time, bool>>> failures_;  // by slot: a failure (true) or a reset (false)
  Time lanes_until_ = Time::max();
  std::size_t left_out_ = 0;
  std::optional<std::string> problem_;
};

}  // namespace page
