#include "cmrc/processes/errors.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "cmrc/tasks/importance.hpp"
#include "state/visitor.hpp"

namespace cmrc {
namespace {

constexpr Word five = 0x1F;
constexpr Word noticed = 0, decided_now = 1, done_now = 2, cleared_now = 3;  // phases in the trace's event

}  // namespace

Errors::Errors(const Config& config, const Words& words, ErrorActions& hands)
    : config_(config.errors),
      words_(words),
      hands_(hands),
      refresh_frequency_(config.rates.refresh_frequency_hz),
      servo_interval_(intervals(config).servo),
      second_sensor_(config.dock.sway_sensors == 2) {}

// To the nearest refresh: a stop is no limit that must be kept. CraneSteps::ticks rounds up.
std::int64_t Errors::ticks(double seconds) const { return std::llround(seconds * refresh_frequency_); }

bool Errors::standing() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const ErrorEntry& entry) { return entry.stands && !entry.cleared; });
}

// A load that is being set down must reach its place; so after a time-out its ramp continues.
bool Errors::must_stand() const {
  return servo_stopped_ || std::any_of(entries_.begin(), entries_.end(), [](const ErrorEntry& entry) {
           const bool of_crane = entry.origin != ErrorOrigin::block && entry.origin != ErrorOrigin::landing;
           const bool stops = entry.response == Response::stop || entry.response == Response::hold;
           return of_crane && stops && !entry.cleared;
         });
}

void Errors::tell(const ErrorEntry& entry, Word phase, HostServices& services) const {
  services.error(static_cast<Word>(number_of(entry) + 1), static_cast<Word>(entry.origin) | entry.of << words_.error_of,
                 entry.robot, phase, static_cast<Word>(entry.response));
}

// ---- noticing errors ----

void Errors::notice(ErrorEntry entry, Time now, HostServices& services) {
  entry.noticed = now;
  entry.stands = true;  // until a decision says otherwise
  known(entry.origin) |= entry.of;
  Word what = static_cast<Word>(entry.origin) | entry.of << words_.error_of;
  if (entry.tries) what |= words_.error_tries;
  if (entry.robot == 0 && hands_.crane_lowers()) what |= words_.error_lowering;
  if (second_sensor_ && sensor_ == 0) what |= words_.error_second;
  entries_.push_back(entry);
  tell(entries_.back(), noticed, services);
  Task task = task_of(JobKind::error, words_, entry.robot);
  if (entry.origin == ErrorOrigin::block) task.area = entry.lost.area;
  task.tick = static_cast<std::uint32_t>(services.tick());
  task.argument = what;
  task.error = static_cast<std::uint32_t>(entries_.size());
  services.load(task, std::nullopt);
}

// Drives that fail together for different reasons have the origin "fault", which names none of the reasons.
ErrorOrigin Errors::trip_of(Word errors) const {
  switch (errors >> words_.pide_trip & 7) {
    case 1: return ErrorOrigin::overspeed;
    case 2: return ErrorOrigin::saturation;
    case 4: return ErrorOrigin::heat;
    default: return ErrorOrigin::fault;
  }
}

void Errors::pid_says(Word errors, std::uint32_t tick, Time now, HostServices& services) {
  struct Row {
    ErrorOrigin origin;
    Word place;
    Word mask;
  };
  const Row rows[] = {{ErrorOrigin::fault, words_.pide_fault, five},
                      {ErrorOrigin::late, words_.pide_late, five},
                      {ErrorOrigin::encoder, words_.pide_encoder, five},
                      {ErrorOrigin::following, words_.pide_following, five},
                      {ErrorOrigin::sway, words_.pide_sway, 3}};
  for (const Row& row : rows) {
    const Word seen = errors >> row.place & row.mask;
    const Word fresh = seen & ~known(row.origin);
    if (fresh == 0) continue;
    if (row.origin == ErrorOrigin::sway && tick <= sway_after_) continue;
    if (row.origin == ErrorOrigin::late && tick <= late_after_) continue;
    ErrorEntry entry{.origin = row.origin == ErrorOrigin::fault ? trip_of(errors) : row.origin, .of = fresh};
    entry.sensor = sensor_;
    entry.tries = row.origin == ErrorOrigin::late && timeouts_ < config_.timeout_retries_max;
    notice(std::move(entry), now, services);
  }
}

