#pragma once
// A run as a Perfetto trace, written during the run (docs/timelines.md) from what its watchers get.
#include <cstdint>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cmrc/measures/dsp_intervals.hpp"
#include "cmrc/measures/run_watcher.hpp"
#include "cmrc/timelines/perfetto_buses.hpp"
#include "cmrc/timelines/perfetto_lanes.hpp"
#include "cmrc/timelines/perfetto_plant.hpp"
#include "report/events/event_log.hpp"
#include "report/events/perfetto_trace.hpp"
#include "report/events/trace_text.hpp"

namespace cmrc {

class Simulation;

/// The detail of the trace; each level includes the one before.
enum class PerfettoDetail : std::uint8_t {
  tasks,  ///< blocks, jobs, refreshes, misses, buses by the millisecond, the plant
  bus,    ///< also every attempt of a master on a bus
  all,    ///< also every wait of a DSP, the owner of the list, and the cycles of each block by cause
};

class PerfettoRecorder final : public report::EventSink, private RunWatcher, private DspIntervalListener {
 public:
  /// To be constructed before the run, or after restore(). `simulation` and `out` must outlive this object. Draws only
  /// what lies in the window or extends into it.
  PerfettoRecorder(Simulation& simulation, std::ostream& out, PerfettoDetail detail, report::Window window);
  /// Ends everything that is open. To be called once, after Simulation::report_so_far(). \throws std::runtime_error if
  /// an error has ended the recording before
  void finish();

 private:
  using Trace = report::PerfettoTrace;
  struct UnderWay {
    Time since{};
    bool earlier = false;  // it had begun before `since`, the snapshot
  };
  struct Dsp {
    Trace::Track track;
    std::optional<Trace::Track> waits{};
    std::optional<Time> awake{};                        // since when; none: it is not
    std::array<std::int64_t, held_up_count> held_up{};  // of its executive, since it woke up
  };

  // RunWatcher
  void slot_is(unsigned slot, SlotState state, Time at) override { intervals_.slot_is(slot, state, at); }
  void booted(unsigned slot, Time at) override { intervals_.booted(slot, at); }
  void took(unsigned slot, const TakenBlock& block) override { intervals_.took(slot, block); }
  void left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
            const std::vector<std::int64_t>& cycles) override {
    intervals_.left(slot, job, end, at, cycles);
  }
  void held_up(unsigned slot, machine::Window window, Time from, Time to) override;
  void refused(unsigned slot, Time at) override { intervals_.refused(slot, at); }
  void list(unsigned owner, Time at) override;
  void ended(const EndedJob& job) override;
  void missed(const MissedWaits& waits) override;
  void process_runs(unsigned number, unsigned agv) override;
  void refreshed(const RefreshTimes& times, Time end, std::size_t blocks) override;
  void refreshing(const RefreshTimes& times, Time now) override;
  void on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) override {
    buses_.on_bus(bus, attempt, clock, true);
  }
  void still_on_bus(machine::BusId bus, const pci::Attempt& attempt, const machine::Clock& clock) override {
    buses_.on_bus(bus, attempt, clock, false);
  }
  void latched(const plant::Dock& dock, Time now) override { plant_.latched(dock, now); }

  void interval(const DspInterval& interval) override;
  // The ordered events: processes, and rare events.
  void event(const report::Event& event) override;
  // Of both.
  void failed() override;

  PerfettoBuses add_tracks();
  void block(Dsp& dsp, const DspInterval& interval);
  void sleep(Dsp& dsp, Time at);
  void process(const report::Event& event);
  PerfettoLanes& processes_of(const std::string& robot);
  PerfettoLanes& jobs_of(const report::JobName& job);
  std::string robot(const report::JobName& job) const;
  bool within(Time from, Time to) const { return from < window_.to && (to > window_.from || window_.contains(from)); }

  Simulation& simulation_;
  const PerfettoDetail detail_;
  const report::Window window_;
  std::vector<std::string> kinds_, causes_;
  Trace trace_;
  DspIntervals intervals_{*this};
  std::vector<Dsp> dsps_;
  Trace::Track jobs_group_ = 0, misses_ = 0;
  std::map<std::pair<std::size_t, std::uint32_t>, PerfettoLanes> jobs_;
  std::optional<PerfettoLanes> refreshes_;
  Trace::Track list_length_ = 0;
  std::optional<Trace::Track> list_owner_;
  std::optional<std::pair<unsigned, Time>> owns_list_;
  std::optional<std::size_t> length_reported_;
  PerfettoBuses buses_;
  Trace::Track processes_group_;
  std::map<std::string, PerfettoLanes> processes_;                         // by the robot's name
  std::map<std::pair<std::uint32_t, std::uint32_t>, UnderWay> under_way_;  // by process and robot
  Trace::Track events_;
  PerfettoPlant plant_;
  Trace::Flow last_flow_ = 0;
  std::optional<std::string> problem_;
};

}  // namespace cmrc
