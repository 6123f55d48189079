#include "debugger/dap_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace debugger::dap {
namespace {

// The only requests that end running work; all others wait for a stop, or come between two slices.
const std::vector<std::string_view> urgent{"\"pause\"", "\"disconnect\"", "\"terminate\""};

Ended converse(Connection& connection, Session& session) {
  session.meanwhile = [&] {
    machine::debug::Debugger* debugger = session.debugger();
    if (debugger == nullptr) return;
    if (session.runs() ? connection.waiting() : connection.waits_with(urgent)) debugger->interrupt();
  };
  while (!session.over()) {
    if (session.runs() && !connection.waiting()) {
      session.run_on();
      continue;
    }
    const auto message = connection.receive();
    if (!message) break;
    session.handle(*message);
  }
  return {session.over() && session.terminates(), connection.broken()};
}

}  // namespace

Ended serve(int in, int out, Launch launch) {
  Connection connection(in, out);
  Session session([&](const Json& message) { connection.send(message); }, std::move(launch));
  return converse(connection, session);
}

Ended serve(int in, int out, machine::debug::Debugger& debugger) {
  Connection connection(in, out);
  Session session([&](const Json& message) { connection.send(message); }, debugger);
  return converse(connection, session);
}

Listener::Listener(int port) {
  if (port < 0 || port > 65535)
    throw std::system_error(EINVAL, std::generic_category(), fmt::format("port {}: 0 to 65535 are possible", port));
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);  // the way of the sockets interface
  if (socket_ < 0 || bind(socket_, generic, size) != 0 || listen(socket_, 1) != 0 ||
      getsockname(socket_, generic, &size) != 0) {
    const int why = errno;
    if (socket_ >= 0) close(socket_);
    throw std::system_error(
        why, std::generic_category(),
        fmt::format("port {} of this machine cannot be used; another one, or 0 for any, is expected", port));
  }
  port_ = ntohs(address.sin_port);
}

Listener::~Listener() { close(socket_); }

bool Listener::has_client() const {
  pollfd waiting{socket_, POLLIN, 0};
  return poll(&waiting, 1, 0) > 0;
}

int Listener::accept() { return ::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC); }

}  // namespace debugger::dap
