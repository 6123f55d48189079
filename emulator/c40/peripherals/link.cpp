#include "c40/peripherals/link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace c40 {
namespace {

constexpr int bytes_per_word = 4;
// A request during the last byte of a word, after 7/8 of the word's time, is too late for this word (c40-hardware.md
// 2.6).
constexpr int last_byte_numerator = 7, last_byte_denominator = 8;

}  // namespace

std::string_view name(LinkEvent::Kind kind) {
  constexpr std::array<std::string_view, 6> names{"word", "token", "lost", "dead", "cut", "restored"};
  static_assert(names.size() == static_cast<std::size_t>(LinkEvent::Kind::restored) + 1 && names.back() == "restored",
                "one name each, in order");
  return names[static_cast<std::size_t>(kind)];
}

Link::Link(Side first, Side second, LinkParameters parameters) : parameters_(parameters) {
  if (first.port == second.port) throw std::invalid_argument(fmt::format("{} cannot be linked to itself", first.name));
  if (CommPort::token_after_reset(first.number) == CommPort::token_after_reset(second.number))
    throw std::invalid_argument(
        fmt::format("{} and {} both begin {} the token; connect one of ports 0 to 2 with one of 3 to 5", first.name,
                    second.name, CommPort::token_after_reset(first.number) ? "with" : "without"));
  const Time span = std::chrono::milliseconds{1};
  const auto a = first.clock.ticks_in(span), b = second.clock.ticks_in(span);
  if (a > 2 * b || b > 2 * a)
    throw std::invalid_argument(
        fmt::format("the clocks of {} and {} differ by more than a factor of 2", first.name, second.name));
  if (parameters.word_cycles < 1 || parameters.token_cycles < 1 || parameters.enter_cycles < 1 ||
      parameters.exit_cycles < 0)
    throw std::invalid_argument("a link's word, token and enter cycles are at least 1, its exit cycles at least 0");
  int side = 0;
  for (Side* given : {&first, &second}) {
    End& end = ends_[static_cast<std::size_t>(side)];
    end.link = this;
    end.side = side++;
    end.name = std::move(given->name);
    end.port = given->port;
    end.clock = given->clock;
    const CommPort& port = *end.port;
    end.seen = {Time::min(), port.traffic.written, port.traffic.read, port.input_halted, port.output_halted};
    if (end.wants()) end.requested = Time::min();
  }
}

void Link::End::changed(const CommPort& now, Cycles at) {
  const View view{clock.at(at + link->parameters_.enter_cycles), now.traffic.written, now.traffic.read,
                  now.input_halted, now.output_halted};
  const View& last = views.empty() ? seen : views.back();
  if (last.shows_the_same(view)) return;  // reads of the control register do not matter to the link
  views.push_back(view);
  if (link->action_ != Action::word) link->plan();
}

void Link::End::about_to_reset(Cycles at) { link->advance_to(clock.at(at)); }

// A word under way to this side is lost; what this side was sending is lost with its FIFO.
void Link::End::was_reset(const CommPort& now, Cycles at) {
  const Time time = clock.at(at);
  if (link->action_ == Action::word) link->lose_word(time);
  link->action_ = Action::none;
  End& other = link->ends_[static_cast<std::size_t>(1 - side)];
  for (const Arrival& arrival : other.arriving) {
    ++other.counters.lost;
    link->tell(LinkEvent::Kind::lost, time, other.side, arrival.word, bytes_per_word);
  }
  other.arriving.clear();
  views.clear();
  seen = {time, now.traffic.written, now.traffic.read, false, false};
  requested = never;
  has_sent = false;
  if (link->is_dead()) link->tell(LinkEvent::Kind::dead, time, side);
  link->decide(time);
  link->plan();
}

// As the link sees it, later than the chip does it. What a reset discarded is neither sent nor waiting.
inline bool Link::End::wants() const {
  const PortTraffic& t = port->traffic;
  return !seen.output_halted && seen.written > t.sent + t.discarded_output;
}

[[gnu::always_inline]] inline bool Link::can_send(const End& owner, const End& other) const {
  const PortTraffic& t = other.port->traffic;
  const std::uint64_t held = t.received + owner.arriving.size() - t.discarded_input - other.seen.read;
  return owner.wants() && !other.seen.input_halted && held < Fifo::depth;
}

// To be called after every change. What the link sees while a word is under way matters only at the end of the word.
void Link::plan() {
  next_ = action_ == Action::none ? never : ends_at_;
  for (const End& end : ends_) {
    if (!end.views.empty() && action_ != Action::word) next_ = std::min(next_, end.views.front().from);
    if (!end.arriving.empty()) next_ = std::min(next_, end.arriving.front().time);
  }
}

bool Link::only_exchanges_token() const {
  const auto quiet = [](const End& end) { return end.views.empty() && end.arriving.empty(); };
  return action_ != Action::word && quiet(ends_[0]) && quiet(ends_[1]) && !can_send(ends_[0], ends_[1]) &&
         !can_send(ends_[1], ends_[0]);
}

// What the side has done up to `time`, as the link sees it.
[[gnu::always_inline]] inline void Link::End::see(Time time) {
  while (!views.empty() && views.front().from <= time) {
    seen = views.front();
    views.pop_front();
    if (!wants())
      requested = never;
    else if (requested == never)
      requested = seen.from;
  }
}

void Link::advance_to(Time time) {
  while (next_ <= time) happen(next_);
  if (action_ == Action::word)
    for (End& end : ends_) end.see(time);
}

