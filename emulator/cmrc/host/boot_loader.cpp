#include "cmrc/host/boot_loader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "c40/peripherals/comm_port.hpp"
#include "state/visitor.hpp"

namespace cmrc {
namespace {

/// Number of words in a FIFO, from its field of the status; there, 15 means full.
std::size_t level(Word status, const c40::Field& field) {
  return std::min<std::size_t>(field.of(status), c40::Fifo::depth);
}

}  // namespace

BootLoader::BootLoader(const Words& words, std::function<std::vector<Word>(unsigned)> stream, Time limit, Time pause)
    : words_(words), stream_(std::move(stream)), limit_(limit), pause_(pause) {}

void BootLoader::expect(unsigned slot, Time now) { boots_.push_back({slot, now, now, 0, {}}); }

Time BootLoader::next() const {
  if (requested_) return Time{};
  Time next = machine::never;
  for (const Boot& boot : boots_) next = std::min(next, boot.stream.empty() ? boot.progress + limit_ : boot.due);
  return next;
}

bool BootLoader::step(Time now, machine::HostPort& port) {
  if (std::exchange(requested_, false)) {
    asked_ = Asked::request;
    port.read(words_.link_request, 1, 0);
    return true;
  }
  for (std::size_t turns = boots_.size(); turns > 0; --turns) {
    Boot& boot = boots_.front();
    if (!boot.stream.empty() && boot.due <= now) {
      asked_ = Asked::status;
      port.read(at(words_.link_status), 1, 0);
      return true;
    }
    if (boot.stream.empty() && boot.progress + limit_ <= now)
      end("it never requested its program");
    else
      std::rotate(boots_.begin(), boots_.begin() + 1, boots_.end());
  }
  return false;
}

bool BootLoader::answer(Word word, Time now, machine::HostPort& port) {
  switch (asked_) {
    case Asked::request: begin(word, now, port); return false;
    case Asked::status: return look(word, now, port);
    case Asked::answer:
      if (word == boots_.front().slot + 1)
        end({});
      else
        end(fmt::format("its program answered {:08X}h, and {:08X}h is expected", word, boots_.front().slot + 1));
      return false;
  }
  return false;
}

void BootLoader::begin(Word slots, Time now, machine::HostPort& port) {
  port.write(words_.link_request, slots);
  without_program_ |= slots;
  for (unsigned slot = 0; slot < machine::most_slots; ++slot) {
    if ((slots >> slot & 1) == 0) continue;
    std::erase_if(boots_, [&](const Boot& boot) { return boot.slot == slot; });
    boots_.push_back({slot, now, now, 0, stream_(slot)});
  }
}

bool BootLoader::look(Word status, Time now, machine::HostPort& port) {
  Boot& boot = boots_.front();
  if (level(status, c40::cpcr::INPUT_LEVEL) > 0) {
    asked_ = Asked::answer;
    port.read(at(words_.link_data), 1, 0);
    return true;
  }
  const std::size_t waiting = level(status, c40::cpcr::OUTPUT_LEVEL), room = c40::Fifo::depth - waiting;
  const std::size_t count = std::min(room, boot.stream.size() - boot.sent);
  if (count > 0) {
    port.write(at(words_.link_data), std::span(boot.stream).subspan(boot.sent, count));
    without_program_ |= Word{1} << boot.slot;
    boot.sent += count;
    boot.progress = now;
  } else if (now - boot.progress > limit_) {
    end(fmt::format("it takes no word; {} of the {} words of its program have left the link adapter",
                    boot.sent - waiting, boot.stream.size()));
    return false;
  }
  boot.due = now + pause_;
  std::rotate(boots_.begin(), boots_.begin() + 1, boots_.end());
  return false;
}

void BootLoader::end(std::string failure) {
  ended_.push_back({boots_.front().slot, std::move(failure)});
  boots_.pop_front();
}

std::vector<BootLoader::Ended> BootLoader::take_ended() { return std::exchange(ended_, {}); }

void BootLoader::list_state(state::Visitor& list) {
  list("requested", requested_);
  list("asked", asked_);
  list("boots", boots_);
  list("ended", ended_);
  list("without_program", without_program_);
}

}  // namespace cmrc
