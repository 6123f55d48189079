#include "cmrc/measures/dsp_intervals.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "machine/system/observer.hpp"

namespace cmrc {
namespace {

// A change of a DSP's state is reported within a millisecond of its time; a delay that is older belongs to the known
// state.
constexpr Time reported_within = std::chrono::milliseconds{1};

}  // namespace

DspIntervals::Lane& DspIntervals::lane(unsigned slot) {
  if (lanes_.size() <= slot) lanes_.resize(slot + 1);
  lanes_[slot].now.slot = slot;
  return lanes_[slot];
}

// Ends the present interval.
void DspIntervals::close(Lane& lane, Time at) {
  if (!std::exchange(lane.begun, true)) return;
  book_waits(lane, at);
  lane.now.to = at;
  if (lane.now.from < at || lane.now.doing == SlotState::busy) listener_.interval(lane.now);
}

void DspIntervals::next(unsigned slot, SlotState doing, Time at) {
  Lane& of = lane(slot);
  const Time from = of.begun ? std::max(at, of.now.from) : at;
  if (of.begun && doing == of.now.doing && doing != SlotState::busy) return;
  if (doing != SlotState::awake) got_list(of, from);
  close(of, from);
  of.failed.reset();
  of.now = {.slot = slot, .doing = doing, .from = from};
}

void DspIntervals::slot_is(unsigned slot, SlotState state, Time at) {
  Lane& of = lane(slot);
  const bool runs = of.begun && of.now.doing == SlotState::busy;
  if (state == SlotState::awake) {
    // A DSP that runs a block, or is halted, may still get a doorbell.
    if (!runs && !(of.begun && of.now.doing == SlotState::off)) next(slot, state, at);
    return;
  }
  if (runs && state == SlotState::off) {
    if (!of.failed) of.failed = at;
    return;
  }
  if (runs) lose_block(of, report::Run::End::failed, at);
  next(slot, state, at);
}

void DspIntervals::booted(unsigned slot, Time at) {
  Lane& of = lane(slot);
  if (of.begun && of.now.doing == SlotState::busy) lose_block(of, report::Run::End::failed, at);
  next(slot, SlotState::awake, at);
}

void DspIntervals::took(unsigned slot, const TakenBlock& block) {
  Lane& of = lane(slot);
  if (of.begun && of.now.doing == SlotState::busy) lose_block(of, report::Run::End::failed, block.at);
  next(slot, SlotState::busy, block.at);
  lane(slot).now.block = block;
}

void DspIntervals::left(unsigned slot, const report::JobName& job, report::Run::End end, Time at,
                        const std::vector<std::int64_t>& cycles) {
  Lane& of = lane(slot);
  if (!of.begun || of.now.doing != SlotState::busy || of.now.block.job != job) return;
  if (end == report::Run::End::taken_away) return lose_block(of, end, at);
  of.now.end = end;
  of.now.cycles = cycles;
  next(slot, SlotState::awake, at);
}

// Its run is lost: from its DSP's failure on or, if that is not known, from now on.
void DspIntervals::lose_block(Lane& of, report::Run::End end, Time at) {
  of.now.end = of.failed ? report::Run::End::failed : end;
  const bool off = of.failed.has_value();
  next(of.now.slot, off ? SlotState::off : SlotState::awake, std::min(of.failed.value_or(at), at));
}

void DspIntervals::wait(Lane& of, const Wait& wait) {
  if (wait.from >= wait.to || !of.begun) return;
  // Limits memory: a long block may wait a million times.
  if (of.waits.size() > 4096) book_waits(of, wait.from - reported_within);
  of.waits.push_back(wait);
}

void DspIntervals::held_up(unsigned slot, machine::Window window, Time from, Time to) {
  Lane& of = lane(slot);
  // Its accesses while it asks for the list again and again count as waiting for the list.
  if (of.refused) to = std::min(to, *of.refused);
  wait(of, {std::max(from, of.lists), to, window == machine::Window::a ? HeldUpBy::window_a : HeldUpBy::window_b});
}

void DspIntervals::refused(unsigned slot, Time at) {
  Lane& of = lane(slot);
  if (of.begun && of.now.doing == SlotState::awake && !of.refused) of.refused = at;
}

void DspIntervals::got_list(Lane& of, Time at) {
  if (!of.refused) return;
  wait(of, {*of.refused, at, HeldUpBy::list});
  of.lists = at;
  of.refused.reset();
}

void DspIntervals::list(unsigned owner, Time at) {
  if (owner != 0 && owner != machine::host_owner) got_list(lane(owner - 1), at);
}

void DspIntervals::book_waits(Lane& of, Time until) {
  while (!of.waits.empty() && of.waits.front().from < until) {
    Wait& first = of.waits.front();
    const Time from = std::max(first.from, of.now.from), to = std::min(first.to, until);
    if (from < to) of.now.held_up[static_cast<std::size_t>(first.by)] += (to - from).count();
    first.from = to;
    if (first.from < first.to) break;
    of.waits.pop_front();
  }
}

void DspIntervals::finish(Time now) {
  for (Lane& of : lanes_) {
    if (!of.begun) continue;
    if (of.failed) lose_block(of, report::Run::End::failed, now);
    got_list(of, now);
    close(of, std::max(now, of.now.from));
    of = {};
  }
}

}  // namespace cmrc