void Errors::pid_silent(Time now, HostServices& services) {
  if (known(ErrorOrigin::late) != 0 || path_.target() == 0 || wanted_) return;
  notice({.origin = ErrorOrigin::late, .of = five, .tries = timeouts_ < config_.timeout_retries_max}, now, services);
}

void Errors::landing_missed(bool tries, Time now, HostServices& services) {
  notice({.origin = ErrorOrigin::landing, .tries = tries}, now, services);
}

void Errors::given_up(const Task& lost, bool tries, Time now, HostServices& services) {
  notice({.origin = ErrorOrigin::block, .of = lost.kind, .robot = lost.robot, .lost = lost, .tries = tries}, now,
         services);
  known(ErrorOrigin::block) = 0;  // each is an error of its own
}

// ---- decisions ----

void Errors::decided(const Task& block, Word result, Time now, HostServices& services) {
  ErrorEntry& entry = entries_.at(block.error - 1);
  entry.decided = now;
  entry.response = static_cast<Response>(result >> words_.respond_place & 0xF);
  entry.waits = false;
  tell(entry, decided_now, services);
  carry_out(entry, now, services);
  clear_when_asked(now, services);
}

void Errors::undecided(const Task& block, Time now, HostServices& services) {
  ErrorEntry& entry = entries_.at(block.error - 1);
  entry.waits = false;
  without_decision(entry);
  clear_when_asked(now, services);
}

// No DSP has decided: the drives' time-out brakes.
void Errors::without_decision(const ErrorEntry& entry) {
  if (entry.origin == ErrorOrigin::block) return stop_work(entry);
  if (entry.origin == ErrorOrigin::landing) return hands_.landing_decided(false);
  hands_.stop_servo(true);
  hands_.hold_crane(true);
  servo_stopped_ = true;
  go_to_rate(0, 0);
}

void Errors::stop_work(const ErrorEntry& entry) {
  if (!hands_.stop_work(entry.lost)) return;
  servo_stopped_ = true;
  hands_.hold_crane(true);
  go_to_rate(0, 0);
}

void Errors::go_to_rate(double rate, double seconds) { wanted_ = Wanted{rate, seconds}; }

void Errors::carry_out(ErrorEntry& entry, Time now, HostServices& services) {
  const bool of_drives = is_fault(entry.origin) || entry.origin == ErrorOrigin::encoder;
  if (of_drives) drives_ &= ~entry.of, drives_changed_ = true;
  switch (entry.response) {
    case Response::stop:
      if (entry.origin == ErrorOrigin::block) {
        stop_work(entry);
        return finish(entry, now, services);
      }
      hands_.hold_crane(true);
      if (path_.target() != 0 || (wanted_ && wanted_->rate != 0)) go_to_rate(0, config_.stop_s);
      break;
    case Response::hold:
      if (entry.origin == ErrorOrigin::landing) {
        hands_.landing_decided(false);
        return finish(entry, now, services);
      }
      hands_.hold_crane(true);
      if (entry.origin == ErrorOrigin::late) drives_ = 0, drives_changed_ = true;
      go_to_rate(0, 0);
      break;
    case Response::set_down: hands_.set_crane_down(true); break;
    case Response::retry:
      known(entry.origin) &= ~entry.of;
      if (entry.origin != ErrorOrigin::late) {
        if (entry.origin == ErrorOrigin::landing)
          hands_.landing_decided(true);
        else
          hands_.ask_again(entry.lost);
        entry.stands = false;
        return finish(entry, now, services);
      }
      // After a short gap the joints still move: their brakes stop them before the set-point and the drives hold them.
      ++timeouts_;
      late_after_ = services.tick();
      hands_.hold_crane(true);
      if (wanted_ || path_.rate(services.tick()) != 0) go_to_rate(0, 0);
      drives_changed_ = true;
      go_on_at_ = services.tick() + ticks(std::max(config_.stop_s, 1.0));
      break;
    case Response::second_sensor:
      entry.stands = false;
      known(ErrorOrigin::sway) = 0;
      sensor_ = 1;
      sway_after_ = services.tick() + servo_interval_;
      services.write(words_.cr_base + words_.cr_sway_sensor, sensor_);
      return finish(entry, now, services);
    case Response::none: without_decision(entry); break;
  }
}

