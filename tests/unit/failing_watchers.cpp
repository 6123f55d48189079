// What only draws a run does not end it: an error in it ends the drawing.
#include <doctest/doctest.h>

#include <ostream>
#include <stdexcept>
#include <streambuf>

#include "cmrc/configuration/config.hpp"
#include "cmrc/measures/run_watchers.hpp"
#include "cmrc/run/simulation.hpp"
#include "cmrc/timelines/perfetto_recorder.hpp"
#include "report/events/event_log.hpp"
#include "report/events/trace_text.hpp"

namespace {

using cmrc::Time;

/// Counts what it gets. The third call throws, if it is a bad one.
struct Watcher final : cmrc::RunWatcher, report::EventSink {
  explicit Watcher(bool is_bad) : bad(is_bad) {}
  void refused(unsigned, Time) override { count(); }
  void event(const report::Event&) override { count(); }
  void failed() override { ++failures; }
  void count() {
    if (++calls == 3 && bad) throw std::logic_error("out of order");
  }
  bool bad;
  int calls = 0, failures = 0;
};

/// Does not override failed().
struct Sink final : report::EventSink {
  void event(const report::Event&) override { throw std::logic_error("out of order"); }
};

/// Takes five thousand bytes.
struct FullDisk final : std::streambuf {
  std::streamsize xsputn(const char*, std::streamsize size) override {
    return (written += size) < 5'000 ? size : throw std::runtime_error("the disk is full");
  }
  std::streamsize written = 0;
};

void add_events(report::EventLog& log, int count) {
  for (int i = 0; i < count; ++i) log.add({Time{i}, report::host, report::EventKind::refresh, {}});
}

}  // namespace

TEST_CASE("a watcher that throws is left out from then on, and the others get everything") {
  Watcher first(false), bad(true), last(false);
  cmrc::RunWatchers all;
  for (Watcher* one : {&first, &bad, &last}) all.add(*one);
  for (int i = 0; i < 10; ++i) all.refused(0, Time{i});
  CHECK((first.calls == 10 && last.calls == 10));
  CHECK((bad.calls == 3 && bad.failures == 1));
}

TEST_CASE("so is a sink of events; unless it takes its errors itself, they are the run's") {
  Watcher first(false), bad(true), last(false);
  report::EventLog log;
  for (Watcher* one : {&first, &bad, &last}) log.listen(*one);
  add_events(log, 10);
  log.flush();
  CHECK((first.calls == 10 && last.calls == 10));
  CHECK((bad.calls == 3 && bad.failures == 1));

  Sink sink;
  report::EventLog other;
  other.listen(sink);
  add_events(other, 1);
  CHECK_THROWS_AS(other.flush(), std::logic_error);
}

TEST_CASE("a timeline that cannot be recorded is lost, and its run is the same") {
  cmrc::Config config;
  config.run.duration_s = 0.03;
  config.report.reference = cmrc::ReferenceKind::none;
  cmrc::Simulation plain(config), drawn(config);
  FullDisk disk;
  std::ostream out(&disk);
  out.exceptions(std::ostream::badbit);
  cmrc::PerfettoRecorder recorder(drawn, out, cmrc::PerfettoDetail::tasks, report::Window{});
  plain.run();
  drawn.run();
  CHECK(drawn.report_so_far().hash == plain.report_so_far().hash);
  CHECK_THROWS_WITH_AS(recorder.finish(), "the disk is full", std::runtime_error);
}
