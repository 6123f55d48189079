// The time of a DSP in intervals: what it waits for while it asks for the list, and since when a lost block is lost.
#include "cmrc/measures/dsp_intervals.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <vector>

namespace {

using cmrc::DspInterval;
using cmrc::SlotState;
using cmrc::Time;
using End = report::Run::End;

Time us(std::int64_t n) { return std::chrono::microseconds{n}; }

struct Kept final : cmrc::DspIntervalListener {
  void interval(const DspInterval& one) override { all.push_back(one); }
  std::vector<DspInterval> all;
};

std::int64_t held_up(const DspInterval& one, cmrc::HeldUpBy by) { return one.held_up[static_cast<std::size_t>(by)]; }

}  // namespace

TEST_CASE("an access that began before the first refusal waits for its window until then, and no longer") {
  Kept kept;
  cmrc::DspIntervals intervals(kept);
  intervals.slot_is(0, SlotState::awake, us(0));
  intervals.refused(0, us(10));
  intervals.held_up(0, machine::Window::a, us(6), us(14));   // from 10 on it is a part of the wait for the list
  intervals.held_up(0, machine::Window::b, us(15), us(18));  // as is this
  intervals.refused(0, us(20));
  intervals.list(1, us(25));  // slot 0 has it
  intervals.held_up(0, machine::Window::b, us(30), us(33));
  intervals.finish(us(40));
  REQUIRE(kept.all.size() == 1);
  const DspInterval& one = kept.all.front();
  CHECK((one.from == us(0) && one.to == us(40)));
  CHECK(held_up(one, cmrc::HeldUpBy::window_a) == us(4).count());
  CHECK(held_up(one, cmrc::HeldUpBy::list) == us(15).count());
  CHECK(held_up(one, cmrc::HeldUpBy::window_b) == us(3).count());
}

TEST_CASE("a block is lost from the first report on that its DSP is off") {
  Kept kept;
  cmrc::DspIntervals intervals(kept);
  intervals.slot_is(0, SlotState::awake, us(0));
  cmrc::TakenBlock block;
  block.at = us(10);
  intervals.took(0, block);
  intervals.slot_is(0, SlotState::off, us(30));
  intervals.slot_is(0, SlotState::off, us(50));
  intervals.left(0, block.job, End::taken_away, us(70), {});
  intervals.finish(us(100));
  REQUIRE(kept.all.size() == 3);
  CHECK((kept.all[0].doing == SlotState::awake && kept.all[0].to == us(10)));
  CHECK((kept.all[1].doing == SlotState::busy && kept.all[1].to == us(30) && kept.all[1].end == End::failed));
  CHECK((kept.all[2].doing == SlotState::off && kept.all[2].from == us(30) && kept.all[2].to == us(100)));
}

TEST_CASE("a block that is put back late does not end the block that its DSP runs by then") {
  Kept kept;
  cmrc::DspIntervals intervals(kept);
  cmrc::TakenBlock lost, next;
  lost.job.number = 1, next.job.number = 2;
  lost.at = us(10), next.at = us(40);
  intervals.slot_is(0, SlotState::awake, us(0));
  intervals.took(0, lost);
  intervals.slot_is(0, SlotState::off, us(20));
  intervals.booted(0, us(30));
  intervals.took(0, next);
  intervals.left(0, lost.job, End::taken_away, us(50), {});
  intervals.left(0, next.job, End::done, us(60), {});
  intervals.finish(us(70));
  REQUIRE(kept.all.size() == 6);
  CHECK((kept.all[1].doing == SlotState::busy && kept.all[1].to == us(20) && kept.all[1].end == End::failed));
  CHECK((kept.all[4].doing == SlotState::busy && kept.all[4].to == us(60) && kept.all[4].end == End::done));
}