void Errors::finish(ErrorEntry& entry, Time now, HostServices& services) {
  entry.done = now;
  tell(entry, done_now, services);
}

// ---- continuing ----

void Errors::refresh(Time now, HostServices& services) {
  const bool due = go_on_at_ && services.tick() >= *go_on_at_, goes_on = due && !must_stand();
  if (due) drives_changed_ = true;
  if (goes_on) {
    hands_.hold_crane(false);
    go_to_rate(1, config_.go_on_s);
  }
  if ((wanted_ || drives_changed_) && services.servo_resting()) {
    if (wanted_)
      path_.change(services.tick(), wanted_->rate, ticks(wanted_->seconds));
    else
      path_.change(services.tick(), path_.target(), std::max<std::int64_t>(0, path_.reached() - services.tick()));
    wanted_.reset();
    drives_changed_ = false;
    services.write(words_.cr_base + words_.cr_path, path_.words(go_on_at_ && !due ? 0 : drives_));
    services.write(words_.cr_base + words_.cr_stopped, Word{1});
  }
  if (due && wanted_is_written() && !drives_changed_) go_on_at_.reset();
  for (ErrorEntry& entry : entries_) {
    if (entry.done || entry.cleared || !entry.decided) continue;
    const bool stood = wanted_is_written() && path_.target() == 0 && services.tick() >= path_.reached();
    if ((entry.response == Response::stop || entry.response == Response::hold) && stood) finish(entry, now, services);
    if (entry.response == Response::retry && goes_on && wanted_is_written()) {
      entry.stands = false;
      finish(entry, now, services);
    }
    if (entry.response == Response::set_down && hands_.crane_is_down()) finish(entry, now, services);
  }
}

void Errors::clear(Time now, HostServices& services) {
  clear_decided(now, services);
  clears_ = std::ranges::any_of(entries_, &ErrorEntry::waits) ? entries_.size() : 0;
}

// An error that was noticed after the operator's order, and waits for its block, is not cleared.
void Errors::clear_when_asked(Time now, HostServices& services) {
  if (clears_ == 0 || std::ranges::any_of(std::span(entries_).first(clears_), &ErrorEntry::waits)) return;
  clears_ = 0;
  clear_decided(now, services);
}

void Errors::clear_decided(Time now, HostServices& services) {
  bool crane = false;
  for (ErrorEntry& entry : entries_) {
    if (entry.cleared || entry.waits) continue;
    if (entry.response == Response::second_sensor) {
      sensor_ = 0;
      sway_after_ = services.tick() + servo_interval_;
      services.write(words_.cr_base + words_.cr_sway_sensor, sensor_);
    } else if (!entry.stands) {
      continue;
    } else if (entry.origin == ErrorOrigin::block) {
      hands_.resume_work(entry.lost);
    } else if (entry.origin == ErrorOrigin::landing) {
      hands_.landing_again();
    } else {
      crane = true;
    }
    entry.cleared = now;
    known(entry.origin) &= entry.origin == ErrorOrigin::block ? 0U : ~entry.of;
    tell(entry, cleared_now, services);
  }
  timeouts_ = 0;
  if (servo_stopped_) {
    hands_.stop_servo(false);
    servo_stopped_ = false;
    late_after_ = services.tick() +
                  2 * servo_interval_;  // the drives have timed out meanwhile, and work again from the first codes on
    crane = true;
  }
  if (!crane) return;
  hands_.set_crane_down(false);
  drives_ = five;
  drives_changed_ = true;
  if (go_on_at_) return;
  hands_.hold_crane(false);
  go_to_rate(1, config_.go_on_s);
}

void Errors::list_state(state::Visitor& list) {
  list("entries", entries_);
  list("clears", clears_);
  list("path", path_);
  list("wanted", wanted_);
  list("drives", drives_);
  list("drives_changed", drives_changed_);
  list("known", known_);
  list("sensor", sensor_);
  list("sway_after", sway_after_);
  list("late_after", late_after_);
  list("servo_stopped", servo_stopped_);
  list("timeouts", timeouts_);
  list("go_on_at", go_on_at_);
}

}  // namespace cmrc
