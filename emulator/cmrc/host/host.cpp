#include "cmrc/host/host.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "cmrc/configuration/machine/clock_deviations.hpp"

namespace cmrc {
namespace {

using report::EventKind;

machine::Clock clock_of(const Oscillator& one) { return one.skew.clock(one.hertz, one.per); }

Time nanoseconds(double ns) { return Time{std::llround(ns * 1000)}; }
Time milliseconds(double ms) { return Time{std::llround(ms * 1e9)}; }

}  // namespace

Host::Host(const Config& config, const Words& words, const CraneJob& crane, const FleetJob& fleet, Ledger& ledger,
           HostListener& listener, std::function<std::vector<Word>(unsigned)> boot_stream)
    : config_(config),
      words_(words),
      parameters_(importance_parameters(config)),
      intervals_(intervals(config)),
      clock_(clock_of(oscillators_of(config).host)),
      ledger_(ledger),
      listener_(listener),
      list_(words.block_count),
      processes_(config.processes, config.tasks, crane, fleet, words_),
      user_tasks_(config_.tasks, words_, config_.rates.refresh_frequency_hz),
      errors_(config, words_, *this),
      control_(config, words_),
      servo_(config_, words_, processes_, list_),
      boots_(words_, std::move(boot_stream), milliseconds(config.watchdog.boot_limit_ms),
             nanoseconds(config.host.boot_pause_ns)),
      lengths_(static_cast<std::size_t>(config.report.samples_max)) {
  const auto& w = config_.watchdog;
  const auto refreshes = [&](double us) {
    return static_cast<std::int64_t>(std::ceil(us * 1e-6 * config_.rates.refresh_frequency_hz));
  };
  const auto kind = [&](std::size_t number, double run_us, double heartbeat_us) {
    longest_[static_cast<JobKind>(number)] = refreshes(run_us);
    if (heartbeat_us > 0) gaps_[static_cast<JobKind>(number)] = refreshes(heartbeat_us);
  };
  for (const KindRow& row : kind_rows)
    kind(static_cast<std::size_t>(row.kind),
         row.run == LongestRun::servo      ? w.servo_run_us
         : row.run == LongestRun::planning ? w.planning_run_us
                                           : w.long_run_us,
         row.heartbeat_us);
  for (std::size_t i = 0; i < config_.tasks.size(); ++i) {
    kind(static_cast<std::size_t>(JobKind::user) + i, w.long_run_us, config_.tasks[i].heartbeat_ms * 1e3);
  }
  set_releases();
  for (unsigned slot = 0;
       config_.machine.boot == BootPolicy::link && slot < static_cast<unsigned>(config_.machine.dsps); ++slot)
    boots_.expect(slot, Time{0});
  rest();
}

// The DSPs plugged in at power-on have booted or been given up.
void Host::start() {
  constexpr Time grid = std::chrono::milliseconds{1};
  const Time ready = (now_ + grid - Time{1}) / grid * grid;
  const std::int64_t first =
      std::max<std::int64_t>(1, clock_.tick_at_or_after(std::max(ready, milliseconds(config_.host.start_ms))));
  tick_ = first - 1;
  refresh_at_ = clock_.at(first);
  servo_.start(first);
  user_tasks_.start(first);
  for (unsigned slot = 0; slot < static_cast<unsigned>(config_.machine.dsps); ++slot) liveness_.sign(slot, looks());
}

// ---- the steps ----

void Host::wake(Time now, machine::HostPort& port) {
  now_ = now;
  port_ = &port;
  wake_at_ = machine::never;
  switch (step_) {
    case Step::resting:
      if (now_ >= refresh_at_)
        begin_refresh();
      else if (boots_.step(now_, *port_))
        step_ = Step::booting;
      else
        rest();
      break;
    case Step::thinking: think(); break;
    case Step::retry: acquire(); break;
    default: break;  // an answer of the bus is due first
  }
  port_ = nullptr;
}

void Host::read_done(std::uint32_t, std::span<const machine::Word> words, Time now, machine::HostPort& port) {
  now_ = now;
  port_ = &port;
  switch (step_) {
    case Step::booting:
      if (!boots_.answer(words[0], now_, *port_)) rest();
      break;
    case Step::pointer: pointer_read(words[0]); break;
    case Step::passed:
      if (passed_read(words[0])) collect_taken();
      break;
    case Step::flags: flag_read(words[0]); break;
    case Step::alive: alive_read(words[0]); break;
    case Step::result:
      done_.push_back({flags_.front(), words[0], words[1]});
      flags_.pop_front();
      next_flag();
      break;
    case Step::owner: owner_read(words[0]); break;
    case Step::verdict: verdict_read(words[0]); break;
    case Step::signs: sign_read(words[0]); break;
    case Step::field: field_read(words[0]); break;
    case Step::semaphore: semaphore_read(words[0]); break;
    case Step::held: held_read(words[0]); break;
    case Step::holder: holder_read(words[0]); break;
    case Step::locked_flags:
      if (words[0] != words_.flag_waiting) taken_in_doubt(flags_.front());
      flags_.pop_front();
      if (flags_.empty())
        relink();
      else
        port_->read(words_.block(flags_.front()) + words_.flag, 1, 0);
      break;
    case Step::relink:
      claimed_before(words[0]);
      if (!look_past(Step::locked_passed)) relink();
      break;
    case Step::locked_passed:
      if (passed_read(words[0])) relink();
      break;
    case Step::doorbell: ring(words[0]); break;
    default: throw std::logic_error("Host: an answer without a request");
  }
  port_ = nullptr;
}

void Host::boot_requested(Time now) {
  boots_.requested();
  if (step_ == Step::resting) wake_at_ = std::min(wake_at_, now);
}

void Host::rest() {
  step_ = Step::resting;
  for (Word slots = boots_.take_without_program(); slots != 0; slots &= slots - 1)
    renewed_.at(static_cast<unsigned>(std::countr_zero(slots))) = ++resets_;
  for (const BootLoader::Ended& ended : boots_.take_ended())
    if (!ended.failure.empty()) {
      listener_.failure({now_, ended.slot, "boot", ended.failure});
      listener_.boot_given_up(ended.slot, now_);
    }
  if (refresh_at_ == machine::never && boots_.done()) start();
  wake_at_ = std::max(now_, std::min(refresh_at_, boots_.next()));
}

void Host::begin_refresh() {
  const std::int64_t before = tick_;
  tick_ = clock_.tick_at_or_before(now_);
  elapsed_ = tick_ - before;
  counts_.skipped_refreshes += static_cast<std::uint64_t>(elapsed_ - 1);
  ++counts_.refreshes;
  ledger_.refresh_began(now_);
  apply_changes();
  grown_ = config_.scheduling.time_after_delay == TimeAfterDelay::one ? 1 : elapsed_;
  done_.clear();
  hung_.clear();
  const std::vector<unsigned> agvs = processes_.sensors_to_read(tick_);
  fields_.assign(agvs.begin(), agvs.end());
  step_ = Step::pointer;
  port_->read(words_.list_work_pointer, 1, 0);
}

void Host::set_releases() {
  const Config::Scheduling& s = config_.scheduling;
  processes_.set_releases({.every = s.event_read_refreshes, .field_mm = std::llround(s.event_field_m * 1000)},
                          s.agv_phase == AgvPhase::staggered);
}

void Host::apply_changes() {
  while (!changes_.empty() && changes_.begin()->first <= clock_.at(tick_)) {
    const std::int64_t before = intervals(config_).agv_slowed;
    const TimedEvent& event = changes_.begin()->second;
    config_ = with_live(config_, event.key, event.value, event.origin);
    const auto [key, bits] = bits_of(event.key, event.value);
    note(EventKind::set, {key, static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32), 0, 0});
    changes_.erase(changes_.begin());
    if (std::exchange(config_.errors.clear, false)) errors_.clear(now_, *this);
    parameters_ = importance_parameters(config_);
    const std::int64_t interval = intervals(config_).agv_slowed;
    processes_.crane().set_interval(intervals(config_).crane_slowed);
    set_releases();
    control_.change(config_);
    processes_.crane().set_speeds(speed_words(config_.control, static_cast<plant::CraneKind>(config_.dock.crane)));
    Fleet& fleet = processes_.fleet();
    for (unsigned agv = 0; interval != before && agv < fleet.size(); ++agv) fleet.set_interval(agv, interval);
  }
}

