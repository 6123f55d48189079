#include "cmrc/run/reference_run.hpp"

#include <fmt/format.h>
#include <sys/mman.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <utility>

#include "c40/chip/chip.hpp"
#include "cmrc/configuration/machine/nominal_machine.hpp"
#include "cmrc/run/ideal_run.hpp"
#include "cmrc/run/simulation.hpp"
#include "io/child_process.hpp"
#include "io/stop.hpp"
#include "machine/system/machine.hpp"
#include "report/values/comparison.hpp"
#include "state/archive.hpp"

namespace cmrc {

namespace {

// A DSP of an ideal run is nearly always idle. One that runs for a tenth of a slice has a task that does not end, and
// would cost a thousand times as much as in a real run.
constexpr Time slice = std::chrono::milliseconds{5};
constexpr std::uint64_t most_instructions = 5'000'000;
// A stopped run lets the ideal run come as far within this time, and then stop within the next.
constexpr int moment_ms = 300, patience_ms = 600;

/// The child's answer, besides the rows.
struct Answer {
  Course& course;
  JobsByRobot jobs;
  std::vector<std::optional<double>> metrics;
  double elapsed_s = 0;

  void list_state(state::Visitor& list) {
    course.list_all_but_rows(list);
    list("jobs", jobs);
    list("metrics", metrics);
    list("elapsed_s", elapsed_s);
  }
};

}  // namespace

Config reference_of(Config config) {
  config = as_run(ideal(std::move(config)));
  config.run.turn_order = 0;
  config.run.strict = false;
  config.report.misses_max = 0;
  config.report.signal_decimation = 80000;
  return config;
}

std::string reference_key(const Config& config) { return to_toml(reference_of(config)); }

/// What parent and child share besides the rows.
struct ReferenceRun::Shared {
  Shared() {
    void* memory =
        ::mmap(nullptr, sizeof(std::atomic<std::int64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to be shared with a child process");
    stop_ps = new (memory) std::atomic<std::int64_t>(INT64_MAX);
  }
  ~Shared() { ::munmap(stop_ps, sizeof *stop_ps); }
  std::atomic<std::int64_t>* stop_ps;
};

ReferenceRun::ReferenceRun(const Config& config)
    : reference_(std::make_shared<Reference>(rows_of(config), static_cast<int>(config.dock.agvs))),
      shared_(std::make_unique<Shared>()) {
  const Config made = reference_of(config);
  reference_->key = to_toml(made);
  child_ = std::make_unique<io::ChildProcess>([&] {
    Simulation simulation(made, std::shared_ptr<Course>(reference_, &reference_->course));
    std::uint64_t before = 0;
    const auto go_on = [&](const Progress& progress) {
      const std::uint64_t instructions = simulation.machine().chip(0).instructions();
      if (instructions - std::exchange(before, instructions) > most_instructions) {
        throw std::runtime_error(fmt::format("a task does not end at {} times the speed either, near {:.3f} s",
                                             ideal_speed, report::seconds(progress.simulated)));
      }
      return progress.simulated.count() < shared_->stop_ps->load(std::memory_order_relaxed);
    };
    simulation.run(go_on, slice);
    const report::RunReport report = simulation.report();
    Answer answer{reference_->course, simulation.jobs(), {}, report.elapsed_s};
    for (const report::Metric& metric : report::metrics(report)) answer.metrics.push_back(metric.value);
    return state::save(answer);
  });
}

ReferenceRun::~ReferenceRun() = default;

std::shared_ptr<const Reference> ReferenceRun::cut_short(Time time) {
  shared_->stop_ps->store(time.count(), std::memory_order_relaxed);
  if (child_ && !child_->speaks(moment_ms)) {
    shared_->stop_ps->store(0, std::memory_order_relaxed);
    if (!child_->speaks(patience_ms)) {
      child_.reset();
      throw std::runtime_error(fmt::format("it did not stop within {} ms", moment_ms + patience_ms));
    }
  }
  const io::StopAsker nobody([] { return false; });
  return wait();
}

std::shared_ptr<const Reference> ReferenceRun::wait() {
  if (!child_) return reference_;
  const std::string result = child_->wait();
  child_.reset();
  Answer answer{reference_->course, {}, {}, 0};
  state::load(answer, result);
  reference_->jobs = std::move(answer.jobs);
  reference_->metrics = std::move(answer.metrics);
  reference_->elapsed_s = answer.elapsed_s;
  return reference_;
}

}  // namespace cmrc
