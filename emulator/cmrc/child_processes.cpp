#include "cmrc/child_processes.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <thread>

namespace cmrc {
namespace {

constexpr char good = '+', bad = '-';

[[noreturn]] void child(int pipe, const std::function<std::string(std::size_t)>& work, std::size_t index) {
  ::signal(SIGINT, SIG_DFL);
  std::string answer;
  try {
    answer = good + work(index);
  } catch (const std::exception& error) {
    answer = bad + std::string(error.what());
  }
  for (std::size_t sent = 0; sent < answer.size();) {
    const ssize_t wrote = ::write(pipe, answer.data() + sent, answer.size() - sent);
    if (wrote < 0 && errno != EINTR) break;
    if (wrote > 0) sent += static_cast<std::size_t>(wrote);
  }
  ::_exit(0);
}

/// The children that are at work; whatever happens, none is left behind.
class Children {
 public:
  ~Children() {
    for (const Child& child : children_) {
      ::kill(child.process, SIGKILL);
      ::waitpid(child.process, nullptr, 0);
      ::close(child.pipe);
    }
  }

  void start(std::size_t index, const std::function<std::string(std::size_t)>& work) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error(fmt::format("no pipe to a child process: {}", std::strerror(errno)));
    const pid_t process = ::fork();
    if (process == 0) {
      ::close(ends[0]);
      child(ends[1], work, index);
    }
    ::close(ends[1]);
    if (process < 0) {
      ::close(ends[0]);
      throw std::runtime_error(fmt::format("no child process: {}", std::strerror(errno)));
    }
    children_.push_back({index, process, ends[0], {}});
  }

  /// Waits for one to end. \returns its index and its answer.
  std::pair<std::size_t, std::string> next() {
    while (true) {
      std::vector<pollfd> pipes;
      for (const Child& child : children_) pipes.push_back({child.pipe, POLLIN, 0});
      if (::poll(pipes.data(), pipes.size(), -1) < 0 && errno != EINTR) throw std::runtime_error("no word from child processes");
      for (std::size_t i = 0; i < pipes.size(); ++i) {
        if (pipes[i].revents == 0) continue;
        char some[4096];
        const ssize_t length = ::read(pipes[i].fd, some, sizeof some);
        if (length > 0) children_[i].answer.append(some, static_cast<std::size_t>(length));
        if (length == 0) return take(i);
      }
    }
  }

  std::size_t size() const { return children_.size(); }

 private:
  struct Child {
    std::size_t index;
    pid_t process;
    int pipe;
    std::string answer;
  };

  std::pair<std::size_t, std::string> take(std::size_t place) {
    const Child ended = std::move(children_[place]);
    children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(place));
    ::close(ended.pipe);
    int status = 0;
    ::waitpid(ended.process, &status, 0);
    if (ended.answer.empty()) {
      throw std::runtime_error(WIFSIGNALED(status) ? fmt::format("a child process was ended by signal {}", WTERMSIG(status))
                                                   : "a child process ended without a word");
    }
    if (ended.answer[0] == bad) throw std::runtime_error(ended.answer.substr(1));
    return {ended.index, ended.answer.substr(1)};
  }

  std::vector<Child> children_;
};

}  // namespace

std::vector<std::string> in_processes(std::size_t count, unsigned at_once, const std::function<std::string(std::size_t)>& work,
                                      const std::function<void(std::size_t, const std::string&)>& done) {
  std::vector<std::string> answers(count);
  Children children;
  for (std::size_t next = 0; next < count || children.size() > 0;) {
    if (next < count && children.size() < std::max(1U, at_once)) {
      children.start(next++, work);
      continue;
    }
    auto [index, answer] = children.next();
    if (done) done(index, answer);
    answers[index] = std::move(answer);
  }
  return answers;
}

unsigned processors() { return std::max(1U, std::thread::hardware_concurrency()); }

}  // namespace cmrc
