#include "report/events/event_log.hpp"

// The plain SHA-256 functions: an unfinished hash is saved and loaded as its numbers, and EVP does not show them.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <fmt/format.h>
#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "state/visitor.hpp"

namespace report {
namespace {

static_assert(std::endian::native == std::endian::little, "events are hashed as they lie in memory");

constexpr std::size_t batch = 4096;

void check(int ok, const char* what) {
  if (ok != 1) throw std::runtime_error(fmt::format("libcrypto: {} failed", what));
}

struct Sha256 {
  SHA256_CTX context{};

  Sha256() { check(SHA256_Init(&context), "SHA256_Init"); }
  void update(const void* data, std::size_t size) { check(SHA256_Update(&context, data, size), "SHA256_Update"); }
  std::string text() const {
    SHA256_CTX copy = context;
    std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
    check(SHA256_Final(digest.data(), &copy), "SHA256_Final");
    std::string text;
    for (const unsigned byte : digest) text += fmt::format("{:02x}", byte);
    return text;
  }
  void list_state(state::Visitor& list) {
    std::array<SHA_LONG, 8> words = std::to_array(context.h);
    std::array<SHA_LONG, 2> bits{context.Nl, context.Nh};
    std::string begun(reinterpret_cast<const char*>(context.data),
                      context.num);  // bytes of the unfinished block
    list("words", words);
    list("bits", bits);
    list("begun", begun);
    if (!list.loads()) return;
    if (begun.size() >= SHA256_CBLOCK)
      throw state::StateError(
          fmt::format("the hash under way has {} bytes of a block; 0 to 63 are possible", begun.size()));
    *this = Sha256();
    std::ranges::copy(words, context.h);
    context.Nl = bits[0];
    context.Nh = bits[1];
    context.num = static_cast<unsigned>(begun.size());
    std::memcpy(context.data, begun.data(), begun.size());
  }
};

bool comes_before(const Event& left, const Event& right) {
  return left.time != right.time ? left.time < right.time : left.component < right.component;
}

}  // namespace

struct EventLog::Digest : Sha256 {};

EventLog::EventLog() : digest_(std::make_unique<Digest>()), pending_(2 * batch) {}
EventLog::~EventLog() = default;
EventLog::EventLog(EventLog&&) noexcept = default;
EventLog& EventLog::operator=(EventLog&&) noexcept = default;

void EventLog::add_with_room(const Event& event) {
  if (event.time < settled_)
    throw std::logic_error(
        fmt::format("event after its time was settled at {} ps: {}", settled_.count(), to_text(event)));
  if (discards_) return;
  pending_.resize(2 * pending_.size() + batch);
  add(event);
}

void EventLog::discard() {
  flush();
  pending_ = {};
  discards_ = true;
}

void EventLog::settle(Time time) {
  settled_ = std::max(settled_, time);
  if (waiting_ >= drain_at_) drain(settled_);
}

void EventLog::deliver(Time time) {
  settled_ = std::max(settled_, time);
  drain(settled_);
}

void EventLog::flush() { drain(Time::max()); }

void EventLog::listen(EventSink& sink) {
  drain(settled_);
  sinks_.push_back(&sink);
}

std::string EventLog::hash() const { return digest_->text(); }

std::string EventLog::hash_with(std::span<const std::byte> bytes) const {
  const auto first = pending_.begin();
  std::vector<Event> rest(first, first + static_cast<std::ptrdiff_t>(waiting_));
  std::ranges::stable_sort(rest, comes_before);
  Digest copy = *digest_;
  copy.update(rest.data(), rest.size() * sizeof(Event));
  copy.update(bytes.data(), bytes.size());
  return copy.text();
}

void EventLog::drain(Time until) {
  const std::span<Event> all = waiting();
  if (!std::ranges::is_sorted(all, comes_before)) std::ranges::stable_sort(all, comes_before);
  const auto end = until == Time::max()
                       ? all.end()
                       : std::ranges::lower_bound(all, until, {}, [](const Event& event) { return event.time; });
  const auto settled = std::span(all.begin(), end);
  if (!settled.empty()) digest_->update(settled.data(), settled.size_bytes());
  std::erase_if(sinks_, [&](EventSink* sink) {
    try {
      for (const Event& event : settled) sink->event(event);
      return false;
    } catch (const std::exception&) {
      sink->failed();
      return true;
    }
  });
  std::ranges::copy(end, all.end(), all.begin());
  waiting_ -= settled.size();
  drain_at_ = waiting_ + batch;  // each event is sorted a bounded number of times, however far chips run ahead
}

void EventLog::list_state(state::Visitor& list) {
  if (!list.loads()) {
    drain(settled_);
    std::ranges::stable_sort(waiting(), comes_before);
    pending_.resize(waiting_);
  }
  list("digest", static_cast<Sha256&>(*digest_));
  list("pending", pending_);
  list("settled", settled_);
  list("count", count_);
  waiting_ = pending_.size();
  if (list.loads()) drain_at_ = waiting_ + batch;
}

}  // namespace report
