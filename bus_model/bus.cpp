#include "bus_model/bus.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "bus_model/bus_parts.hpp"

namespace pci {

namespace {

constexpr Clocks subtractive_clocks = 4;  // if no target has asserted DEVSEL# by then: master abort
constexpr unsigned nobody = Arbiter::nobody;

}  // namespace

Command Bus::command_of(bool write, Address address, unsigned words) const {
  if (write) return Command::write;
  if (words <= 2) return Command::read;
  return (address & (config_.line_words - 1)) + words <= config_.line_words ? Command::read_line
                                                                            : Command::read_multiple;
}

void Bus::submit(unsigned master, bool write, Address address, unsigned words, Clocks request, bool speculative) {
  Port& port = port_of(master);
  submit(port, master, command_of(write, address, words), address, words, request, port.config.agent,
         speculative && !write);
}

void Bus::submit(unsigned master, Command command, Address address, unsigned words, Clocks request, unsigned agent) {
  submit(port_of(master), master, command, address, words, request, agent, false);
}

// requests_ is as long as ports_, and tells its length without a division.
[[gnu::always_inline]] inline Bus::Port& Bus::port_of(unsigned master) {
  return master < requests_.size() ? ports_[master] : ports_.at(master);
}

[[gnu::always_inline]] inline void Bus::submit(Port& port, unsigned master, Command command, Address address,
                                               unsigned words, Clocks request, unsigned agent, bool speculative) {
  if (port.active)
    throw std::logic_error{"pci::Bus::submit: master " + port.config.name + " already has a transaction"};
  if (words == 0 || words > most_words)
    throw std::invalid_argument{"pci::Bus::submit: a transaction has 1 to 256 words"};
  if (request < now_) throw std::logic_error{"pci::Bus::submit: a request in the past"};
  port.transaction = Transaction{.address = address,
                                 .words = words,
                                 .master = static_cast<std::uint16_t>(master),
                                 .write = is_write(command),
                                 .command = command,
                                 .agent = static_cast<std::uint16_t>(agent),
                                 .requested = request};
  port.agent = agent;
  port.wanted = words;
  port.done = 0;
  port.active = true;
  port.speculative = speculative;
  port.attempted = false;
  ask(master, request);
  if (finishing_) return;  // the end of the present step chooses the next master
  const Clocks before = next_;
  if (running_)
    cut_by_timer();
  else
    plan_idle(earliest_request(nobody));
  if (next_ != before) tell_plan();
}

inline void Bus::ask(unsigned master, Clocks request) {
  requests_[master] = request;
  asking_ |= 1u << master;
}

inline void Bus::ask_no_more(unsigned master) {
  requests_[master] = never;
  asking_ &= ~(1u << master);
}

inline Clocks Bus::earliest_request(unsigned except) const {
  Clocks earliest = never;
  const std::uint32_t others = except == nobody ? asking_ : asking_ & ~(1u << except);
  for (std::uint32_t rest = others; rest != 0; rest &= rest - 1)
    earliest = std::min(earliest, requests_[static_cast<std::size_t>(std::countr_zero(rest))]);
  return earliest;
}

// The arbiter's choice among the masters that request the bus by clock `latest`.
inline unsigned Bus::winner(Clocks latest) const {
  std::uint32_t asking = 0;
  for (std::uint32_t rest = asking_; rest != 0; rest &= rest - 1) {
    const int master = std::countr_zero(rest);
    asking |= std::uint32_t{requests_[static_cast<std::size_t>(master)] <= latest} << master;
  }
  if ((asking & (asking - 1)) != 0) return arbiter_.pick(asking, latest);
  return asking != 0 ? static_cast<unsigned>(std::countr_zero(asking)) : nobody;
}

// An idle bus goes to the first master that requests it, at clock `requested`. If several request it in the same clock,
// the master that already has the grant comes first, then the arbiter's choice.
void Bus::plan_idle(Clocks requested) {
  chosen_ = nobody;
  next_ = never;
  if (requested == never) return;
  // Masters that wait through a stall are arbitrated at the end of the stall.
  const Clocks first = std::max(requested, stalled_ - config_.grant_clocks);
  const unsigned held = arbiter_.parked();
  chosen_at_ = first;
  if (held != nobody && requests_[held] == first && first >= stalled_) {
    chosen_ = held;
    const bool no_turnaround = config_.fast_back_to_back && after_write_ && held == arbiter_.last_owner();
    next_ = std::max(first, no_turnaround ? free_ - 1 : free_);
  } else {
    chosen_ = winner(first);
    next_ = std::max(first + config_.grant_clocks, free_);
    chosen_at_ = next_ - 1;
  }
}

// A master's accesses mostly go where its last one went.
inline int Bus::window_of(Address address, int last) const {
  const auto holds = [&](const Window& window) {
    return address >= window.base && address - window.base < window.words;
  };
  if (last >= 0 && holds(windows_[static_cast<std::size_t>(last)])) return last;
  for (std::size_t i = 0; i < windows_.size(); ++i)
    if (holds(windows_[i])) return static_cast<int>(i);
  return -1;
}

inline Access Bus::access_of(const Port& port, Clocks clock) const {
  return {attempt_.master, clock, port.agent, attempt_.command};
}

// Books the idle clocks before `clock` that are not booked yet, of a bus on which no attempt runs.
inline void Bus::count_idle(BusStatistics& statistics, Clocks clock) const {
  const Clocks from = std::max(free_, counted_);
  if (clock <= from) return;
  const Clocks asked = clock - std::clamp(earliest_request(nobody), from, clock);
  statistics.idle_requested += asked;
  statistics.idle += clock - from - asked;
}

void Bus::start(unsigned master, Clocks granted, Clocks frame) {
  Port& port = ports_[master];
  if (frame < free_)
    statistics_.turnaround += frame - free_;  // fast back-to-back
  else
    count_idle(statistics_, frame);
  attempt_ = Attempt{.master = static_cast<std::uint16_t>(master),
                     .write = port.transaction.write,
                     .command = port.transaction.command,
                     .address = port.transaction.address + port.done,
                     .wanted = port.wanted - port.done,
                     .requested = requests_[master],
                     .frame = frame};
  port.transaction.waited += frame - requests_[master];
  ask_no_more(master);
  const bool first = !port.attempted;
  if (first) {
    port.attempted = true;
    port.transaction.number = started_++;
    port.transaction.framed = frame;
    port.transaction.granted = std::clamp(granted, port.transaction.requested, frame);
    port.statistics.arbitration += port.transaction.granted - port.transaction.requested;
    port.statistics.acquisition += frame - port.transaction.granted;
    port.statistics.wait.add(frame - port.transaction.requested);
  }
  const unsigned wanted = port.initiator->framed(attempt_, first, now_, port.data);
  if (first && port.transaction.write) {
    port.wanted = attempt_.wanted = std::min(wanted, most_words);
    port.transaction.words = port.wanted;
  }
  arbiter_.granted(master, frame);
  running_ = true;
  ahead_ = false;
  attempt_.target = static_cast<std::int16_t>(window_of(attempt_.address, port.last_target));
  if (attempt_.target < 0) {
    attempt_.kind = Attempt::Kind::master_abort;
    attempt_.last = frame + subtractive_clocks;
    next_ = attempt_.last + 1;
    return;
  }
  Window& window = windows_[static_cast<unsigned>(attempt_.target)];
  port.transaction.target = port.last_target = attempt_.target;
  choose_answer(window, port);
  if (attempt_.kind != Attempt::Kind::data) {
    attempt_.last = frame + window.config.devsel;
    next_ = attempt_.last + 1;
    return;
  }
  attempt_.first = frame + (attempt_.write ? window.config.devsel + window.config.write_initial
                                           : std::max(window.config.devsel, 2) + window.config.read_initial);
  attempt_.step = 1 + (attempt_.write ? window.config.write_step : window.config.read_step);
  if (port.done == 0) {
    port.transaction.first_data = attempt_.first;
    port.statistics.target += attempt_.first - frame;
  }
  ends_itself_ = port.config.max_burst != 0 && port.config.max_burst < attempt_.words;
  if (ends_itself_) attempt_.words = port.config.max_burst;
  natural_words_ = attempt_.words;
  if (natural_words_ == 1) {
    attempt_.last = attempt_.first;
    next_ = attempt_.last + 1;
    return;
  }
  cut_by_timer();
  if (attempt_.write) return;
  ahead_ = true;
  const std::span<Word> words = std::span{port.data}.subspan(port.done, natural_words_);
  window.target->read_burst(attempt_.address - window.base, words, access_of(port, attempt_.first), attempt_.step);
  port.initiator->arriving(attempt_, words.first(attempt_.words));
}

// How many words the target fetches for the attempt's delayed read.
unsigned Bus::fetched_ahead(const TargetConfig& config) const {
  const unsigned chosen = attempt_.command == Command::read        ? config.prefetch.read
                          : attempt_.command == Command::read_line ? config.prefetch.line
                                                                   : config.prefetch.multiple;
  return chosen == 0 ? most_words : chosen;
}

// Whether the target takes the attempt, and how many words of it.
[[gnu::always_inline]] inline void Bus::choose_answer(Window& window, const Port& port) {
  const TargetConfig& config = window.config;
  const Address offset = attempt_.address - window.base;
  attempt_.words = static_cast<unsigned>(std::min<std::uint64_t>(attempt_.wanted, window.words - offset));
  if (window.takes_all) [[likely]]
    return;
  if (config.max_burst != 0) attempt_.words = std::min(attempt_.words, config.max_burst);
  const Access access = access_of(port, attempt_.frame);
  const Answer answer = window.target->answer(offset, attempt_.words, attempt_.write, access);
  if (answer != Answer::accept) {
    attempt_.kind = answer == Answer::retry ? Attempt::Kind::retry : Attempt::Kind::target_abort;
    attempt_.words = 0;
    return;
  }
  attempt_.words = std::min(attempt_.words, window.target->most(offset, attempt_.words, attempt_.write, access));
  if (attempt_.write && config.post_words != 0) {
    const Clocks queued =
        std::max<Clocks>(0, window.drained - attempt_.frame + config.post_drain - 1) / config.post_drain;
    const Clocks room = static_cast<Clocks>(config.post_words) - queued;
    if (room <= 0)
      attempt_.kind = Attempt::Kind::retry, attempt_.words = 0;
    else
      attempt_.words = std::min(attempt_.words, static_cast<unsigned>(room));
  }
  if (!attempt_.write && config.delayed_read) {
    const bool abandoned = window.fetching && attempt_.frame > window.fetch_ready + discard_clocks;
    const bool mine = window.fetching && !abandoned && window.fetch_master == attempt_.master &&
                      window.fetch_address == attempt_.address;
    if (mine && attempt_.frame + config.devsel >= window.fetch_ready) {
      window.fetching = false;
      attempt_.words = std::min(attempt_.words, window.fetch_words);
      return;
    }
    if (!window.fetching || abandoned) {
      window.fetching = true;
      window.fetch_master = attempt_.master;
      window.fetch_address = port.transaction.address + port.done;
      window.fetch_words = fetched_ahead(config);
      window.fetch_ready = std::max(attempt_.frame + config.devsel, window.drained) + config.fetch;
    }
    attempt_.kind = Attempt::Kind::retry;
    attempt_.words = 0;
  }
}

// PCI 2.1: once the latency timer has run out and GNT# has gone to another, the transaction stops with its next data
// phase; Memory Write and Invalidate with the last one of its line.
void Bus::cut_by_timer() {
  if (attempt_.kind != Attempt::Kind::data) return;
  attempt_.last = attempt_.first + (natural_words_ - 1) * attempt_.step;
  attempt_.words = natural_words_;
  const Clocks timer_ends = attempt_.frame + ports_[attempt_.master].config.latency_timer;
  const Clocks other = attempt_.last > timer_ends ? earliest_request(attempt_.master) : never;
  if (other != never) {
    Clocks stop = std::max(timer_ends, other + 1);
    if (config_.multi_transaction_timer > 0) stop = std::max(stop, arbiter_.kept_until());
    if (attempt_.last > stop) {
      const Clocks before = stop <= attempt_.first ? 0 : (stop - attempt_.first + attempt_.step - 1) / attempt_.step;
      attempt_.words = static_cast<unsigned>(before) + 1;
      if (attempt_.command == Command::write_invalidate) {
        const Address end = attempt_.address + attempt_.words;
        attempt_.words = std::min(natural_words_, attempt_.words + ((0 - end) & (config_.line_words - 1)));
      }
      attempt_.last = attempt_.first + (attempt_.words - 1) * attempt_.step;
    }
  }
  next_ = attempt_.last + 1;
}

[[gnu::always_inline]] inline void Bus::move_words(Port& port, unsigned words) {
  if (words == 0) return;
  Window& window = windows_[static_cast<unsigned>(attempt_.target)];
  const Address offset = attempt_.address - window.base;
  const Access access = access_of(port, now_);
  if (attempt_.write) {
    for (unsigned i = 0; i < words; ++i) window.target->write(offset + i, port.data[port.done + i], access);
    window.statistics.words_written += words;
    port.statistics.words_written += words;
    if (window.config.post_words != 0)
      window.drained = std::max(window.drained, attempt_.first) + words * window.config.post_drain;
  } else {
    if (!ahead_) port.data[port.done] = window.target->read(offset, access);
    window.statistics.words_read += words;
    port.statistics.words_read += words;
  }
  port.done += words;
}

// Books `length` clocks of an attempt with `words` data phases, without the turnaround.
inline void Bus::account(Clocks words, Clocks length) {
  statistics_.address += 1;
  statistics_.data += words;
  statistics_.wait += length - 1 - words;
  statistics_.turnaround += 1;
}

void Bus::finish() {
  Port& port = ports_[attempt_.master];
  const Clocks last = attempt_.last;
  running_ = false;
  finishing_ = true;
  after_write_ = attempt_.write;
  free_ = last + 2;
  account(attempt_.words, last + 1 - attempt_.frame);
  port.statistics.owned += free_ - attempt_.frame;
  move_words(port, attempt_.words);
  if (attempt_monitor_ != nullptr) attempt_monitor_->attempted(attempt_);

  const bool aborted = attempt_.kind == Attempt::Kind::master_abort || attempt_.kind == Attempt::Kind::target_abort;
  if (aborted || port.done == port.wanted || (port.speculative && port.done > 0)) {
    Transaction& transaction = port.transaction;
    if (aborted) [[unlikely]] {
      transaction.result = attempt_.kind == Attempt::Kind::master_abort ? Result::master_abort : Result::target_abort;
      port.statistics.aborts += 1;
      if (!transaction.write) std::fill(port.data.begin() + port.done, port.data.begin() + port.wanted, ~Word{0});
    }
    port.statistics.transactions += 1;
    transaction.words = port.done;
    transaction.ended = last + 1;
    port.active = false;
    if (monitor_ != nullptr) monitor_->ended(transaction);
    port.initiator->completed(transaction, std::span<const Word>{port.data}.first(port.wanted));
  } else if (attempt_.kind == Attempt::Kind::retry) {
    port.transaction.retries += 1;
    port.statistics.retries += 1;
    windows_[static_cast<unsigned>(attempt_.target)].statistics.retries += 1;
    ask(attempt_.master, free_ + port.config.request_off_after_stop + port.config.think_on_retry);
  } else if (attempt_.words < natural_words_) {
    port.statistics.timer_stops += 1;
    ask(attempt_.master, last + 1);  // its own REQ# stays asserted; another master has the grant
  } else if (ends_itself_) {
    ask(attempt_.master, last);  // its REQ# has been asserted all the time
  } else {
    port.transaction.disconnects += 1;
    port.statistics.disconnects += 1;
    ask(attempt_.master, free_ + port.config.request_off_after_stop);
  }
  finishing_ = false;
  arbitrate(last);
}

// Hidden arbitration: a master that requested the bus by the last data phase starts right after the turnaround.
[[gnu::always_inline]] inline void Bus::arbitrate(Clocks last) {
  if (asking_ == 0) {
    chosen_ = nobody;
    next_ = never;
    return;
  }
  const Clocks requested = earliest_request(nobody);
  if (requested <= last && free_ >= stalled_)
    start(winner(last), last, free_);
  else
    plan_idle(requested);
}

DirectWindow Bus::window_at(Address address) const {
  const int found = window_of(address, -1);
  if (found < 0) return {};
  const Window& window = windows_[static_cast<std::size_t>(found)];
  return {*window.target, window.base, window.words};
}

void Bus::stall(Clocks now, Clocks until) {
  now_ = std::max(now_, now);
  stalled_ = std::max(stalled_, until);
  was_stalled_ = true;
  if (!running_) plan_idle(earliest_request(nobody));
  tell_plan();
}

void Bus::advance_to(Clocks clock) {
  while (next_ <= clock) step();
  now_ = std::max(now_, clock);
}

unsigned Bus::withdraw(unsigned master, Clocks now) {
  Port& port = ports_.at(master);
  if (!port.active) return 0;
  now_ = std::max(now_, now);
  port.active = false;
  if (!running_) count_idle(statistics_, now_), counted_ = now_;
  ask_no_more(master);
  Transaction& transaction = port.transaction;
  transaction.result = Result::withdrawn;
  if (running_ && attempt_.master == master) {
    const Clocks end = std::max(now_, attempt_.frame + 1);  // FRAME# and IRDY# are released here
    unsigned words = 0;
    if (attempt_.kind == Attempt::Kind::data && end > attempt_.first)
      words = std::min(attempt_.words, static_cast<unsigned>((end - 1 - attempt_.first) / attempt_.step) + 1);
    running_ = false;
    after_write_ = false;
    free_ = end + 1;
    account(words, end - attempt_.frame);
    port.statistics.owned += free_ - attempt_.frame;
    move_words(port, words);
    attempt_.words = words;
    attempt_.last = end - 1;
    if (attempt_monitor_ != nullptr) attempt_monitor_->attempted(attempt_);
    transaction.words = port.done;
    transaction.ended = end;
    if (monitor_ != nullptr) monitor_->ended(transaction);
    arbitrate(end - 1);
  } else {
    transaction.words = port.done;
    transaction.ended = now_;
    if (monitor_ != nullptr) monitor_->ended(transaction);
    if (running_)
      cut_by_timer();
    else
      plan_idle(earliest_request(nobody));
  }
  tell_plan();
  return transaction.words;
}

void Bus::list_state(state::Visitor& list) {
  list("arbiter", arbiter_);
  for (Port& port : ports_) list(port.config.name, port);
  list("requests", requests_);
  if (list.loads()) {
    asking_ = 0;
    for (unsigned i = 0; i < requests_.size(); ++i) asking_ |= unsigned{requests_[i] != never} << i;
  }
  for (Window& window : windows_) list(window.config.name, window);
  list("attempt", attempt_);
  list("running", running_);
  list("ahead", ahead_);
  list("after write", after_write_);
  list("chosen", chosen_);
  list("chosen at", chosen_at_);
  list("natural words", natural_words_);
  list("ends itself", ends_itself_);
  list("was stalled", was_stalled_);
  list("now", now_);
  list("free", free_);
  list("counted", counted_);
  list("stalled", stalled_);
  list("next", next_);
  list("started", started_);
  list("statistics", statistics_);
}

std::uint64_t Bus::words_moved() const { return static_cast<std::uint64_t>(statistics_.data); }

BusStatistics Bus::statistics(Clocks clock) const {
  BusStatistics result = statistics_;
  if (!running_) {
    if (clock < free_)
      result.turnaround -= free_ - clock;
    else
      count_idle(result, clock);
    return result;
  }
  if (clock <= attempt_.frame) {
    result.turnaround -= attempt_.frame - clock;
    return result;
  }
  Clocks data = 0;
  if (attempt_.kind == Attempt::Kind::data && clock > attempt_.first)
    data = std::min<Clocks>(attempt_.words, (clock - 1 - attempt_.first) / attempt_.step + 1);
  result.address += 1;
  result.data += data;
  result.wait += clock - attempt_.frame - 1 - data;
  return result;
}

}  // namespace pci
