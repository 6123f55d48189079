#include "cmrc/run/observer.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "bus_model/bus.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "state/visitor.hpp"

namespace cmrc {
namespace {

using report::Component;
using report::EventKind;

Component component_of(machine::BusId bus) {
  return static_cast<Component>(report::bus_a + static_cast<unsigned>(bus));
}

}  // namespace

RunObserver::RunObserver(const Words& words, Ledger& ledger, report::EventLog& log, std::size_t samples_max)
    : words_(words),
      ledger_(ledger),
      log_(log),
      snapshots_(machine::most_slots),
      blocks_(words.block_count),
      faults_(machine::most_slots),
      resets_(machine::most_slots),
      boots_(machine::most_slots),
      hold_(samples_max),
      refresh_duration_(samples_max) {}

void RunObserver::attach(plant::Dock& dock, Course* course, double wind_limit) {
  wind_.emplace(dock.config().wind, wind_limit);
  motion_.emplace(dock);
  dock.on_latch([this, &dock, course](plant::Time time, std::span<const int> codes) {
    if (course != nullptr) course->latch(dock, time);
    if (watcher_ != nullptr) watcher_->latched(dock, time);
    report::Event event{time, report::plant, EventKind::latch, {}};
    for (std::size_t i = 0; i < event.arguments.size() && i < codes.size(); ++i)
      event.arguments[i] = static_cast<std::uint32_t>(codes[i]);
    log_.add(event);
    for (const Instability::Found& found : instability_.latch(time / plant::latch_period, codes)) {
      if (!servoing_()) break;
      const Time since = found.since * plant::latch_period;
      const char* joint = plant::joint_names(dock.config().crane.machine).at(found.joint).name;
      failures_.push_back({time, std::nullopt, "unstable",
                           fmt::format("the loop of joint {} is unstable: since {:.3f} s its drive's torque swings "
                                       "between both ends of its range, at {:.1f} Hz",
                                       joint, static_cast<double>(since.count()) * 1e-12, found.frequency_hz)});
    }
    double squares = 0;
    const std::uint32_t on = dock.drives_on();
    for (std::size_t j = 0; j < codes.size(); ++j) {
      if ((on >> j & 1) == 0) continue;  // no torque, whatever its code
      constexpr double full_torque = plant::largest_torque_code;
      squares += static_cast<double>(codes[j]) * codes[j] / (full_torque * full_torque);
      if (std::abs(codes[j]) >= plant::largest_torque_code) ++saturated_[j];
    }
    effort_ += squares * static_cast<double>((time - effort_until_).count()) * 1e-12;
    effort_until_ = time;
    standstill_.latch(dock.braked(), time);
    wind_->at(time);
    motion_->latch(dock, time);
  });
  dock.on_event([this, crane = dock.config().crane.machine](const plant::Event& event) { dock_event(event, crane); });
}

void RunObserver::dock_event(const plant::Event& event, plant::CraneKind crane) {
  const auto index = static_cast<std::uint32_t>(event.index);
  const auto add = [&](EventKind kind) { log_.add({event.time, report::plant, kind, {index, 0, 0, 0, 0}}); };
  const auto failed = [&](std::string_view why) {
    const std::string object = plant::object_of(event, crane);
    failures_.push_back(
        {event.time, std::nullopt, "plant",
         fmt::format("{}{}{}", plant::name(event.kind), object.empty() ? "" : " (" + object + ")", why)});
  };
  switch (event.kind) {
    case plant::EventKind::landed: add(EventKind::landed); break;
    case plant::EventKind::locked: add(EventKind::locked); break;
    case plant::EventKind::opened: add(EventKind::opened); break;
    case plant::EventKind::delivered: add(EventKind::delivered); break;
    case plant::EventKind::drive_tripped:
      failed(fmt::format(": {}", plant::name(static_cast<plant::Trip>(event.values[0]))));
      break;
    case plant::EventKind::drive_stopped:
      if (!servoing_()) break;
      [[fallthrough]];
    case plant::EventKind::hard_landing:
    case plant::EventKind::refused:
    case plant::EventKind::agv_dry:
    case plant::EventKind::agv_overflow:
    case plant::EventKind::joint_limit:
    case plant::EventKind::drive_resumed:
    case plant::EventKind::drive_warm:
    case plant::EventKind::collision:
    case plant::EventKind::fault: failed(""); break;
    default: break;
  }
}

std::optional<std::size_t> RunObserver::flag_of(machine::Offset offset) const {
  const Word in_pool = offset - words_.block_pool;
  if (in_pool >= words_.block_count * words_.block_words || in_pool % words_.block_words != words_.flag)
    return std::nullopt;
  return in_pool / words_.block_words;
}

// ---- claims and ends ----

void RunObserver::dsp_issue(unsigned slot, machine::Window, machine::Offset offset, machine::Word value, Time issued) {
  snapshots_[slot].push_back({issued, offset, causes_(slot)});
  if (profile_ == nullptr) return;
  if (value == words_.flag_taken) profile_->taken(slot, issued);
  if (value == words_.flag_done) profile_->done(slot, offset, issued);
}

CauseTimes RunObserver::take_snapshot(unsigned slot, machine::Offset offset, Time issued) {
  auto& waiting = snapshots_[slot];
  while (!waiting.empty()) {
    Snapshot first = std::move(waiting.front());
    waiting.pop_front();
    if (first.issued == issued && first.offset == offset) return std::move(first.causes);
  }
  return {};
}

void RunObserver::pid_error(std::size_t joint, machine::Word value) {
  if (!errors_hold_) return;
  pid_error_[joint].add(from_ti_float(value));
}

void RunObserver::dsp_write(unsigned slot, machine::Window window, machine::Offset offset, machine::Word value,
                            Time issued, Time now) {
  if (window != machine::Window::a) return;
  // PID writes its words in rising order: the stage comes before the errors.
  if (errors_ != 0 && offset == stage_) errors_hold_ = value == servoing_stage_;
  if (const Word joint = offset - errors_; errors_ != 0 && joint < pid_error_.size()) return pid_error(joint, value);
  if (offset == words_.doorbell_idle || offset == words_.doorbell_busy)
    return idle(slot, offset == words_.doorbell_idle, now);
  const Word in_pool = offset - words_.block_pool;
  if (in_pool >= words_.block_count * words_.block_words) return;
  const std::size_t block = in_pool / words_.block_words;
  const Word word = in_pool % words_.block_words;
  blocks_[block][word] = value;
  if (word != words_.flag) return;
  if (value == words_.flag_taken) claim(slot, block, issued, now);
  if (value == words_.flag_done) finish(slot, block, issued, now);
}

void RunObserver::claim(unsigned slot, std::size_t block, Time issued, Time now) {
  const auto at = [&](Word word) { return peek_(words_.block(block) + word); };
  ledger_.claimed(block, slot, issued, take_snapshot(slot, words_.block(block) + words_.flag, issued),
                  at(words_.generation));
  if (profile_ != nullptr) profile_->claimed(slot, issued, ledger_.job_with(block));
  log_.add({now,
            report::dsp(slot),
            EventKind::claim,
            {words_.block(block), at(words_.kind), at(words_.area), at(words_.tick), at(words_.generation)}});
  this->issued(slot, block, words_.flag_taken, issued, now);
}

void RunObserver::finish(unsigned slot, std::size_t block, Time issued, Time now) {
  const machine::Offset flag = words_.block(block) + words_.flag;
  const bool part = (blocks_[block][words_.notify] & words_.must_continue) != 0;
  const bool ended = ledger_.finished(block, slot, issued, take_snapshot(slot, flag, issued), part);
  if (profile_ != nullptr) profile_->landed(slot, flag, issued, {ended ? ledger_.job_with(block) : std::nullopt, part});
  log_.add({now,
            report::dsp(slot),
            EventKind::finish,
            {words_.block(block), peek_(words_.block(block) + words_.kind), blocks_[block][words_.result],
             blocks_[block][words_.notify], peek_(words_.block(block) + words_.generation)}});
  this->issued(slot, block, words_.flag_done, issued, now);
}

// The account of a run uses the program's own write. It arrives later by the time that it waited for the bus.
void RunObserver::issued(unsigned slot, std::size_t block, Word flag, Time issued, Time now) {
  const auto delay = static_cast<std::uint64_t>((now - issued).count());
  log_.add(
      {now,
       report::dsp(slot),
       EventKind::issue,
       {words_.block(block), flag, static_cast<std::uint32_t>(delay), static_cast<std::uint32_t>(delay >> 32), 0}});
}

void RunObserver::idle(unsigned slot, bool idle, Time now) {
  ledger_.timeline().doorbell(slot, idle ? SlotState::asleep : SlotState::awake, now);
  log_.add({now, report::dsp(slot), EventKind::idle, {idle ? 1U : 0U, 0, 0, 0, 0}});
}

// ---- everything else ----

void RunObserver::dsp_write_dropped(unsigned slot, machine::Window window, machine::Offset offset, machine::Word value,
                                    Time issued, Time now) {
  if (profile_ != nullptr && window == machine::Window::a) profile_->landed(slot, offset, issued, {});
  log_.add({now,
            report::dsp(slot),
            EventKind::dropped_write,
            {window == machine::Window::a ? 0U : 1U, offset, value, 0, 0}});
}

// One entry per DSP and kind of task: a task that goes astray writes thousands of words.
void RunObserver::dsp_write_refused(unsigned slot, machine::Offset offset, machine::Word value, machine::Word kind,
                                    Time now) {
  const std::string task = kind < words_.kind_count ? ledger_.name(job_kind(kind, words_)) : "no task";
  const auto [found, first] = refused_.try_emplace({slot, kind}, Refused{failures_.size(), 0, {}});
  Refused& entry = found->second;
  if (first) {
    entry.first = fmt::format("{:08X}h at offset {:X}h", value, offset);
    failures_.push_back({now, slot, "guard", {}});
  }
  ++entry.count;
  failures_[entry.failure].message = fmt::format("{} wrote {} outside its area, refused: {}", task,
                                                 entry.count == 1 ? "a word" : fmt::format("{} words", entry.count),
                                                 entry.count == 1 ? entry.first : "the first " + entry.first);
}

void RunObserver::transaction(machine::BusId bus, const pci::Transaction& transaction, Time now) {
  log_.add({now,
            component_of(bus),
            EventKind::bus_transaction,
            {transaction.master, transaction.address, transaction.words, transaction.write ? 1U : 0U,
             static_cast<std::uint32_t>(transaction.waited)}});
}

void RunObserver::interrupt(unsigned slot, int pin, Time now) {
  ledger_.timeline().doorbell(slot, SlotState::awake, now);
  log_.add({now, report::dsp(slot), EventKind::interrupt, {static_cast<std::uint32_t>(pin), 0, 0, 0, 0}});
}

void RunObserver::semaphore(unsigned number, machine::SemaphoreEvent event, unsigned owner, Time now) {
  const bool of_list = number == words_.semaphore_list - words_.semaphore;
  if (event == machine::SemaphoreEvent::refused) {
    if (watcher_ != nullptr && of_list && owner != machine::host_owner) watcher_->refused(owner - 1, now);
    return;
  }
  const bool acquired = event == machine::SemaphoreEvent::acquired;
  log_.add({now, report::bus_a, EventKind::semaphore, {number, acquired ? 1U : 0U, owner, 0, 0}});
  if (of_list) list_taken(acquired ? owner : Timeline::nobody, now);
  if (owner != machine::host_owner) return;
  if (acquired) {
    held_since_ = now;
  } else {
    hold_.add((now - held_since_).count());
    ledger_.list_freed(now);
  }
}

void RunObserver::list_taken(unsigned owner, Time now) {
  ledger_.timeline().list(owner, now);
  host_has_list_ = owner == machine::host_owner;
  if (!host_has_list_ && posted_) refresh_ended(*std::exchange(posted_, std::nullopt), now);
}

void RunObserver::refreshed(Time tick, std::size_t blocks, Time now) {
  const Refresh refresh{tick, ledger_.refresh(), blocks};
  if (host_has_list_)
    posted_ = refresh;
  else
    refresh_ended(refresh, now);
}

void RunObserver::refresh_ended(const Refresh& refresh, Time now) {
  refresh_duration_.add((now - refresh.tick).count());
  ledger_.refresh_ended(refresh.times, now, refresh.blocks);
}

report::Distribution RunObserver::refresh_duration(std::optional<Time> under_way, Time end) const {
  report::Distribution all = refresh_duration_;
  if (posted_) all.add((end - posted_->tick).count());
  if (under_way) all.add((end - *under_way).count());
  return all;
}

void RunObserver::close_refreshes(bool under_way, Time end, RunWatcher& watcher) const {
  if (posted_) watcher.refreshing(posted_->times, end);
  if (under_way) watcher.refreshing(ledger_.refresh(), end);
}

void RunObserver::fault(const machine::ChipFault& fault) {
  ++faults_.at(fault.slot);
  standstill_.stops(fault.slot, fault.time);
  ledger_.slot_failed(fault.slot, fault.time);
  log_.add({fault.time, report::dsp(fault.slot), EventKind::fault, {0, fault.pc, fault.address, 0, 0}});
  failures_.push_back({fault.time, fault.slot, "fault", fault.message});
}

void RunObserver::slot(unsigned slot, machine::SlotChange change, Time now) {
  std::vector<report::BootReport>& boots = boots_.at(slot);
  if (change == machine::SlotChange::unplugged)
    standstill_.stops(slot, now);
  else
    standstill_.works(slot);
  if (change == machine::SlotChange::reset) boots.push_back({now, {}});
  if (change == machine::SlotChange::booted) {
    ledger_.timeline().slot(slot, SlotState::awake, now);
    if (watcher_ != nullptr) watcher_->booted(slot, now);
    boots.back().booted = now;
  }
  if (change == machine::SlotChange::unplugged || change == machine::SlotChange::reset) {
    ledger_.slot_failed(slot, now);
    snapshots_[slot].clear();
    if (profile_ != nullptr) profile_->reset(slot);
  }
  const bool booted = change == machine::SlotChange::booted || change == machine::SlotChange::plugged;
  log_.add({now, report::dsp(slot), EventKind::reset, {booted ? 1U : 0U, static_cast<std::uint32_t>(change), 0, 0, 0}});
}

void RunObserver::link_lost(unsigned slot, bool to_dsp, machine::Word word, int bytes, Time now) {
  log_.add({now,
            report::dsp(slot),
            EventKind::link_lost,
            {word, to_dsp ? 1U : 0U, static_cast<std::uint32_t>(bytes), 0, 0}});
}

void RunObserver::scripted(const machine::ScriptedEvent& event, Time now) {
  using machine::Action;
  if (event.action == Action::fail || event.action == Action::freeze) standstill_.stops(event.number, now);
  if (event.action == Action::fail || event.action == Action::freeze || event.action == Action::hang)
    ledger_.slot_failed(event.number, now);
  log_.add({now,
            report::host,
            EventKind::scripted,
            {static_cast<std::uint32_t>(event.action), event.number, static_cast<std::uint32_t>(event.amount),
             static_cast<std::uint32_t>(event.amount >> 32), 0}});
}

void RunObserver::list_state(state::Visitor& list) {
  list("snapshots", snapshots_);
  list("blocks", blocks_);
  list("failures", failures_);
  list("refused", refused_);
  list("faults", faults_);
  list("resets", resets_);
  list("boots", boots_);
  list("hold", hold_);
  list("held_since", held_since_);
  list("host_has_list", host_has_list_);
  list("refresh_duration", refresh_duration_);
  list("posted", posted_);
  list("pid_error", pid_error_);
  list("saturated", saturated_);
  list("errors_hold", errors_hold_);
  list("instability", instability_);
  list("standstill", standstill_);
  list("effort", effort_);
  list("effort_until", effort_until_);
  list("wind", wind_);
  list("motion", motion_);
}

}  // namespace cmrc
