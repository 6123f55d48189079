#include "report/event_log.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace report {
namespace {

static_assert(std::endian::native == std::endian::little, "events are hashed as they lie in memory");

constexpr std::size_t batch = 4096;

void check(int ok, const char* what) {
  if (ok != 1) throw std::runtime_error(fmt::format("libcrypto: {} failed", what));
}

using Context = std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)>;

Context new_context() {
  Context context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  if (!context) throw std::bad_alloc();
  return context;
}

std::string finished(EVP_MD_CTX* context) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  check(EVP_DigestFinal_ex(context, digest, &size), "EVP_DigestFinal_ex");
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

bool comes_before(const Event& left, const Event& right) {
  return left.time != right.time ? left.time < right.time : left.component < right.component;
}

}  // namespace

struct EventLog::Digest {
  Context context = new_context();

  Digest() { check(EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr), "EVP_DigestInit_ex"); }
  void update(const void* data, std::size_t size) {
    check(EVP_DigestUpdate(context.get(), data, size), "EVP_DigestUpdate");
  }
};

std::string sha256(std::string_view text) {
  const Context context = new_context();
  check(EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr), "EVP_DigestInit_ex");
  check(EVP_DigestUpdate(context.get(), text.data(), text.size()), "EVP_DigestUpdate");
  return finished(context.get());
}

EventLog::EventLog() : digest_(std::make_unique<Digest>()) { pending_.reserve(2 * batch); }
EventLog::~EventLog() = default;
EventLog::EventLog(EventLog&&) noexcept = default;
EventLog& EventLog::operator=(EventLog&&) noexcept = default;

void EventLog::add(const Event& event) {
  if (event.time < settled_)
    throw std::logic_error(
        fmt::format("event after its time was settled at {} ps: {}", settled_.count(), to_text(event)));
  pending_.push_back(event);
  ++count_;
}

void EventLog::settle(Time time) {
  settled_ = std::max(settled_, time);
  if (pending_.size() >= drain_at_) drain(settled_);
}

void EventLog::flush() { drain(Time::max()); }

void EventLog::absorb(std::span<const std::byte> bytes) {
  flush();
  digest_->update(bytes.data(), bytes.size());
}

void EventLog::listen(EventSink& sink) {
  drain(settled_);
  sinks_.push_back(&sink);
}

std::string EventLog::hash() const {
  Context copy = new_context();
  check(EVP_MD_CTX_copy_ex(copy.get(), digest_->context.get()), "EVP_MD_CTX_copy_ex");
  return finished(copy.get());
}

std::string EventLog::hash_with(std::span<const std::byte> bytes) const {
  std::vector<Event> rest = pending_;
  std::ranges::stable_sort(rest, comes_before);
  Context copy = new_context();
  check(EVP_MD_CTX_copy_ex(copy.get(), digest_->context.get()), "EVP_MD_CTX_copy_ex");
  check(EVP_DigestUpdate(copy.get(), rest.data(), rest.size() * sizeof(Event)), "EVP_DigestUpdate");
  check(EVP_DigestUpdate(copy.get(), bytes.data(), bytes.size()), "EVP_DigestUpdate");
  return finished(copy.get());
}

void EventLog::drain(Time until) {
  if (!std::ranges::is_sorted(pending_, comes_before)) std::ranges::stable_sort(pending_, comes_before);
  const auto end = until == Time::max()
                       ? pending_.end()
                       : std::ranges::lower_bound(pending_, until, {}, [](const Event& event) { return event.time; });
  const auto settled = std::span(pending_.begin(), end);
  if (!settled.empty()) digest_->update(settled.data(), settled.size_bytes());
  for (EventSink* sink : sinks_)
    for (const Event& event : settled) sink->event(event);
  pending_.erase(pending_.begin(), end);
  drain_at_ =
      pending_.size() + batch;  // each event is looked at a bounded number of times, however far chips run ahead
}

}  // namespace report
