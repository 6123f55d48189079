// The report for a terminal: each number of a report made by hand stands at its own place. Short scenes have no links,
// no wind and no long chain, and a number that is shown at its neighbour's place looks like any other.
#include <doctest/doctest.h>

#include <chrono>
#include <sstream>
#include <string>
#include <vector>

#include "report/values/comparison.hpp"
#include "report/values/run_report.hpp"

namespace {

using report::Time;
using namespace std::chrono_literals;

constexpr std::int64_t us = 1'000'000;  // ps

/// The words of the line that begins with these words; empty: there is none.
std::vector<std::string> line_of(const std::string& text, const std::string& beginning) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(' ');
    if (first == std::string::npos || !line.substr(first).starts_with(beginning)) continue;
    std::istringstream rest(line.substr(first + beginning.size()));
    std::vector<std::string> words;
    for (std::string word; rest >> word;) words.push_back(word);
    return words;
  }
  return {};
}

bool has(const std::string& text, const std::string& part) {
  CAPTURE(text);
  CAPTURE(part);
  return text.find(part) != std::string::npos;
}

using Words = std::vector<std::string>;

}  // namespace

TEST_CASE("each direction of a link has its own row, and each count its own column") {
  report::RunReport run;
  run.links.push_back({.directions = {{{"0.1", "1.4", 21, 13, 5, 3}, {"1.4", "0.1", 34, 33, 0, 1}}}, .joined = 2});
  run.links.push_back({.directions = {{{"2.0", "3.3", 8, 8, 0, 0}, {"3.3", "2.0", 0, 0, 0, 0}}}, .is_cut = true});
  const std::string text = to_text(run);
  CHECK(line_of(text, "0.1 to 1.4") == Words{"21", "13", "5", "3", "2", "joined"});
  CHECK(line_of(text, "1.4 to 0.1") == Words{"34", "33", "-", "1", "2", "joined"});
  CHECK(line_of(text, "2.0 to 3.3") == Words{"8", "8", "-", "-", "-", "cut"});
  CHECK(line_of(text, "3.3 to 2.0") == Words{"-", "-", "-", "-", "-", "cut"});
}

TEST_CASE("the share of the time with too much wind is that of the watched part of the run") {
  report::RunReport run;
  run.simulated = 40s;
  run.wind = {.limit_m_s = 20, .watched = 8s, .above = 2s, .waited = 3s, .waits = 1};
  CHECK(has(to_text(run), "Wind above 20 m/s for 2.0 s, 25.0 % of the time"));
  CHECK(has(to_text(run), "lifts waited for less wind: 3.0 s, 1 time\n"));
  run.wind.waits = 2;
  CHECK(has(to_text(run), "3.0 s, 2 times\n"));
  run.wind.above = {};
  CHECK(!has(to_text(run), "Wind above"));
}

TEST_CASE("the host's list and its refresh each have their own mean and worst time") {
  report::RunReport run;
  run.host.refreshes = 7;
  run.host.semaphore_hold.mean = 3 * us, run.host.semaphore_hold.worst = 5 * us;
  run.host.refresh_duration.mean = 11 * us, run.host.refresh_duration.worst = 17 * us;
  run.host.list_length.mean = 2.5, run.host.list_length.worst = 9;
  const std::string text = to_text(run);
  CHECK(has(text, "list held for 3.000 us on average, 5.000 us at worst"));
  CHECK(has(text, "refresh takes 11.00 us on average, 17.00 us at worst"));
  CHECK(has(text, "blocks in the list: 2.5 on average, 9 at most"));
}

TEST_CASE("a chain shows its largest parts until they make up nine tenths, and the rest in one line") {
  report::RunReport run;
  report::TaskReport task;
  task.kind = "pid", task.released = 4, task.misses = 2, task.late = 2, task.longest_miss_streak = 2;
  task.why_late.chains = 2;
  task.why_late.parts = {{"claim", 10 * us},
                         {"blocked", 120 * us},
                         {"doorbell", 80 * us},
                         {"execution.execute", -6 * us},
                         {"slack", -40 * us}};
  run.tasks = {task};
  const std::string text = to_text(run);
  // Per job: 60 and 40 us are 100 of 105; 5 us are left.
  CHECK(has(text, "60.00 us  every DSP ran a block claimed earlier\n      40.00 us  waking up a DSP\n"));
  CHECK(has(text, " 5.000 us  all else\n"));
  CHECK(!has(text, "claiming: instructions"));
  CHECK(has(text, "-   3.000 us  ran shorter, or not to the end\n"));
  CHECK(has(text, "-   20.00 us  slack\n"));
  run.tasks[0].why_late.parts = {{"blocked", 120 * us}};
  CHECK(!has(to_text(run), "all else"));
  // Less time than a usual run takes is told once, whatever else there was.
  run.tasks[0].why_late.parts = {{"blocked", 120 * us}, {"claim", 4 * us}, {"slack", 60 * us}};
  CHECK(has(to_text(run),
            "60.00 us  every DSP ran a block claimed earlier\n      2.000 us  all else\n      30.00 us  too little "
            "time from the start\n"));
  CHECK(!has(to_text(run), "  slack\n"));
}

