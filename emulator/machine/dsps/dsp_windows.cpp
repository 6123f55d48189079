// Accesses of a DSP board through its two windows: routes, immediate answers, the bridges' answers, posted writes.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "machine/bus_agents/guard.hpp"
#include "machine/dsps/dsp.hpp"

namespace machine {

Dsp::Path& Dsp::found_path(std::uint32_t address) {
  const std::vector<BusRoute>& routes = on_a(address) ? context_.window_a : context_.window_b;
  const auto found = std::ranges::find_if(
      routes, [offset = offset_of(address)](const BusRoute& route) { return route.holds(offset); });
  const BusRoute& route = found != routes.end() ? *found : routes.back();
  Side& side = sides_[route.port];
  return last_path_[on_a(address)] = {route, &side.bridge, &context_.bus_clocks[side.bus], {}};
}

bool Dsp::writable(Window window, Offset offset) const {
  if (window == Window::b) return context_.devices != nullptr && context_.devices->answers(offset, true);
  return offset < SharedSram::size || context_.registers.answers(offset, true, false);
}

// Answers at once a write for which the bridge has room, and a read that the bridge's line answers. Any other read goes
// to its bridge now, ahead of its turn, as a posted write does, unless something could act on the board before.
bool Dsp::answer_at_once(const c40::ExternalAccess& access, c40::WindowAnswer& answer) {
  const Path& path = path_of(access.address);
  const Offset offset = offset_of(access.address);
  if (access.write) {
    const Time issued = clock_.at(access.cycle);
    if (!writable(window_of(access.address), offset) || issued >= run_end_ || !path.bridge->has_room()) {
      refused_ = access.cycle;
      return false;
    }
    post(path, access, issued);
    return true;
  }
  pci::Bridge::Hit hit;
  if (!path.bridge->look_up(offset + path.route.shift, hit)) {
    refused_ = access.cycle;
    const Time issued = clock_.at(access.cycle);
    if (issued < run_end_ && !chip_.dma_active()) {
      access_ = access;
      begin_read(path, issued);
    }
    return false;
  }
  statistics_.prefetch_hits += 1;
  const Time ready = path.bus->at(hit.ready);
  const bool is_there = ready <= clock_.at(access.cycle + hit_cycles_);
  answer.value = hit.value;
  answer.transfer = is_there ? hit_cycles_ : clock_.tick_at_or_after(ready) - access.cycle;
  return true;
}

// Where accesses take no time. Nothing else happens up to and with this access, so its turn would find the same.
bool Dsp::answer_instantly(const c40::ExternalAccess& access, c40::WindowAnswer& answer) {
  const Time issued = clock_.at(access.cycle);
  const bool first = issued < run_end_ && context_.scheduler.is_first_until(issued, *this);
  if (first && access_instantly(access, issued, answer.value)) return true;
  refused_ = access.cycle;
  return false;
}

// An access that no target takes goes to the bus, and ends there as ever. No target makes a DSP wait.
[[gnu::always_inline]] inline bool Dsp::access_instantly(const c40::ExternalAccess& access, Time issued, Word& value) {
  const Window window = window_of(access.address);
  const Offset offset = offset_of(access.address);
  Path& path = path_of(access.address);
  if (access.write && !writable(window, offset)) return false;
  if (access.write) issue_write(access, issued), value = access.value;
  const pci::Clocks clock = path.bus->tick_at_or_after(issued);
  const pci::Access seen{.master = path.bridge->master(), .clock = clock, .agent = slot_ + 1};
  const pci::Address address = offset + path.route.shift;
  if (!path.target.holds(address)) path.target = context_.buses[path.route.bus].window_at(address);
  if (!path.target.holds(address) || !path.target.access(address, access.write, value, seen)) return false;
  if (access.write)
    statistics_.posted_writes += 1, arrived(window, offset, value, issued, path.bus->at(clock));
  else
    statistics_.bus_reads += 1;
  return true;
}

// An access that was not answered at once, or before which the chip has to stop: while its DMA is active.
bool Dsp::window_access(const c40::ExternalAccess& access) {
  const bool asked = std::exchange(refused_, -1) == access.cycle;
  if (asked && state_ == State::blocked) return false;  // the read has gone to its bridge
  if (access.write && !writable(window_of(access.address), offset_of(access.address))) {
    const char bus = static_cast<char>('A' + sides_[path_of(access.address).route.port].bus);
    fault(access.cycle, chip_.pc(), access.address,
          fmt::format("a write that nothing on bus {} takes from a DSP (PCI master abort)", bus));
    return false;
  }
  if (!asked && !instant_) {  // its DMA is active, or was
    if (c40::WindowAnswer answer; answer_at_once(access, answer)) {
      if (access.write)
        chip_.complete_write(answer.arbitration, answer.transfer);
      else
        chip_.complete_read(answer.value, answer.arbitration, answer.transfer);
      return true;
    }
    refused_ = -1;
    if (state_ == State::blocked) return false;
  }
  access_ = access;
  state_ = State::access;
  own_next_ = clock_.at(access.cycle);
  return false;
}

[[gnu::always_inline]] inline void Dsp::issue_write(const c40::ExternalAccess& access, Time issued) {
  const Window window = window_of(access.address);
  const Offset offset = offset_of(access.address);
  if (context_.observer == nullptr || !context_.observer->wants_issues_at(window, offset)) return;
  chip_.catch_up();
  context_.observer->dsp_issue(slot_, window, offset, access.value, issued);
}

void Dsp::post(const Path& path, const c40::ExternalAccess& access, Time issued) {
  const Window window = window_of(access.address);
  const Offset offset = offset_of(access.address);
  statistics_.posted_writes += 1;
  issue_write(access, issued);
  const Mark mark{.window = window, .direct = path.route.direct, .offset = offset};
  path.bridge->write({.address = offset + path.route.shift,
                      .value = access.value,
                      .clock = path.bus->tick_at_or_after(issued),
                      .stamp = issued.count(),
                      .mark = std::bit_cast<std::uint64_t>(mark)});
}

void Dsp::begin_access(Time horizon) {
  const Time issued = clock_.at(access_.cycle);
  if (Word value = 0; instant_ && access_instantly(access_, issued, value)) {
    if (access_.write)
      chip_.complete_write(0, 0);
    else
      chip_.complete_read(value, 0, 0);
    return run(horizon);
  }
  const Path& path = path_of(access_.address);
  if (!access_.write) return begin_read(path, issued);
  if (path.bridge->has_room()) {
    post(path, access_, issued);
    chip_.complete_write(0, 0);
    return run(horizon);
  }
  state_ = State::blocked;
  own_next_ = never;
  post(path, access_, issued);
}

void Dsp::begin_read(const Path& path, Time issued) {
  state_ = State::blocked;
  own_next_ = never;
  statistics_.bus_reads += 1;
  const pci::Clocks clock = path.bus->tick_at_or_after(issued);
  const bool together = path.bus->at(clock) == issued;  // the bus's events of that instant come first
  path.bridge->read(offset_of(access_.address) + path.route.shift, clock, clock + together);
}

void Dsp::answered(const Side& side, Word value, pci::Clocks ready, pci::Clocks arbitration, pci::Result result) {
  if (state_ != State::blocked) return;
  if (result != pci::Result::done) {
    const c40::Cycles cycle = std::max(access_.cycle, clock_.tick_at_or_after(context_.bus_clocks[side.bus].at(ready)));
    return fault(cycle, chip_.pc(), access_.address,
                 fmt::format("a read that nothing on bus {} answers (PCI {} abort)", static_cast<char>('A' + side.bus),
                             result == pci::Result::master_abort ? "master" : "target"));
  }
  answer_ = value;
  resume_at(side, ready, arbitration);
}

// The chip waited from the access to bus clock `ready`; for `arbitration` clocks of this it waited for the bus.
void Dsp::resume_at(const Side& side, pci::Clocks ready, pci::Clocks arbitration) {
  if (state_ != State::blocked) return;
  const Clock& bus = context_.bus_clocks[side.bus];
  const c40::Cycles resumes = std::max(access_.cycle, clock_.tick_at_or_after(bus.at(ready)));
  const c40::Cycles waited = resumes - access_.cycle;
  arbitration_ = std::min(waited, clock_.ticks_in(bus.at(arbitration) - bus.at(0)));
  transfer_ = waited - arbitration_;
  state_ = State::resuming;
  own_next_ = clock_.at(resumes);
  if (chip_.dma_active()) return plan();
  // The chip continues at once if nothing can act on the board before: its turn would find the same.
  const Time until = horizon();
  if (own_next_ >= std::min({until, edge_, reset_})) return plan();
  complete(until);
  set_next();
}

void Dsp::complete(Time horizon) {
  const Window window = window_of(access_.address);
  if (window == Window::b) {
    statistics_.window_b_arbitration += arbitration_;
    statistics_.window_b_transfer += transfer_;
  }
  if (context_.observer != nullptr)
    context_.observer->dsp_waited(slot_, window, clock_.at(access_.cycle),
                                  clock_.at(access_.cycle + arbitration_ + transfer_));
  if (access_.write)
    chip_.complete_write(arbitration_, transfer_);
  else
    chip_.complete_read(answer_, arbitration_, transfer_);
  run(horizon);
}

// The word has left the board's bridge: it has reached its target, or is in a bridge between buses.
void Dsp::landed(const Side& side, const pci::Posted& posted, pci::Clocks clock) {
  const Mark mark = std::bit_cast<Mark>(posted.mark);
  if (mark.direct) {
    const Time now = context_.bus_clocks[side.bus].at(clock);
    return arrived(mark.window, mark.offset, posted.value, Time{posted.stamp}, now);
  }
  const std::vector<BusRoute>& routes = mark.window == Window::a ? context_.window_a : context_.window_b;
  const auto route = std::ranges::find_if(routes, [&](const BusRoute& one) { return one.holds(mark.offset); });
  underway_.push_back({route->bus, mark.window, mark.offset, posted});
}

void Dsp::delivered(unsigned bus, pci::Address address, pci::Clocks clock, pci::Result result) {
  const auto first = std::ranges::find_if(
      underway_, [&](const Underway& word) { return word.bus == bus && word.posted.address == address; });
  if (first == underway_.end()) return;
  const Underway word = *first;
  underway_.erase(first);
  if (result == pci::Result::done) {
    const Time now = context_.bus_clocks[bus].at(clock);
    arrived(word.window, word.offset, word.posted.value, Time{word.posted.stamp}, now);
  }
}

void Dsp::arrived(Window window, Offset offset, Word value, Time issued, Time now) {
  const auto refused = window == Window::a && context_.guard != nullptr
                           ? context_.guard->take_refusal(slot_, offset, value)
                           : std::nullopt;
  const bool dropped = refused || context_.fence.closed(slot_);
  statistics_.dropped_writes += dropped;
  if (context_.observer == nullptr) return;
  if (refused) context_.observer->dsp_write_refused(slot_, offset, value, *refused, now);
  if (dropped)
    context_.observer->dsp_write_dropped(slot_, window, offset, value, issued, now);
  else
    context_.observer->dsp_write(slot_, window, offset, value, issued, now);
}

}  // namespace machine