void Host::next_flag() {
  if (flags_.empty()) return after_flags();
  step_ = Step::flags;
  port_->read(words_.block(flags_.front()) + words_.flag, 1, 0);
}

void Host::flag_read(Word flag) {
  const std::size_t index = flags_.front();
  if (flag == words_.flag_done) {
    step_ = Step::result;
    port_->read(words_.block(index) + words_.result, 2, 0);
    return;
  }
  TaskBlock& block = list_[index];
  if (block.seen < 0) block.seen = tick_;
  if (block.resets < 0) block.resets = resets_;
  if (gaps_.contains(job_of(index))) {
    step_ = Step::alive;
    port_->read(words_.block(index) + words_.alive, 1, 0);
    return;
  }
  block.running = tick_;
  judge();
}

void Host::next_field() {
  if (fields_.empty()) return begin_thinking();
  step_ = Step::field;
  port_->read(machine::host_devices + words_.agv_range + fields_.front() * words_.agv_range_words + words_.range_way, 1,
              0);
}

void Host::field_read(Word millimetres) {
  processes_.seen(fields_.front(), millimetres);
  fields_.pop_front();
  next_field();
}

void Host::begin_thinking() {
  step_ = Step::thinking;
  wake_at_ = now_ + nanoseconds(config_.host.refresh_overhead_ns +
                                config_.host.per_block_ns * static_cast<double>(list_.size()));
}

