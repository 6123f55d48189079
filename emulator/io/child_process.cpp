#include "io/child_process.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include "io/reason.hpp"
#include "io/signals.hpp"

namespace io {
namespace {

constexpr char good = '+', bad = '-';
constexpr int look_ms = 100;  // interval between two looks at whether the work has to stop

[[noreturn]] void child(int pipe, const std::function<std::string()>& work) {
  std::string answer;
  try {
    answer = good + work();
  } catch (const std::exception& error) {
    answer = bad + std::string(reason(error));
  }
  for (std::size_t sent = 0; sent < answer.size();) {
    const ssize_t wrote = ::write(pipe, answer.data() + sent, answer.size() - sent);
    if (wrote < 0 && errno != EINTR) break;
    if (wrote > 0) sent += static_cast<std::size_t>(wrote);
  }
  ::_exit(0);
}

}  // namespace

ChildProcess::ChildProcess(const std::function<std::string()>& work) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error(fmt::format("no pipe to a child process: {}", std::strerror(errno)));
  const pid_t parent = ::getpid();
  // The parent handles signals and ends the child; no signal may come before the child ignores signals.
  std::optional<SignalsHeld> held(std::in_place);
  process_ = ::fork();
  if (process_ == 0) {
    ::close(ends[0]);
    ignore_signals();
    forget_asker();
    held.reset();
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // the parent died before this process could be tied to it
    child(ends[1], work);
  }
  held.reset();
  ::close(ends[1]);
  pipe_ = ends[0];
  if (process_ < 0) {
    ::close(pipe_);
    throw std::runtime_error(fmt::format("no child process: {}", std::strerror(errno)));
  }
}

ChildProcess::~ChildProcess() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(pipe_);
}

bool ChildProcess::read() {
  char some[65536];
  const ssize_t length = ::read(pipe_, some, sizeof some);
  if (length > 0) answer_.append(some, static_cast<std::size_t>(length));
  return length > 0 || (length < 0 && errno == EINTR);
}

bool ChildProcess::speaks(int milliseconds) const {
  pollfd pipe{pipe_, POLLIN, 0};
  return ::poll(&pipe, 1, milliseconds) > 0;
}

std::string ChildProcess::wait() {
  do {
    while (!speaks(look_ms)) stop_if_asked();
  } while (read());
  int status = 0;
  ::waitpid(std::exchange(process_, 0), &status, 0);
  if (answer_.empty()) {
    throw std::runtime_error(WIFSIGNALED(status)
                                 ? fmt::format("a child process was ended by signal {}", WTERMSIG(status))
                                 : "a child process ended without an answer");
  }
  if (answer_[0] == bad) throw std::runtime_error(answer_.substr(1));
  return answer_.substr(1);
}

}  // namespace io