TEST_CASE("programs that booted at power-on are told from the first to the last; a later boot by itself") {
  report::RunReport run;
  run.boot_words = 500;
  report::DspReport dsp;
  dsp.causes = {{"execute", 1}}, dsp.cycles = 1, dsp.state = "running";
  for (const auto& [slot, booted] : {std::pair{0U, 3ms}, std::pair{1U, 2ms}, std::pair{2U, 5ms}}) {
    dsp.slot = slot, dsp.boots = {{Time{}, booted}};
    run.dsps.push_back(dsp);
  }
  run.dsps[1].boots.push_back({20ms, 24ms});
  run.dsps[2].boots.push_back({30ms, {}});
  const std::string text = to_text(run);
  CHECK(has(text, "500 words each, programs ran from 2.000 to 5.000 ms\n"));
  CHECK(has(text, "dsp 1 reset at 0.020000 s: its program ran after 4.000 ms\n"));
  CHECK(has(text, "dsp 2 reset at 0.030000 s: its program has not run yet\n"));
}

TEST_CASE("what is still open of a work cycle is said where a cycle has unloaded and is not over") {
  const std::string said = "t_w, t_wait and T_a: when the AGV has been loaded again";
  report::RunReport run;
  run.cycles.emplace_back().t3 = 10s;
  CHECK(!has(to_text(run), said));  // its AGV has not unloaded yet
  run.cycles[0].t6 = 20s;
  CHECK(has(to_text(run), said));
  run.cycles[0].T_a = 90s;
  CHECK(!has(to_text(run), said));
}

TEST_CASE("an error tells how far the load moved until it was noticed, until the response, and at most") {
  report::RunReport run;
  report::HandledError error;
  error.origin = "drive fault", error.robot = "crane", error.of = {"luff"}, error.noticed = 2s;
  error.moved_until_noticed_m = 0.125, error.moved_until_done_m = 0.25, error.moved_most_m = 0.5;
  error.stands = true;
  run.errors_handled = {error};
  const std::string text = to_text(run);
  CHECK(has(text, "moved 0.125 m until the error was noticed, 0.250 m until the response was done, at most 0.500 m"));
  CHECK(has(text, "NOT CLEARED"));
  run.errors_handled[0].cleared = 3s;
  CHECK(has(to_text(run), "cleared by the operator at 3.0000 s"));
  CHECK(!has(to_text(run), "NOT CLEARED"));
}

TEST_CASE("a run that had no time after its stop says nothing of it") {
  report::RunReport run;
  run.after_stop = report::AfterStop{.from = 3s, .to = 3s, .moved_m = 0.25};
  CHECK(!has(to_text(run), "After the stop"));
  run.after_stop->to = 5s;
  CHECK(has(to_text(run), "After the stop, braked, 3.000 to 5.000 s\n  load: moved up to 250 mm"));
}

TEST_CASE("a bus tells each master's waits by rank, and by how long") {
  report::RunReport run;
  report::MasterReport master;
  master.name = "dsp 3", master.transactions = 10, master.words_read = 4, master.words_written = 6;
  master.wait.count = 10, master.wait.mean = 2.25, master.wait.p50 = 1, master.wait.p99 = 6, master.wait.p99_9 = 7;
  master.wait.worst = 8;
  master.wait.histogram[0] = 5, master.wait.histogram[2] = 3, master.wait.histogram[9] = 1;
  master.wait.histogram[12] = 1;  // the last column is all from 128 clocks on
  report::BusReport& bus = run.buses.emplace_back();
  bus.name = "A", bus.clocks = 200, bus.masters = {master};
  bus.data = 50, bus.wait = 20, bus.turnaround = 10, bus.idle_requested = 30, bus.idle = 90;
  const std::string text = to_text(run);
  CHECK(has(text, "Bus A: 25.0 % data, 10.0 % wait, 5.0 % turnaround, 15.0 % idle though requested, 45.0 % idle\n"));
  CHECK(line_of(text, "dsp 3") == Words{"10", "4", "6", "2.25", "1", "6", "7", "8"});
  const std::string shares = text.substr(text.find("% by wait"));
  CHECK(line_of(shares, "dsp 3") == Words{"50.0", "0", "30.0", "0", "0", "0", "0", "0", "20.0"});
}

TEST_CASE("a comparison is in percent of the size of the ideal value, whatever its sign") {
  report::Comparison comparison;
  comparison.rows.push_back({{"lag", "s", -3.0}, -4.0});
  comparison.rows.push_back({{"load", "m", 5.0}, 4.0});
  const std::string text = to_text(comparison);
  CHECK(line_of(text, "lag") == Words{"s", "-3", "-4", "1", "+25.0"});
  CHECK(line_of(text, "load") == Words{"m", "5", "4", "1", "+25.0"});
}