void Host::think() {
  if (counts_.refreshes == 1) {
    first_refresh_ = clock_.at(tick_);
    processes_.start(*this);
  }
  for (const Done& done : done_) take_out(done);
  for (const Hung& hung : hung_) recompute(hung);
  if (!servo_.on())
    servoing_from_.reset();
  else if (!servoing_from_)
    servoing_from_ = clock_.at(tick_);
  course_->servo(servoing(), clock_.at(tick_));
  if (drives_wait_too_long()) errors_.pid_silent(now_, *this);
  errors_.refresh(now_, *this);
  control_.refresh(*this);
  servo_.refresh(grown_, *this);
  processes_.refresh(*this);
  watch_wind();
  user_tasks_.refresh(*this);
  if (const auto cycle = cycles_.take_closed()) {
    Fleet& fleet = processes_.fleet();
    fleet.set_interval(cycle->agv,
                       learned_interval(config_.scheduling, fleet.interval(cycle->agv), intervals_.agv_point,
                                        static_cast<unsigned>(config_.dock.agvs), *cycle));
  }
  list_.refresh(grown_, [this](const TaskBlock& block) { return importance_of(block); });
  hold_back_long_blocks();
  write_new_blocks();
  refused_ = false;
  ledger_.list_wanted(now_);
  acquire();
}

void Host::acquire() {
  step_ = Step::semaphore;
  port_->read(words_.semaphore_list, 1, 0);
}

void Host::semaphore_read(Word taken) {
  if (holder_) take_from_holder(taken == 0);
  if (taken == 0) {
    ledger_.list_held(now_);
    if (!pointer_in_doubt_ || linked_.empty()) {
      step_ = Step::relink;
      port_->read(words_.list_work_pointer, 1, 0);
      return;
    }
    // The pointer may be wrong: reads the flag of every block that might have been claimed.
    flags_.clear();
    std::ranges::copy_if(linked_, std::back_inserter(flags_), [this](std::size_t index) { return waits(index); });
    if (flags_.empty()) return relink();
    step_ = Step::locked_flags;
    port_->read(words_.block(flags_.front()) + words_.flag, 1, 0);
    return;
  }
  if (!refused_) refused_since_ = now_;
  refused_ = true;
  if (now_ - refused_since_ <= nanoseconds(config_.watchdog.semaphore_limit_us * 1000)) return try_again();
  step_ = Step::held;
  port_->read(words_.semaphore_held + words_.semaphore_list - words_.semaphore, 1, 0);
}

// With a constant pause the host could stay in step with polling DSPs, and never find the list free. So it varies in 16
// steps of a quarter of the key's value, or of a bus clock if this is longer: accesses begin at bus clocks. Pauses that
// vary by less than a turn of all DSPs can stay in step with them on a bus that is full, so the steps grow with the
// time waited. In an ideal run no access takes time: without a pause the host would ask at one instant without an end.
void Host::try_again() {
  constexpr double shortest_ns = 1, of_waited = 1.0 / 128;
  dither_ ^= dither_ << 13, dither_ ^= dither_ >> 17, dither_ ^= dither_ << 5;
  step_ = Step::retry;
  const double clock_ns = config_.run.ideal ? 0 : 1e9 / config_.bus.clock_hz;
  const double pause_ns = config_.host.semaphore_retry_ns;
  const double waited_ns = static_cast<double>((now_ - refused_since_).count()) / 1000;
  const double step_ns =
      std::clamp(waited_ns * of_waited, std::max(pause_ns / 4, clock_ns), std::max(pause_ns / 2, 4 * clock_ns));
  const double varied_ns = pause_ns + (dither_ % 16) * step_ns;
  wake_at_ = now_ + nanoseconds(std::max(shortest_ns, varied_ns));
}

