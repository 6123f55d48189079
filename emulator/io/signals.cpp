#include "io/signals.hpp"

#include <unistd.h>

#include <array>
#include <mutex>
#include <utility>

namespace io {
namespace {

constexpr std::array<int, 3> taken = {SIGINT, SIGTERM, SIGHUP};

volatile std::sig_atomic_t noted = 0;
volatile std::sig_atomic_t noting = 0;  // number of living StopBySignal objects
std::mutex temporaries_change;          // for threads; the signal handler does not lock it
TemporaryName* temporaries = nullptr;

void on_signal(int number) {
  if (noting > 0 && noted == 0) {
    noted = number;
    return;
  }
  remove_temporaries();
  ::_exit(128 + number);
}

::sigset_t taken_set() {
  ::sigset_t set;
  sigemptyset(&set);
  for (const int number : taken) sigaddset(&set, number);
  return set;
}

}  // namespace

void take_signals() {
  for (const int number : taken) {
    struct ::sigaction action{};
    if (::sigaction(number, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = on_signal;
    action.sa_mask = taken_set();
    action.sa_flags = SA_RESTART;  // reads and writes under way continue; the work checks for a stop at its slices
    ::sigaction(number, &action, nullptr);
  }
  // A write beyond `ulimit -f`, or into a pipe that nobody reads any more, fails, and the error names the file.
  ::signal(SIGXFSZ, SIG_IGN);
  ::signal(SIGPIPE, SIG_IGN);
}

StopBySignal::StopBySignal() : asker_([] { return noted != 0; }) {
  noted = 0;
  noting = noting + 1;
}

StopBySignal::~StopBySignal() { noting = noting - 1; }

int StopBySignal::status(int otherwise) const { return noted == 0 ? otherwise : 128 + noted; }

SignalsHeld::SignalsHeld() {
  const ::sigset_t set = taken_set();
  ::pthread_sigmask(SIG_BLOCK, &set, &before_);
}

SignalsHeld::~SignalsHeld() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

void ignore_signals() {
  for (const int number : taken) ::signal(number, SIG_IGN);
}

TemporaryName::TemporaryName(std::string name) : path(std::move(name)) {
  const std::lock_guard lock(temporaries_change);
  next_ = std::exchange(temporaries, this);
}

TemporaryName::~TemporaryName() {
  const std::lock_guard lock(temporaries_change);
  TemporaryName** at = &temporaries;
  while (*at != this) at = &(*at)->next_;
  *at = next_;
}

void remove_temporaries() {
  for (const TemporaryName* name = temporaries; name != nullptr; name = name->next_) ::unlink(name->path.c_str());
}

}  // namespace io