Time Link::lookahead() const {
  Time least = never;
  for (const End& end : ends_) {
    const int cycles = parameters_.enter_cycles + std::min(parameters_.word_cycles, parameters_.token_cycles);
    least = std::min(least, end.clock.at(cycles) - end.clock.at(0) - Time{1});  // ticks are rounded down
  }
  return least;
}

// Does everything of one instant, in an order that no observer can distinguish; then decides which side is next.
void Link::happen(Time time) {
  for (End& end : ends_) {
    while (!end.arriving.empty() && end.arriving.front().time <= time) {
      ends_[static_cast<std::size_t>(1 - end.side)].port->receive(end.arriving.front().word);
      ++end.counters.arrived;
      end.arriving.pop_front();
    }
    end.see(time);
  }
  if (action_ != Action::none && ends_at_ <= time) {
    if (action_ == Action::word) {
      finish_word(time);
    } else {
      End& end = ends_[static_cast<std::size_t>(action_side_)];
      end.port->token = true;
      end.has_sent = false;
      ++end.counters.tokens;
      ends_[static_cast<std::size_t>(1 - action_side_)].port->token = false;
      tell(LinkEvent::Kind::token, time, action_side_);
      action_ = Action::none;
    }
  }
  decide(time);
  plan();
}

void Link::finish_word(Time time) {
  End& from = ends_[static_cast<std::size_t>(action_side_)];
  const PacedClock& receiver = ends_[static_cast<std::size_t>(1 - action_side_)].clock;
  const Word word = from.port->send();
  ++from.counters.sent;
  from.has_sent = true;
  if (!from.wants()) from.requested = never;
  const Time readable = receiver.at(receiver.tick_at_or_after(time) + parameters_.exit_cycles);
  from.arriving.push_back({readable, word});
  tell(LinkEvent::Kind::word, time, from.side, word);
  if (readable <= time) {
    ends_[static_cast<std::size_t>(1 - from.side)].port->receive(word);
    ++from.counters.arrived;
    from.arriving.pop_front();
  }
  action_ = Action::none;
}

// The sender has shifted out as much as it could; the receiver drops the bytes that it has.
void Link::lose_word(Time time) {
  End& from = ends_[static_cast<std::size_t>(action_side_)];
  const int bytes = time <= begins_ ? 0 : static_cast<int>((time - begins_) * bytes_per_word / (ends_at_ - begins_));
  action_ = Action::none;
  if (from.port->output.empty()) return;  // the sender's own reset discarded the word
  const Word word = from.port->send();
  ++from.counters.sent;
  ++from.counters.lost;
  from.has_sent = true;
  if (!from.wants()) from.requested = never;
  tell(LinkEvent::Kind::lost, time, from.side, word, bytes);
}

[[gnu::always_inline]] inline void Link::begin(Action action, int side, int cycles, Time time) {
  const PacedClock& clock = ends_[static_cast<std::size_t>(side)].clock;
  const Ticks first = clock.tick_at_or_after(time);
  action_ = action;
  action_side_ = side;
  begins_ = clock.at(first);
  ends_at_ = clock.at(first + cycles);
}

void Link::decide(Time time) {
  if (cut_ || action_ != Action::none || is_dead()) return;
  const int o = ends_[0].port->token ? 0 : 1;
  const End &owner = ends_[static_cast<std::size_t>(o)], &other = ends_[static_cast<std::size_t>(1 - o)];
  const bool sendable = can_send(owner, other);
  // `ends_at_` is still the end of the last action: a request during the last byte of a word waits for one more word.
  const bool late = owner.has_sent && time == ends_at_ &&
                    other.requested >= begins_ + (ends_at_ - begins_) * last_byte_numerator / last_byte_denominator;
  if (other.requested != never && !owner.seen.input_halted && (!sendable || (owner.has_sent && !late)))
    begin(Action::token, 1 - o, parameters_.token_cycles, time);
  else if (sendable)
    begin(Action::word, o, parameters_.word_cycles, time);
}

void Link::cut(Time time) {
  advance_to(time);
  if (cut_) return;
  cut_ = true;
  tell(LinkEvent::Kind::cut, time, 0);
  if (action_ == Action::word) lose_word(time);
  action_ = Action::none;
  plan();
}

void Link::restore(Time time) {
  advance_to(time);
  if (!cut_) return;
  cut_ = false;
  tell(LinkEvent::Kind::restored, time, 0);
  decide(time);
  plan();
}

std::optional<std::string> Link::unbalanced() const {
  for (const End& from : ends_) {
    const End& to = ends_[static_cast<std::size_t>(1 - from.side)];
    const PortTraffic &mine = from.port->traffic, &theirs = to.port->traffic;
    const Counters& link = from.counters;
    const bool balanced = mine.written == mine.sent + mine.discarded_output + from.port->output.size() &&
                          mine.sent == link.sent && link.sent == link.arrived + from.arriving.size() + link.lost &&
                          link.arrived == theirs.received &&
                          theirs.received == theirs.read + theirs.discarded_input + to.port->input.size();
    if (!balanced)
      return fmt::format("words from {} do not add up: {} written, {} sent, {} arrived, {} lost, {} read", from.name,
                         mine.written, mine.sent, link.arrived, link.lost, theirs.read);
  }
  return std::nullopt;
}

void Link::tell(LinkEvent::Kind kind, Time time, int side, Word word, int bytes) {
  if (listener_of_events != nullptr) listener_of_events->happened({kind, time, side, word, bytes});
}

}  // namespace c40