void Host::relink() {
  pointer_in_doubt_ = false;
  holder_.reset();
  list_.sort();
  linked_.clear();
  own_linked_ = false;
  list_.release_passed();
  eligible_ = 0;
  const auto order = list_.order();
  for (std::size_t i = 0; i < order.size(); ++i) {
    TaskBlock& block = list_[order[i]];
    const Word offset = words_.block(order[i]);
    const Word link = i + 1 < order.size() ? words_.block(order[i + 1]) : 0;
    const auto t = static_cast<Word>(std::min<std::int64_t>(block.t, 0xFFFF));
    if (block.flag == Flag::waiting) {
      const std::array<Word, 4> words = {t, words_.flag_waiting, block.importance,
                                         link};  // TB_T, TB_FLAG, TB_J, TB_LINK
      port_->write(offset + words_.t, words);
      if (const Word tick = tick_of(block); tick != block.task.tick) port_->write(offset + words_.tick, tick);
      linked_.push_back(order[i]);
      own_linked_ = own_linked_ || own_slot(order[i]).has_value();
      if (block.importance > 0) ++eligible_, ledger_.offered(order[i]);
    } else {
      port_->write(offset + words_.t, t);
      if (block.written_link != link) port_->write(offset + words_.link, link);
    }
    block.written_link = link;
  }
  const Word first = linked_.empty() ? 0 : words_.block(linked_.front());
  const std::array<Word, 2> head = {first, static_cast<Word>(tick_)};  // LIST_WORK_POINTER, LIST_REFRESH
  port_->write(words_.list_work_pointer, head);
  port_->write(words_.semaphore_list, Word{0});
  note(EventKind::refresh,
       {static_cast<std::uint32_t>(tick_), static_cast<std::uint32_t>(order.size()),
        static_cast<std::uint32_t>(linked_.size()), first, static_cast<std::uint32_t>(elapsed_ - 1)});
  if (config_.machine.idle_policy != IdlePolicy::doorbell) return end_refresh();
  // If no block is eligible, the host skips the doorbells. It still reads the mask of idle DSPs before a DSP's silence
  // would count as a failure.
  const bool ask = silence_limit() > 0 && liveness_.doubtful(looks(), silence_limit() / 2);
  if (eligible_ == 0 && !ask) return end_refresh();
  step_ = Step::doorbell;
  port_->read(words_.doorbell_idle, 1, 0);
}

void Host::end_refresh() {
  listener_.refreshed(clock_.at(tick_), list_.size(), now_);
  lengths_.add(static_cast<std::int64_t>(list_.size()));
  refresh_at_ = clock_.at(tick_ + 1);
  rest();
}

// ---- reports ----

void Host::process(unsigned number, bool started, Robot robot) {
  cycles_.process(config_.processes.find(number)->account, started, robot, now_);
  note(EventKind::process, {number, started ? 1U : 0U, robot, 0, 0});
}

void Host::control(Word generation, Word changed) { note(EventKind::control, {generation, changed, 0, 0, 0}); }

void Host::leg_begun(Robot robot, std::int64_t first, std::int64_t interval, std::int64_t at) {
  if (robot == 0 && processes_.crane().retrying()) return;
  course_->leg_begun(robot, first, clock_.at(at + interval) - clock_.at(at), clock_.at(at));
}

void Host::milestone(Robot robot, Milestone::Kind kind, std::int64_t number, std::int64_t at) {
  if (robot == 0 && processes_.crane().retrying()) return;
  course_->milestone(robot, kind, number, clock_.at(at));
}

void Host::note(EventKind kind, std::array<std::uint32_t, 5> arguments) {
  listener_.event({now_, report::host, kind, arguments});
}

void Host::watch_wind() {
  const bool waits = processes_.waits_for_wind();
  if (waits) wind_.waited += elapsed_;
  if (waits && !wind_.waits_now) ++wind_.waits;
  wind_.waits_now = waits;
}

void Host::add_wind(report::WindReport& wind) const {
  wind.waited = clock_.at(wind_.waited) - clock_.at(0);
  wind.waits = wind_.waits;
}

std::optional<Time> Host::refresh_under_way() const {
  const Time tick = clock_.at(tick_);
  return counts_.refreshes > 0 && refresh_at_ <= tick ? std::optional{tick} : std::nullopt;
}

report::HostReport Host::report(Time end) const {
  report::HostReport all = counts_;
  if (counts_.refreshes > 0)
    all.skipped_refreshes += static_cast<std::uint64_t>(clock_.tick_at_or_before(end - Time{1}) - tick_);
  all.list_length = lengths_.summary();
  return all;
}

}  // namespace cmrc
