#include "bus_model/bridge.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace pci {

Bridge::Bridge(Bus& bus, const MasterConfig& master, const BridgeConfig& config, Client& client)
    : bus_{bus}, client_{client}, config_{config}, master_{bus.add_master(master, *this)} {
  if (config_.post_depth < 1 || config_.post_depth > most_posted)
    throw std::invalid_argument{"bridge of " + master.name + ": post_depth is 1 to 64 words"};
  if (config_.request_sync < 1 || config_.return_sync < 0)
    throw std::invalid_argument{"bridge of " + master.name +
                                ": request_sync is at least 1 clock and return_sync at least 0"};
  if (config_.prefetch_words == 0) config_.prefetch_words = 1;
  if (!std::has_single_bit(config_.prefetch_words) || config_.prefetch_words > line_.size())
    throw std::invalid_argument{"bridge of " + master.name + ": prefetch_words is a power of two up to 64, or 0"};
  if (config_.prefetch_words > 1 && master.latency_timer < 24 + static_cast<Clocks>(config_.prefetch_words))
    throw std::invalid_argument{"bridge of " + master.name +
                                ": a line of prefetch_words has to fit into latency_timer; take at least "
                                "prefetch_words + 24 clocks, or a shorter line"};
}

void Bridge::push(const Posted& posted, Clocks earliest) {
  fifo_[(head_ + count_) % most_posted] = posted;
  count_ += 1;
  if (!busy_) submit_write(earliest);
}

void Bridge::write(const Posted& posted) {
  line_words_ = 0;
  if (has_room()) {
    push(posted, bus_.now());
    return;
  }
  waiting_ = posted;
  blocked_ = Blocked::room;
  blocked_since_ = posted.clock;
  seen_ = 0;
  blocked_without_bus_ = 0;
}

void Bridge::read(Address address, Clocks clock, Clocks seen) {
  if (address >= config_.prefetch_limit) line_words_ = 0;
  blocked_ = Blocked::read;
  read_address_ = address;
  blocked_since_ = clock;
  seen_ = seen;
  blocked_without_bus_ = 0;
  if (!busy_ && count_ == 0) submit_read(bus_.now());
}

void Bridge::submit_write(Clocks earliest) {
  const Posted& first = entry(0);
  busy_ = true;
  bus_.submit(master_, true, first.address, 1, std::max(earliest, first.clock + config_.request_sync));
}

void Bridge::submit_read(Clocks earliest) {
  answered_ = false;
  const bool line = read_address_ < config_.prefetch_limit;
  const unsigned words = line ? config_.prefetch_words - (read_address_ & (config_.prefetch_words - 1)) : 1;
  busy_ = true;
  bus_.submit(master_, false, read_address_, words, std::max(earliest, blocked_since_ + config_.request_sync), true);
}

unsigned Bridge::framed(const Attempt& attempt, bool first, Clocks now, std::span<Word> room) {
  if (blocked() && now >= seen_)
    blocked_without_bus_ += attempt.frame - std::min(attempt.frame, std::max(attempt.requested, blocked_since_));
  if (!attempt.write || !first) return attempt.wanted;
  // Words issued in this clock wait for a later step: the processor may issue more of them in the same clock.
  unsigned words = 0;
  while (words < count_ && entry(words).address == attempt.address + words &&
         (words == 0 || entry(words).clock < now)) {
    room[words] = entry(words).value;
    words += 1;
  }
  in_flight_ = words;
  return words;
}

void Bridge::answer(Word value, Clocks ready, Result result) {
  answered_ = true;
  blocked_ = Blocked::no;
  client_.answered(value, ready, std::min(blocked_without_bus_, ready - blocked_since_), result);
}

void Bridge::arriving(const Attempt& attempt, std::span<const Word> words) {
  line_address_ = attempt.address;
  line_words_ = static_cast<unsigned>(words.size());
  line_first_ = attempt.first + 1 + config_.return_sync;
  line_step_ = attempt.step;
  std::copy(words.begin(), words.end(), line_.begin());
  answer(words[0], line_first_, Result::done);
}

void Bridge::completed(const Transaction& transaction, std::span<const Word> words) {
  const Clocks now = transaction.ended;
  busy_ = false;
  if (!transaction.write) {
    if (!answered_) answer(words[0], now + config_.return_sync, transaction.result);
  } else {
    const unsigned done = transaction.words;
    const Result result = transaction.result;
    const unsigned gone = in_flight_;
    in_flight_ = 0;
    for (unsigned i = 0; i < gone; ++i) {
      const Posted posted = entry(0);
      head_ = (head_ + 1) % most_posted;
      count_ -= 1;
      client_.landed(posted, now, i < done ? Result::done : result);
    }
    if (blocked_ == Blocked::room) {
      Posted posted = waiting_;
      posted.clock = std::max(posted.clock, now);
      blocked_ = Blocked::no;
      push(posted, now);
      client_.taken(posted.clock, std::min(blocked_without_bus_, posted.clock - blocked_since_));
    }
  }
  if (busy_) return;
  if (count_ != 0)
    submit_write(now);
  else if (blocked_ == Blocked::read)
    submit_read(now);
}

void Bridge::clear(Clocks now) {
  const unsigned moved = bus_.withdraw(master_, now);
  for (unsigned i = 0; i < std::min(moved, in_flight_); ++i) client_.landed(entry(i), now, Result::done);
  head_ = count_ = in_flight_ = 0;
  busy_ = false;
  blocked_ = Blocked::no;
  line_words_ = 0;
}

void Bridge::list_state(state::Visitor& list) {
  list("fifo", fifo_);
  list("head", head_);
  list("count", count_);
  list("in flight", in_flight_);
  list("busy", busy_);
  list("answered", answered_);
  list("blocked", blocked_);
  list("read address", read_address_);
  list("blocked since", blocked_since_);
  list("seen", seen_);
  list("blocked without bus", blocked_without_bus_);
  list("waiting", waiting_);
  list("line address", line_address_);
  list("line words", line_words_);
  list("line first", line_first_);
  list("line step", line_step_);
  list("line", line_);
}

}  // namespace pci
