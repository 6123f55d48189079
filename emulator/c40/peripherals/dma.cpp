#include "c40/peripherals/dma.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "c40/instructions/addressing.hpp"
#include "c40/peripherals/comm_port.hpp"

namespace c40 {

using namespace dma_control;
using enum DmaRegister;

namespace {

constexpr Address first_channel = 0x001000A0u, port_base = 0x00100040u;
constexpr Word start_reset = 0, start_halt_access = 1, start_halt_word = 2;
constexpr Word mode_endless = 0, mode_autoinit = 2, mode_autoinit_on_restart = 3;
constexpr Word status_held = 0, status_held_within = 1, status_busy = 3;
constexpr Word read_only = STATUS.mask() | AUX_STATUS.mask();
/// What a list overwrites in split mode: the primary half's list everything except the auxiliary half's fields; the
/// auxiliary half's list only those (c40-hardware.md 3.7).
constexpr Word auxiliary_fields = AUX_MODE.mask() | AUX_STATIC.mask() | AUX_AUTOINIT_SYNC.mask() | AUX_TCC.mask() |
                                  AUX_TCINT.mask() | AUX_START.mask();

struct Fields {
  Field start, mode, stay, list_sync, tcc, tcint, status;
};
constexpr std::array<Fields, 2> fields{
    Fields{START, MODE, STATIC, AUTOINIT_SYNC, TCC, TCINT, STATUS},
    Fields{AUX_START, AUX_MODE, AUX_STATIC, AUX_AUTOINIT_SYNC, AUX_TCC, AUX_TCINT, AUX_STATUS}};

constexpr std::array unified_list{control, source, source_index, counter, destination, destination_index, link};
constexpr std::array primary_list{control, source, source_index, counter, link};
constexpr std::array auxiliary_list{control, destination, destination_index, auxiliary_counter, auxiliary_link};

Address stepped(Address address, Word index, bool reversed) {
  using execute::reverse_bits;
  return reversed ? reverse_bits(reverse_bits(address) + reverse_bits(index)) : address + index;
}

}  // namespace

bool is_dma_register(Address address) {
  const Address offset = address - first_channel;
  return offset < 0x10u * dma_channel_count && (offset & 0xFu) < dma_register_count;
}
int dma_channel_of(Address address) { return static_cast<int>((address - first_channel) >> 4); }
DmaRegister dma_register(Address address) { return static_cast<DmaRegister>((address - first_channel) & 0xFu); }

Word Dma::start(Half h) const {
  if (h.half == 1 && !split(h.channel)) return start_reset;
  return fields[static_cast<std::size_t>(h.half)].start.of(word_of(h));
}
Word Dma::mode(Half h) const { return fields[static_cast<std::size_t>(h.half)].mode.of(word_of(h)); }

void Dma::set_start(Half h, Word value) {
  Word& word = channel(h.channel)[DmaRegister::control];
  word = fields[static_cast<std::size_t>(h.half)].start.with(word, value);
}

// An event is latched if the half that waits for it is not in reset. In split mode the primary half waits for the write
// event, and with AUTOINIT SYNC, in its list, for the read event; the auxiliary half waits for the read event.
bool Dma::latches_for(int c, bool write) const {
  const bool primary = start({c, 0}) != start_reset;
  if (write || !split(c)) return primary;
  return start({c, 1}) != start_reset || (primary && AUTOINIT_SYNC.in(channel(c)[control]));
}

Word Dma::read(int c, DmaRegister reg) const {
  Word value = channel(c)[reg];
  if (reg != control) return value;
  for (int half : {0, 1}) {
    const Half h{c, half};
    const Word status = runs(h) ? status_busy : state(h).has_data ? status_held_within : status_held;
    value = fields[static_cast<std::size_t>(half)].status.with(value, status);
  }
  return value;
}

void Dma::write(int c, DmaRegister reg, Word value, Cycles at) {
  DmaChannel& written = channel(c);
  stop_requested = true;
  if (reg != control) {
    written[reg] = value;
    return;
  }
  const Cycles first = at + timing::dma_start_cycles;
  const bool was_busy = busy();
  const std::array<Word, 2> before = starts(c);
  const std::array<bool, 2> was_ready{ready({c, 0}), ready({c, 1})};
  written[control] = value & ~read_only;
  reset_halves(c);
  start_halves(c, before, at, first);
  for (int half : {0, 1})
    if (ready({c, half}) && !was_ready[static_cast<std::size_t>(half)]) state({c, half}).first = first;
  if (!was_busy) rest_until(first);
}

// After a change of the control register. Of an access under way only the bus cycle is completed.
void Dma::reset_halves(int c) {
  DmaChannel& changed = channel(c);
  for (int half : {0, 1}) {
    const Half h{c, half};
    if (start(h) != start_reset) continue;
    if (s_.current == 2 * c + half) s_.current = -1;
    if (s_.ended == 2 * c + half) s_.ended = -1;
    state(h) = {};
    changed[counter_of(h)] = 0;
  }
  if (!latches_for(c, false)) changed.read_event = false;
  if (!latches_for(c, true)) changed.write_event = false;
}

// After a change of the control register, and of the registers that came with it. A half that was halted resumes where
// it was: within a word, or within a list.
void Dma::start_halves(int c, const std::array<Word, 2>& before, Cycles at, Cycles first) {
  bool any = false;
  for (int half : {0, 1}) {
    const Half h{c, half};
    if (start(h) != start_run || before[static_cast<std::size_t>(half)] == start_run) continue;
    any = true;
    state(h).since = at;
    if (begins_with_list(h)) begin_list(h);
    state(h).first = first;
  }
  if (any) context_.started(c, channel(c)[control], at);
}

bool Dma::begins_with_list(Half h) const {
  const bool lists = mode(h) == mode_autoinit || mode(h) == mode_autoinit_on_restart;
  return lists && channel(h.channel)[counter_of(h)] == 0 && !state(h).has_data && !state(h).listing;
}

void Dma::reset() {
  const Cycles now = s_.now;
  s_ = {};
  s_.now = now;
}

void Dma::interrupt_enable_changed(Word before, Cycles at) {
  for (int index = 0; index < 2 * dma_channel_count; ++index) {
    const Half h = half_of(index);
    if (at_rest(h.channel) || !synchronised(h)) continue;
    const bool write = state(h).has_data && !state(h).listing;
    if (event_code(h.channel, write, before) != event_code(h.channel, write))
      state(h).first = at + timing::dma_start_cycles;
  }
}

Word Dma::event_code(int c, bool write, Word die) {
  if (c < 2) return die >> (4 * c + (write ? 2 : 0)) & 3u;
  return die >> (8 + 6 * (c - 2) + (write ? 3 : 0)) & 7u;
}

bool Dma::event_ready(int c, bool write) const {
  const Word code = event_code(c, write);
  if (code == 0) return false;
  if (const auto level = context_.level(c, write, code)) return *level;
  return write ? channel(c).write_event : channel(c).read_event;
}

void Dma::take_event(int c, bool write) { (write ? channel(c).write_event : channel(c).read_event) = false; }

// Whether the half's next access waits for an event: in split mode only the port's side does (c40-hardware.md 3.6).
bool Dma::synchronised(Half h) const {
  const Word word = word_of(h);
  const DmaHalf& now = state(h);
  if (now.listing) return fields[static_cast<std::size_t>(h.half)].list_sync.in(word);
  if (now.has_data) return SYNC_WRITE.in(word) && !(split(h.channel) && h.half == 1);
  return SYNC_READ.in(word) && !(split(h.channel) && h.half == 0);
}

// Address of the next access.
Address Dma::address(Half h) const {
  const DmaChannel& c = channel(h.channel);
  const DmaHalf& now = state(h);
  if (now.listing) return now.list_at;
  const Address port = port_base + 0x10 * COM_PORT.of(word_of(h));
  if (now.has_data) return split(h.channel) && h.half == 0 ? port + 2 : c[destination];
  return split(h.channel) && h.half == 1 ? port + 1 : c[source];
}

bool Dma::runs(Half h) const {
  const Word how = start(h);
  return how == start_run || (how == start_halt_word && state(h).has_data);
}

bool Dma::ready(Half h) const {
  if (!runs(h)) return false;
  const bool write = state(h).has_data && !state(h).listing;
  if (synchronised(h) && !event_ready(h.channel, write)) return false;
  const Address next = address(h);
  return !is_port_register(next) || context_.port_ready(next, write);
}

// Rotating: the channel served last has the lowest priority. Fixed: channel 0 first. The halves of a channel take
// turns, whatever was served in between (c40-hardware.md 3.4).
std::optional<int> Dma::pick() const {
  const bool fixed = PRIORITY_MODE.in(channel(0)[control]);
  const int last = s_.last;
  const int from = fixed || last < 0 ? 0 : last / 2 + 1;
  for (int i = 0; i < dma_channel_count; ++i) {
    const int c = (from + i) % dma_channel_count;
    if (at_rest(c)) continue;
    const auto can_begin = [&](int half) { return state({c, half}).first <= s_.now && ready({c, half}); };
    if (!split(c)) {
      if (can_begin(0)) return 2 * c;
      continue;
    }
    const int first = channel(c).auxiliary_first;
    for (int half : {first, 1 - first})
      if (can_begin(half)) return 2 * c + half;
  }
  return std::nullopt;
}

bool Dma::active() const {
  if (ends()) return true;
  for (int c = 0; c < dma_channel_count; ++c)
    if (!at_rest(c) && (runs({c, 0}) || runs({c, 1}))) return true;
  return false;
}

bool Dma::busy() const {
  if (s_.waits_for_answer) return true;
  for (int c = 0; c < dma_channel_count; ++c)
    if (!at_rest(c) && (ready({c, 0}) || ready({c, 1}))) return true;
  return false;
}

namespace {
/// The timer of a code of DIE greater than 1 (fidelity.md).
std::optional<int> timer_of_event(int channel, Word code) {
  if (channel < 2) return code == 3 ? std::optional{0} : std::nullopt;
  return code >= 6 ? std::optional{static_cast<int>(code) - 6} : std::nullopt;
}
}  // namespace

std::vector<DmaWait> Dma::waits() const {
  std::vector<DmaWait> waits;
  for (int index = 0; index < 2 * dma_channel_count; ++index) {
    const Half h = half_of(index);
    if (!runs(h) || ready(h)) continue;
    DmaWait wait{.channel = h.channel,
                 .auxiliary = h.half == 1,
                 .write = state(h).has_data && !state(h).listing,
                 .address = address(h),
                 .event = {},
                 .port = {},
                 .timer = {},
                 .interrupts = fields[static_cast<std::size_t>(h.half)].tcc.in(word_of(h)) || mode(h) == mode_autoinit,
                 .stops = mode(h) != mode_endless && mode(h) != mode_autoinit,
                 .since = state(h).since};
    if (synchronised(h) && !event_ready(h.channel, wait.write)) wait.event = event_code(h.channel, wait.write);
    if (wait.event == 1u)
      wait.port = h.channel;
    else if (!wait.event)
      wait.port = port_access(wait.address, wait.write, 0, 0).port;
    else
      wait.timer = timer_of_event(h.channel, *wait.event);
    waits.push_back(wait);
  }
  return waits;
}

namespace {
std::string event_name(int channel, bool write, Word code) {
  if (code == 0) return "an event, and DIE selects none";
  if (const auto timer = timer_of_event(channel, code)) return fmt::format("timer {}", *timer);
  return fmt::format("IIOF{}", channel < 2 ? static_cast<unsigned>(2 * channel + write) : code - 2);
}
}  // namespace

std::string describe(const DmaWait& wait) {
  std::string what;
  if (!wait.port)
    what = event_name(wait.channel, wait.write, *wait.event);
  else
    what = fmt::format("{} FIFO {}", wait.write ? "room in output" : "a word in input", *wait.port);
  return fmt::format("DMA channel {}{} waits for {} ({} {:08X}h)", wait.channel, wait.auxiliary ? ", auxiliary," : "",
                     what, wait.write ? "write to" : "read of", wait.address);
}

Word Dma::ports_used() const {
  Word used = 0;
  const auto use = [&used](Address address) {
    if (is_port_register(address)) used |= 1u << port_access(address, false, 0, 0).port;
  };
  for (int c = 0; c < dma_channel_count; ++c) {
    if (at_rest(c) || (!runs({c, 0}) && !runs({c, 1}))) continue;
    const Word word = channel(c)[control];
    if (split(c)) used |= 1u << COM_PORT.of(word);
    use(channel(c)[source]);
    use(channel(c)[destination]);
    for (int half : {0, 1})
      if (state({c, half}).listing) use(state({c, half}).list_at);
    for (bool write : {false, true})
      if (event_code(c, write) == 1) used |= 1u << c;
  }
  return used;
}

Cycles Dma::last_done() const {
  Cycles last = 0;
  for (const DmaChannel& channel : s_.channels)
    for (const DmaHalf& half : channel.halves) last = std::max(last, half.since);
  return last;
}

std::optional<DmaRequest> Dma::advance_to(Cycles limit) {
  stop_requested = false;
  std::optional<DmaRequest> request;
  for (;;) {
    if (ends_at(limit)) end();
    if (s_.now >= limit || s_.waits_for_answer || stop_requested || !step(limit, request)) return request;
  }
}

void Dma::rest_until(Cycles limit) {
  if (s_.now >= limit) return;
  s_.current = -1;
  s_.now = limit;
}

void Dma::end() { end_block(half_of(std::exchange(s_.ended, std::int8_t{-1})), s_.now); }

// Does one access. False: nothing more can happen before the limit.
bool Dma::step(Cycles limit, std::optional<DmaRequest>& request) {
  if (s_.current >= 0 && (!ready(half_of(s_.current)) || state(half_of(s_.current)).first > s_.now))
    s_.current = -1;  // the half waits with its word
  if (s_.current < 0) {
    const auto next = pick();
    if (!next && busy()) {
      ++s_.now;
      return true;
    }
    if (!next) {
      if (active())
        s_.now = limit;  // else its time does not advance: how far a run continues afterwards is not part of its state
      return false;
    }
    s_.current = static_cast<std::int8_t>(*next);
  }
  const std::int8_t owner = s_.current;
  const Half h = half_of(owner);
  DmaHalf& half = state(h);
  const bool write = half.has_data && !half.listing, divided = split(h.channel);
  const Address at = address(h);
  const DmaPlace place = context_.place(at, write);
  if (place.kind == DmaPlace::Kind::nothing) {
    request = DmaRequest{h.channel, write, at, write ? half.data : 0, s_.now, true};
    return false;
  }
  const auto span = context_.acquire(place, s_.now, limit, PRI.of(word_of(h)));
  if (!span) {
    s_.now = limit;
    return false;
  }
  if (synchronised(h)) take_event(h.channel, write);
  if (place.kind == DmaPlace::Kind::window) {
    s_.waits_for_answer = true;
    s_.now = span->end;
    request = DmaRequest{h.channel, write, at, write ? half.data : 0, span->begin, false};
    return false;
  }
  Word value = 0;
  if (write)
    context_.write(at, half.data, span->begin);
  else
    value = context_.read(at, span->begin);
  if (s_.current < 0) {  // it has put itself in reset
    served(h, divided);
    s_.now = span->end;
    return true;
  }
  done(h, divided, value, span->end);
  return true;
}

void Dma::answer(Word value, Cycles at) {
  s_.waits_for_answer = false;
  s_.now = at;
  if (s_.current < 0) return;  // reset meanwhile
  const Half h = half_of(s_.current);
  done(h, split(h.channel), value, at);
}

void Dma::served(Half h, bool divided) {
  s_.last = static_cast<std::int8_t>(2 * h.channel + h.half);
  channel(h.channel).auxiliary_first = divided && h.half == 0;
}

// To be called after a half's access that ended before cycle `end`. `divided`: it began in split mode; the access
// itself may have written the control register.
void Dma::done(Half h, bool divided, Word value, Cycles end) {
  DmaChannel& c = channel(h.channel);
  DmaHalf& half = state(h);
  s_.now = half.since = end;
  served(h, divided);
  if (half.listing) {
    half.list[half.listed++] = value;
    if (!fields[static_cast<std::size_t>(h.half)].stay.in(c[control])) ++half.list_at;
    s_.now += timing::dma_list_write_cycles;
    s_.current = -1;
    if (half.listed >= (divided ? primary_list.size() : unified_list.size())) load_list(h, divided);
  } else if (!half.has_data) {
    half.has_data = true;
    half.data = value;
    if (!divided || h.half == 0) move(c[source], c[source_index], READ_BIT_REV.in(c[control]));
    --c[counter_of(h)];
  } else {
    half.has_data = false;
    if (!divided || h.half == 1) move(c[destination], c[destination_index], WRITE_BIT_REV.in(c[control]));
    if (c[counter_of(h)] == 0) s_.ended = s_.current;
    s_.current = -1;
  }
  if (start(h) == start_halt_access) s_.current = -1;
}

// A channel may come to a port by its index.
void Dma::move(Word& address, Word index, bool reversed) {
  address = stepped(address, index, reversed);
  stop_requested |= index != 0 && is_port_register(address);
}

void Dma::end_block(Half h, Cycles at) {
  Word& word = channel(h.channel)[control];
  const Fields& mine = fields[static_cast<std::size_t>(h.half)];
  word = mine.tcint.with(word, 1);
  context_.block_ended(h.channel, h.half == 1, mine.tcc.in(word), at);
  if (mode(h) == mode_autoinit)
    begin_list(h);
  else if (mode(h) != mode_endless)
    set_start(h, start_halt_word);
}

void Dma::begin_list(Half h) {
  DmaHalf& half = state(h);
  half = {.since = half.since};
  half.listing = true;
  half.list_at = channel(h.channel)[link_of(h)];
}

// The last word of a list is the new link pointer. In split mode a list changes only its own half's fields of the
// control register.
void Dma::load_list(Half h, bool divided) {
  DmaChannel& c = channel(h.channel);
  DmaHalf& half = state(h);
  const std::array<Word, 7> words = half.list;
  const std::array<Word, 2> before = starts(h.channel);
  const Word mine = !divided ? ~Word{0} : h.half == 0 ? ~auxiliary_fields : auxiliary_fields;
  half = {.since = half.since};
  c[control] = ((c[control] & ~mine) | (words[0] & mine)) & ~read_only;
  reset_halves(h.channel);
  const auto load_others = [&](const auto& order) {
    for (std::size_t i = 1; i < order.size(); ++i) c[order[i]] = words[i];
  };
  if (!divided)
    load_others(unified_list);
  else if (h.half == 0)
    load_others(primary_list);
  else
    load_others(auxiliary_list);
  if (start(h) == start_run && begins_with_list(h)) begin_list(h);
  start_halves(h.channel, before, s_.now, s_.now);
  stop_requested = true;
}

}  // namespace c40
